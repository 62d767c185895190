"""Record, identify, simulate: parameters of a joint from a log, with intervals, and the scenario that they make."""

import tempfile
from pathlib import Path

import numpy as np

from adaptive_ff import identify_log, load_scenario, read_log, simulate

folder = Path(tempfile.mkdtemp())
machine = load_scenario().modified(duration=60.0, sampling={"period": 0.002}, sensor={"velocity_noise": 0.0005})
run = simulate(machine, "pi")  # stands for a recording: time, velocity and torque of the drive
rows = np.column_stack([run.time, run.measured, run.torque])
np.savetxt(folder / "log.csv", rows, delimiter=",", header="time,velocity,torque", comments="")

log = read_log(folder / "log.csv", torque="torque", velocity="velocity", time="time")
found = identify_log(log, torque_delay=0.001)  # a row's torque is held until the next: half a period late
for name, estimate in found.parameters.items():
    print(f"{name:18s} {estimate.value:10.4g}   95 %: {estimate.lower:.4g} to {estimate.upper:.4g} {found.units[name]}")
print("verdict:", found.grade)
for sentence in found.cautions:  # cautions: what was left out of the log, or is wrong with it
    print(sentence)
