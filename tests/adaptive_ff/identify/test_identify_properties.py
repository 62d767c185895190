"""Whatever a log holds, identification answers with a result that can be written, or with one line."""

import json
import warnings

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic_logs import make_log

from adaptive_ff import InputError
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.logs.log import Log

SERIES = st.sampled_from(["time", "torque", "position"])
VALUES = st.sampled_from([np.nan, np.inf, 0.0, 1e300, -1e20, 1e-300]) | st.floats(-10.0, 10.0)


@st.composite
def damage(draw):
    """A function that spoils a series in place."""
    kind = draw(st.sampled_from(["stretch", "scale", "shift", "constant", "reversed", "rounded", "noise"]))
    start, length, value = draw(st.integers(0, 999)), draw(st.integers(1, 400)), draw(VALUES)
    seed, digits = draw(st.integers(0, 99)), draw(st.integers(0, 2))

    def spoil(series):
        if kind == "stretch":
            series[start : start + length] = value
        elif kind == "scale":
            series *= value
        elif kind == "shift":
            series[start:] += value
        elif kind == "constant":
            series[:] = series[0]
        elif kind == "reversed":
            series[:] = series[::-1].copy()
        elif kind == "rounded":
            series[:] = np.round(series, digits)
        else:
            series[:] = np.random.default_rng(seed).standard_normal(series.size)

    return spoil


def identified_or_refused(log, held_out):
    """The result, or the line that refuses the log."""
    try:
        return identify_log(log, held_out=held_out)
    except InputError as refused:
        return str(refused)


@settings(max_examples=50)
@given(st.lists(st.tuples(SERIES, damage()), max_size=3), st.sampled_from([0.0, 0.3]))
def test_any_log_is_identified_or_refused_in_one_line(damages, held_out):
    log = make_log(duration=4.0, period=0.004, noise=0.1)
    with warnings.catch_warnings(action="ignore"):  # of the damage itself
        for name, spoil in damages:
            spoil(getattr(log, name))
    answer = identified_or_refused(Log("log", log.time, log.torque, log.position), held_out)
    if isinstance(answer, str):
        assert answer.startswith("log: ")
        assert "\n" not in answer
    else:
        json.dumps(answer.to_dict(), allow_nan=False)
        repeated = sum(int(caution.split()[0]) for caution in answer.cautions if "left out: " in caution)
        assert answer.used <= answer.samples == 1000 - repeated
        assert answer.verdict
