"""The open-loop score on a joint that is known."""

from dataclasses import replace

import numpy as np
import pytest

from adaptive_ff import InputError
from adaptive_ff.adaptive.learning.map_settings import map_parameters
from adaptive_ff.identify.open_loop import shrinkage, structures
from adaptive_ff.identify.open_loop.mean import (
    Validated,
    held_out_squares,
    mean_model,
    mean_of_all,
    shares_of,
)
from adaptive_ff.identify.open_loop.score import Choice, choose_mean, score_log
from adaptive_ff.identify.open_loop.shrinkage import fit_path
from adaptive_ff.identify.open_loop.simulation import OpenLoopModel, Record
from adaptive_ff.identify.open_loop.slopes import Training, errors_and_slopes, parameters_of, with_parameters
from adaptive_ff.logs.log import Log

PERIOD = 0.002


def test_constant_torque_against_viscous_friction_is_the_closed_form():
    """``J w' + sigma w = u - Fc``: the speed goes to ``(u - Fc)/sigma`` with the time constant ``J/sigma``."""
    time = PERIOD * np.arange(1000)
    final, lag = (5.0 - 1.0) / 2.0, 0.5 / 2.0
    exact = final * (time - lag * (1.0 - np.exp(-time / lag)))
    record = Record(exact, np.zeros(1000), np.full(1000, 5.0), PERIOD)
    model = OpenLoopModel(0.5, 1.0, 2.0, 0.0, 0.0, 1.0, np.zeros(1))
    assert np.max(np.abs(model.errors(record, np.array([0]), 1000))) < 2.0 * final * PERIOD


def test_force_over_position_is_interpolated_and_offsets_add_up():
    record = Record(np.zeros(50), np.zeros(50), np.full(50, 3.0), PERIOD)
    still = OpenLoopModel(1.0, 0.1, 1.0, 0.0, -1.0, 1.0, np.array([2.0, 4.0]))  # 3 N m at zero
    assert np.all(still.errors(record, np.array([0]), 50) == 0.0)
    moved = still._replace(force=np.array([0.0, 2.0]))
    assert moved.errors(record, np.array([0]), 50)[0, -1] > 0.0


def test_velocity_alone_is_refused():
    time = PERIOD * np.arange(2000)
    log = Log("log", time, np.sin(time), velocity=np.sin(time))
    with pytest.raises(InputError, match="a score takes a position"):
        score_log(log, log)


def test_friction_over_position_is_the_controllers_map():
    """At rest on a slope of friction: the force holds where friction is high, and moves the joint where it is low."""
    variation = map_parameters((1.0,), 0, None, 0.0, 1.0)
    model = OpenLoopModel(1.0, 2.0, 0.0, 0.0, 0.0, 1.0, np.zeros(1), variation, np.array([0.5, 0.0]))
    high, low = (Record(np.full(50, place), np.zeros(50), np.full(50, 2.5), PERIOD) for place in (0.0, 0.5))
    assert np.all(model.errors(high, np.array([0]), 50) == 0.0)  # Coulomb friction of 3 N m
    assert model.errors(low, np.array([0]), 50)[0, -1] > 0.0  # of 1 N m
    assert model.to_dict()["friction_map"]["position_periods"] == pytest.approx([1.0])


def test_a_map_is_chosen_where_the_other_record_needs_it(monkeypatch):
    monkeypatch.setattr(structures, "KNOTS", (1,))
    train, test = (_log(0.4, seed) for seed in (101, 102))
    with_map = score_log(train, test, position_periods=(0.5,))
    assert with_map.chosen.mapped == 2
    assert with_map.model.coefficients == pytest.approx([0.0, 0.4], abs=0.05)
    assert with_map.rms < 0.5 * score_log(train, test).rms


def test_progress_rises_with_every_block_to_one(monkeypatch):
    monkeypatch.setattr(structures, "KNOTS", (1, 3))
    monkeypatch.setattr(structures, "WEIGHTS", (1.0,))
    shares = []
    score_log(_log(0.0, 101), _log(0.0, 102), progress=shares.append)
    assert len(shares) == 4 * structures.BLOCKS
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)


def test_slopes_are_those_of_difference_quotients():
    model, record = _wavy(), _record_of(_wavy())
    training = Training(record, np.array([100, 2000]), 1500, 20)
    slopes = errors_and_slopes(model, training, 10)[1]
    parameters = parameters_of(model)
    for place, value in enumerate(parameters):
        step = 1e-5 * max(abs(value), 0.1)
        sides = []
        for side in (step, -step):
            moved = parameters.copy()
            moved[place] += side
            sides.append(errors_and_slopes(with_parameters(model, moved), training, 10)[0])
        quotient = (sides[0] - sides[1]) / (2.0 * step)
        assert slopes[:, place] == pytest.approx(quotient, abs=1e-3 * np.max(np.abs(quotient)))


def test_motion_that_is_fitted_is_nearly_that_of_the_model():
    record = _record_of(_wavy())
    fitted = errors_and_slopes(_wavy(), Training(record, np.array([0]), 5000, 20), 10)[0]
    assert np.max(np.abs(fitted)) < 0.01 * np.std(record.position)


def test_fit_finds_the_model_that_made_the_log_and_shrinkage_takes_detail_away():
    true = _wavy()._replace(coefficients=np.empty(0), variation=OpenLoopModel._field_defaults["variation"])
    record = _record_of(true)
    training = Training(record, np.array([0, 1250, 2500, 3750]), 1250, 20)
    begin = true._replace(inertia=0.6, coulomb=0.8, viscous=2.4, viscous_asymmetry=0.0, force=np.zeros(4))
    strong, weak = fit_path(begin, training, (100.0, 1e-4), by_direction=True)
    assert parameters_of(weak.model)[:4] == pytest.approx(parameters_of(true)[:4], rel=0.03)
    assert weak.model.force == pytest.approx(true.force, abs=0.1)
    assert np.ptp(strong.model.force) < 0.5 * np.ptp(weak.model.force)
    assert 5.0 < strong.parameters < weak.parameters <= 8.0
    fixed = fit_path(begin, training, (1.0,), by_direction=False)[0].model
    assert fixed.viscous_asymmetry == 0.0


@pytest.mark.parametrize("by_direction", [False, True])
def test_fit_goes_on_where_friction_would_drive_the_joint(by_direction):
    """A joint without viscous friction: where a step would make it negative, all else still moves."""
    true = OpenLoopModel(0.5, 1.0, 0.0, 0.0, -1.0, 1.0, np.array([0.3]))
    record = _record_of(true)
    begin = true._replace(inertia=0.6, coulomb=1.3, force=np.zeros(1))
    training = Training(record, np.array([0, 2500]), 2500, 20)
    fitted = fit_path(begin, training, (0.0,), by_direction=by_direction)[0].model
    assert fitted.coulomb == pytest.approx(1.0, rel=0.03)
    assert fitted.inertia == pytest.approx(0.5, rel=0.03)
    assert fitted.viscous >= abs(fitted.viscous_asymmetry)


@pytest.mark.parametrize(("samples", "period"), [(190, 0.01), (400, 0.06)])
def test_logs_that_are_too_short_or_too_coarse_to_be_simulated_are_refused(samples, period):
    time = period * np.arange(samples)
    log = Log("log", time, np.sin(time), position=np.sin(time))
    with pytest.raises(InputError, match="not enough for a score"):
        score_log(log, log)


def test_fewest_effective_parameters_within_a_standard_error_are_chosen():
    squares = {20.0: (1.0, 1.2, 0.8, 1.1), 10.0: (1.1, 1.0, 1.3, 0.9), 5.0: (2.0, 2.1, 1.9, 2.2)}
    choices = [Choice(np.sqrt(np.mean(row)), row, 0, count) for count, row in squares.items()]
    assert choose_mean(choices).parameters == 10.0


def test_shares_are_those_of_the_pseudo_likelihood():
    """With B blocks, ``<E>^(-B/2)``: of three blocks, four times the square has an eighth of the share."""
    squares = np.array([[1.0, 2.0, 3.0], [8.0, 8.0, 8.0]])
    assert shares_of(squares) == pytest.approx([8.0 / 9.0, 1.0 / 9.0])
    assert shares_of(1e-30 * squares) == pytest.approx(shares_of(squares))
    assert shares_of(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]])) == pytest.approx([0.5, 0.0, 0.5])


def test_mean_of_an_offset_and_a_force_over_position():
    offset = OpenLoopModel(1.0, 2.0, 3.0, 0.0, -1.0, 1.0, np.array([0.4]))
    force = OpenLoopModel(2.0, 4.0, 1.0, 0.5, -1.0, 1.0, np.array([0.0, 1.0, 2.0]))
    mean = mean_model([offset, force], np.array([0.75, 0.25]))
    assert parameters_of(mean) == pytest.approx([1.25, 2.5, 2.5, 0.125, 0.3, 0.55, 0.8])
    with pytest.raises(ValueError, match="2 knots"):
        mean_model([force, force._replace(force=np.zeros(2))], np.array([0.5, 0.5]))


def test_a_mean_is_held_out_with_the_shares_of_the_other_blocks():
    """Of two models, one is right in the first block and the other in the second: each counts where it is wrong."""
    record = _record_of(_wavy())
    right, wrong = _wavy(), _wavy()._replace(inertia=0.7)
    pairs = (right, wrong), (wrong, right)
    squares = np.array([[np.mean(_unseen(pair[b], record, b) ** 2) for b in range(2)] for pair in pairs])
    structures = [
        Validated(4, True, 0.0, pair, tuple(left), 9.0) for pair, left in zip(pairs, squares.tolist(), strict=True)
    ]
    for block, left in enumerate(held_out_squares(structures, record, 2500, 20)):
        shares = squares[:, 1 - block] ** -0.5 / np.sum(squares[:, 1 - block] ** -0.5)  # of one block
        inertia = shares @ [pair[block].inertia for pair in pairs]
        assert inertia > 0.69
        assert left == pytest.approx(np.mean(_unseen(right._replace(inertia=inertia), record, block) ** 2))
    mean, shares = mean_of_all(structures)
    assert sum(shares) == pytest.approx(1.0)
    assert mean.inertia == pytest.approx(0.6)  # of each structure both fits count


def test_models_that_validate_alike_have_no_winner():
    """Which of two is better by 1e-12 is decided by the last digits; the mean of both does not change with it."""
    pair = [_wavy(), _wavy()._replace(inertia=0.7)]
    for squares in ((1.0, 1.0 + 1e-12), (1.0 + 1e-12, 1.0)):
        structures = [
            Validated(4, True, 0.0, (model,) * 5, (left,) * 5, 9.0) for model, left in zip(pair, squares, strict=True)
        ]
        assert mean_of_all(structures)[0].inertia == pytest.approx(0.6, rel=1e-9)


def test_change_of_the_last_digits_changes_the_result_little(monkeypatch):
    """A log changed by 1e-12, and fits of twice the steps, where the joint rests more than half of the time."""
    monkeypatch.setattr(structures, "KNOTS", (1, 17))
    train, test = _sticking(1), _sticking(2)
    assert np.mean(np.diff(train.position) == 0.0) > 0.5
    noise = 1.0 + 1e-12 * np.random.default_rng(3).standard_normal((2, train.time.size))
    moved = replace(train, position=noise[0] * train.position, torque=noise[1] * train.torque)
    found = score_log(train, test)
    again = [score_log(moved, test)]
    monkeypatch.setattr(shrinkage, "STEPS", 2 * shrinkage.STEPS)
    again.append(score_log(train, test))
    for other in again:
        assert np.std(other.simulated - found.simulated) < 0.03 * found.rms
        assert other.chosen.error == pytest.approx(found.chosen.error, rel=0.03)


def test_torque_that_acts_late_is_simulated_so(monkeypatch):
    monkeypatch.setattr(structures, "KNOTS", (1,))
    late = 5  # rows
    train, test = (_delayed(_log(0.0, seed), late) for seed in (101, 102))
    told, untold = (score_log(train, test, torque_delay=delay) for delay in (late * PERIOD, 0.0))
    assert told.rms < 0.2 * untold.rms
    assert told.model.inertia == pytest.approx(0.5, rel=0.01)


def test_what_was_done_about_a_log_is_said(monkeypatch):
    monkeypatch.setattr(structures, "KNOTS", (1,))
    train, test = _log(0.0, 101), _log(0.0, 102)
    test.torque[2000] = np.nan
    found = score_log(train, test)
    assert found.cautions == found.to_dict()["warnings"] == ["log: 1 row left out: no finite number in the torque"]


def test_score_on_the_log_that_it_is_trained_on_is_said_to_tell_nothing(monkeypatch):
    monkeypatch.setattr(structures, "KNOTS", (1,))
    log = _log(0.0, 101)
    (caution,) = score_log(log, replace(log, name="copy")).cautions
    assert caution.startswith("copy: is the log that the model is trained on")


@pytest.mark.parametrize("delay", [np.nan, np.inf, 1.5])
def test_delay_that_no_drive_has_is_refused(delay):
    with pytest.raises(InputError, match=r"torque_delay = .* s is not allowed: it must be from -1 to 1 s"):
        score_log(_log(0.0, 101), _log(0.0, 102), torque_delay=delay)


def _delayed(log, rows):
    """The log of a machine whose torque acts so many rows after its stamp."""
    return Log(log.name, log.time[:-rows], log.torque[rows:], position=log.position[:-rows])


def _unseen(model, record, block):
    return model.errors(record, np.array([2500 * block]), 2500)[0, 20:]


def _sticking(seed):
    """A log of 20 s of a joint that rests often; its force, noise and friction are none that a structure has."""
    time = 0.004 * np.arange(5000)
    generator = np.random.default_rng(seed)
    frequencies, phases = generator.uniform(0.3, 1.0, 5), generator.uniform(0.0, 2.0 * np.pi, 5)
    torque = np.sum(np.sin(2.0 * np.pi * np.outer(frequencies, time) + phases[:, np.newaxis]), axis=0)
    force = 0.4 * np.random.default_rng(9).standard_normal(40)
    model = OpenLoopModel(0.5, 1.5, 2.0, 0.2, -1.0, 1.0, force)
    position = model.errors(Record(np.zeros(5000), np.zeros(5000), torque, 0.004), np.array([0]), 5000)[0]
    seen = torque * (1.0 + 0.05 * np.sin(3.0 * position)) + 0.1 * generator.standard_normal(5000)
    return Log("log", time, seen, position=position)


def _wavy():
    """A joint with a force over four knots, viscous friction by direction, and friction over position."""
    variation = map_parameters((0.7,), 3, (-0.5, 0.5), 0.0, 1.0)
    force, coefficients = np.array([0.3, -0.4, 0.5, 0.1]), np.array([0.05, -0.1, 0.02, 0.1, -0.05])
    return OpenLoopModel(0.5, 1.0, 2.0, 0.3, -1.0, 1.0, force, variation, coefficients)


def _record_of(model):
    """A log of 10 s that the model itself makes of three sines."""
    time = PERIOD * np.arange(5000)
    torque = 4.0 * np.sum([np.sin(2.0 * np.pi * f * time + f) for f in (0.31, 0.47, 0.83)], axis=0)
    position = model.errors(Record(np.zeros(5000), np.zeros(5000), torque, PERIOD), np.array([0]), 5000)[0]
    return Record(position, np.gradient(position, PERIOD), torque, PERIOD)


def _log(amplitude, seed):
    """A log of a joint whose friction varies by ``1 + A sin(2 pi q/0.5)``, from its own simulation."""
    time = PERIOD * np.arange(5000)
    generator = np.random.default_rng(seed)
    frequencies, phases = generator.uniform(0.2, 0.8, 4), generator.uniform(0.0, 2.0 * np.pi, 4)
    torque = 2.5 * np.sum(np.sin(2.0 * np.pi * np.outer(frequencies, time) + phases[:, np.newaxis]), axis=0)
    variation = map_parameters((0.5,), 0, None, 0.0, 1.0)
    model = OpenLoopModel(0.5, 1.0, 2.0, 0.0, 0.0, 1.0, np.zeros(1), variation, np.array([0.0, amplitude]))
    position = model.errors(Record(np.zeros(5000), np.zeros(5000), torque, PERIOD), np.array([0]), 5000)[0]
    return Log("log", time, torque, position=position)
