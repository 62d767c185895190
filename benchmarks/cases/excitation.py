"""Intervals from a designed motion of 10 and 20 s, over those of 60 s of the built-in multisine on the same joint.

The motion keeps the limits of the drive and is followed by the PI loop of the scenario; the intervals are those of the
torque form with the assumed Stribeck velocity. The multisine keeps to seven Stribeck velocities.
"""

from adaptive_ff import load_scenario
from adaptive_ff.studies.exciting_motion import default_limits, exciting_motion, interval_widths, with_motion, yardstick
from adaptive_ff.studies.motion import NAMES
from adaptive_ff.studies.study import Found
from benchmarks.suite import pooled

PERIOD = 10.0  # length of the motion, s


def run_joint(name: str, seeds: list[int], controllers: list[str]) -> Found:
    """Find a motion; figures by length of the log, in the place of controllers: parameters' intervals over those."""
    scenario = load_scenario(name)
    motion = exciting_motion(scenario, default_limits(scenario), period=PERIOD, workers=None)
    base, found = interval_widths(yardstick(scenario), seeds), {}
    for length in controllers:
        longer = with_motion(scenario, motion.reference.model_dump(), float(length.removesuffix(" s")))
        widths = interval_widths(longer, seeds)
        found[length] = {parameter: widths[parameter] / base[parameter] for parameter in NAMES}
    return {"": {"row": name}, **found}


joints = pooled(run_joint, lambda names: {name: (name,) for name in names})
