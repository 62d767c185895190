"""Design a loop and see its Bode plot, choose its bandwidth, simulate it, and close it anew with ``interconnect``."""

from pathlib import Path

import control
import matplotlib as mpl
import numpy as np

mpl.use("Agg")  # a picture in a file, no window

from adaptive_ff import load_scenario, simulate
from adaptive_ff.blocks import controller_block, drive_block, joint_block
from adaptive_ff.studies.bandwidth_study import study_bandwidths
from controllers import PI, loop_margins_of, loop_systems

folder = Path("results/choose_a_bandwidth")
folder.mkdir(parents=True, exist_ok=True)
scenario = load_scenario().modified(duration=10.0, sampling={"period": 0.002})
inertia, period = scenario.feedback.inertia, scenario.sampling.period

# 1. gains from a data sheet, and what they are worth with a period of delay, and where friction falls
for slope in (0.0, -600.0):
    margins = loop_margins_of(loop_systems(1500.0, 15000.0, inertia, period, delay=1, friction_slope=slope))
    print(f"slope {slope:g}: stable {margins.stable}, sensitivity {margins.maximum_sensitivity:.2f}")
design = PI.design(inertia, period, 10.0)
control.bode_plot(design.systems().open_loop, display_margins=True).figure.savefig(folder / "bode.png")

# 2. which bandwidth suits which controller (adaptive-ff tune does this with tables)
study = study_bandwidths(scenario, ["adaptive"], tuning_seeds=[101], reported_seeds=[1])
study.plot().savefig(folder / "bandwidths.png")
for name, own in study.own.items():
    settled, loaded = (1e3 * error for error in study.own_errors[name])
    print(f"{name}: best at {own.best:.1f} Hz, {settled:.2f} mrad/s, {loaded:.2f} after a step of the load")

# 3. simulate, and the same loop with python-control's interconnect
run = simulate(scenario, "pi")
reference = run.reference[scenario.sample_steps]
feedback = controller_block(PI(*scenario.feedback.gains, period))
drive, joint = drive_block(scenario.actuator, period), joint_block(scenario.joint, period, velocity=reference[0])
sensor = control.summing_junction(["velocity", "noise"], "measured", dt=period, name="sensor")
loop = control.interconnect(
    [feedback, drive, joint, sensor],
    connections=[
        ["controller.velocity", "sensor.measured"],
        ["controller.realised_torque", "drive.realised_torque"],
        ["drive.command", "controller.torque"],
        ["joint.torque", "drive.torque"],
        ["sensor.velocity", "joint.velocity"],
    ],
    inplist=["controller.reference", "controller.next_reference", "sensor.noise"],
    outlist=["joint.velocity"],
    check_unused=False,
)
start = np.concatenate([part.initial_state for part in (feedback, drive, joint)])
found = control.input_output_response(loop, run.time, [reference[:-1], reference[1:], scenario.noise()], start)
print("largest difference, rad/s:", np.max(np.abs(found.outputs - run.velocity[scenario.sample_steps[:-1]])))
