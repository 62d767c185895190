"""Fits of the friction laws: they find what a record was made of, and meet the targets on the measured one."""

import numpy as np
import pytest

from benchmarks.friction import laws
from benchmarks.friction.picture import draw

BY_NAME = {law.name: law for law in laws.LAWS}


def made(name, *values, cycles=4):
    """A record of a law along a cycle with rests, with an offset of 0.1 N."""
    way = np.concatenate([np.linspace(0.0, 2e-4, 120), np.full(40, 2e-4), np.linspace(2e-4, 0.0, 120), np.zeros(40)])
    position = np.tile(way, cycles)
    velocity, period = np.diff(position) / 0.005, np.full(position.size - 1, 0.005)
    force = laws.force_along(BY_NAME[name].make(*values), velocity, period) + 0.1
    return laws.PreslidingRecord(period, position[1:], velocity, force)


@pytest.mark.parametrize(("name", "values"), [("LuGre", (2.0, 4e4)), ("elasto-plastic", (2.0, 1.3e-4))])
def test_fit_finds_the_parameters_that_a_record_was_made_with(name, values):
    fit = laws.fit_law(BY_NAME[name], made(name, *values))
    assert list(fit.values.values()) == pytest.approx([*values, 0.1], rel=1e-3)
    assert fit.tested < 1e-3


def test_law_that_is_not_the_records_leaves_an_error():
    record = made("elasto-plastic", 2.0, 1.3e-4)
    coulomb = laws.fit_coulomb(record)
    assert laws.fit_law(BY_NAME["LuGre"], record).tested > 0.01
    assert laws.fit_lagged(record).tested < coulomb.tested
    error = coulomb.force - record.force
    assert coulomb.tested == pytest.approx(np.sqrt(np.mean(error[error.size // 2 :] ** 2)), rel=1e-12)


def test_play_takes_flicker_out_and_keeps_motion():
    position = np.array([0.0, 1e-7, 0.0, 1e-7, 5e-6, 5e-6, 4.9e-6, 0.0])
    assert laws.without_flicker(position, 2e-7) == pytest.approx([0.0, 0.0, 0.0, 0.0, 4.8e-6, 4.8e-6, 4.8e-6, 2e-7])


@pytest.mark.skipif(not laws.DATA.is_file(), reason="the measured record is not beside this repository")
def test_laws_meet_the_targets_on_the_measured_record():
    record = laws.read_record()
    assert 0.2e-3 < np.ptp(record.position) < 0.3e-3
    every = record.part(slice(None, 8000))
    fits = [
        laws.fit_coulomb(every),
        *(laws.fit_law(BY_NAME[name], every) for name in ("LuGre", "rolling", "elasto-plastic")),
    ]
    shares = {fit.law: fit.tested / fits[0].tested for fit in fits}
    assert shares["LuGre"] < 0.5
    assert shares["rolling"] < 0.5
    assert shares["elasto-plastic"] < 0.25
    figure = draw(every, fits)
    assert [axes.get_title().partition(":")[0] for axes in figure.axes][6:10] == [fit.law for fit in fits]
