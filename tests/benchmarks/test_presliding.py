"""The benchmark of presliding: its joints, and what of a row is missed."""

import numpy as np
import pytest

from adaptive_ff.comparison.windows import Errors, Judgement
from benchmarks.presliding import Row, elements, line_of, rows


def judgement(settled, start):
    base = Errors(np.array([1.0]), 1.0, 1.0, ())
    return Judgement(base, Errors(np.array([1.0]), 1.0 / settled, start, ()))


def test_elements_slip_after_the_mean_that_a_row_names():
    joint = elements(0.075).joint
    assert np.mean(joint.displacements) == pytest.approx(0.075)
    assert (joint.coulomb, joint.stiction, len(joint.displacements)) == (60.0, 90.0, 4)


def test_rows_differ_in_their_joint_or_their_period_alone():
    listed = rows()
    assert len({row.name for row in listed}) == len(listed) == 9
    assert [row.scenario.sampling.period for row in listed].count(0.001) == 1
    assert {row.scenario.sensor.velocity_noise for row in listed} == {0.002}


@pytest.mark.parametrize(
    ("settled", "rival", "start", "missed"),
    [
        (2.2, 2.0, 0.9, ""),
        (2.0, 1.0, 0.9, "settled"),
        (2.2, 2.3, 0.9, "observer"),
        (2.2, 2.0, 1.1, "start"),
        (1.0, 2.0, 1.1, "settled, observer, start"),
    ],
)
def test_what_is_missed_is_named(settled, rival, start, missed):
    row = Row("a joint", elements(0.075), 2.1)
    cells, met = line_of(row, [(judgement(settled, start), judgement(rival, 0.5))] * 3)
    assert (cells[-1], met) == (missed, not missed)


def test_one_bad_start_is_not_hidden_by_the_median():
    good, bad = judgement(2.2, 0.5), judgement(2.2, 1.2)
    cells, met = line_of(Row("a joint", elements(0.075), 2.1), [(good, good), (good, good), (bad, good)])
    assert (cells[-1], met) == ("start", False)
