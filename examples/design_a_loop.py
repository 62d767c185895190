"""Design a velocity loop from data-sheet numbers: gains, margins, Bode plot, and what a falling friction curve does."""

from pathlib import Path

import control
import matplotlib as mpl

mpl.use("Agg")  # a picture in a file, no window

from controllers import PI, loop_margins_of

INERTIA, PERIOD, DELAY = 2e-4, 0.001, 1  # kg m^2, s, periods

print("bandwidth, Hz   maximum sensitivity   phase margin, degrees")
for bandwidth in (10.0, 20.0, 30.0):
    design = PI.design(INERTIA, PERIOD, bandwidth, delay=DELAY)
    print(f"{bandwidth:13g}   {design.maximum_sensitivity:19.2f}   {design.phase_margin:21.1f}")

design = PI.design(INERTIA, PERIOD, 30.0, delay=DELAY)
print(f"Kp = {design.proportional:.4g} N m s/rad, Ki = {design.integral:.4g} N m/rad")
for slope in (0.0, -0.5 * design.proportional, -1.5 * design.proportional):
    margins = loop_margins_of(design.systems(friction_slope=slope))
    print(f"friction slope {slope:8.3g} N m s/rad: {'stable' if margins.stable else 'hunts'}")

folder = Path("results/design_a_loop")
folder.mkdir(parents=True, exist_ok=True)
control.bode_plot(design.systems().open_loop, display_margins=True).figure.savefig(folder / "bode.png")
