"""An identified joint in the closed loop of ``compare``, along the reference that its machine was given."""

import tempfile
from pathlib import Path

import numpy as np

from adaptive_ff import Comparison, compare, load_scenario
from adaptive_ff.files import write_csv
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.scenario_text import joined_ends, scenario_text
from adaptive_ff.logs.log import Log

ASSUMED = (
    "Assumed in the closed loops: a PI loop of 10 Hz, designed for the identified inertia, which every controller "
    "assumes as well; where the log does not identify them, stiction as Coulomb friction and a Stribeck velocity of "
    "0.05 of the largest speed; a sensor of velocity, as noisy as the log's velocity; a drive without limit; the "
    "reference repeats until 60 s."
)


def simulate_identified(found: LogIdentification, log: Log) -> Comparison:
    """Compare all controllers on an identified joint along the recorded reference of its log."""
    if "reference_velocity" in log.extra:
        velocity = log.extra["reference_velocity"]
    else:
        velocity = np.gradient(log.extra["reference_position"], log.time)
    with tempfile.TemporaryDirectory() as folder:
        write_csv(Path(folder) / "reference.csv", joined_ends(log.time - log.time[0], velocity))
        scenario = Path(folder) / "scenario.toml"
        scenario.write_text(scenario_text(found, "reference.csv"), encoding="utf-8")
        return compare(load_scenario(scenario))
