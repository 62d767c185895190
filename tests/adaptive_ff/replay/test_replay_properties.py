"""Damaged logs: replay refuses them in a line, or uses the rest and stays finite."""

import json
import math
from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic_logs import make_log

from adaptive_ff import InputError, TorqueModel
from adaptive_ff.replay.replay import replay_log

MODEL = TorqueModel(2.0, 3.0, 3.0, 4.0, 0.0, 0.05, 1.0, -0.5)
DAMAGES = st.lists(
    st.tuples(
        st.sampled_from(("time", "torque", "motion")),
        st.integers(0, 2400),
        st.integers(1, 400),
        st.sampled_from((math.nan, math.inf, -1e12, 0.0, 1e6)),
    ),
    max_size=6,
)


@settings(max_examples=60)
@given(damages=DAMAGES, as_position=st.booleans(), is_added=st.booleans())
def test_damaged_log_is_refused_or_the_rest_is_used(damages, as_position, is_added):
    log = make_log(duration=5.0, as_position=as_position)
    series = {"time": log.time.copy(), "torque": log.torque.copy(), "motion": log.motion.copy()}
    for name, start, size, value in damages:
        part = series[name][start : start + size]
        part[:] = part + value if is_added else value
    motion = {"position" if as_position else "velocity": series["motion"]}
    damaged = replace(log, time=series["time"], torque=series["torque"], **motion)
    refused = ""
    try:
        found = replay_log(damaged, inertia=2.0, stribeck_velocity=0.05, fixed=MODEL)
    except InputError as error:
        refused = str(error)
    if refused:
        assert refused.startswith("log: ")
        assert "\n" not in refused
    else:
        json.dumps(found.to_dict(), allow_nan=False)
        assert found.used <= log.time.size
        for left in found.left.values():
            assert math.isfinite(left.whole)
        assert all(np.isfinite(list(found.estimates["adaptive"].values())))
