"""What is wrong with a log: refused, or said as a caution."""

import numpy as np

from adaptive_ff.errors import InputError
from adaptive_ff.identify.alternatives.held_torque import Later, gain
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.terms import LAG
from adaptive_ff.identify.units import is_linear
from adaptive_ff.identify.words.unattributed import unattributed
from adaptive_ff.identify.words.verdict import POORLY
from adaptive_ff.logs.log import Log
from adaptive_ff.logs.sanity import in_degrees

NOTHING = 0.9
"""Relative error from which a torque has so little to do with the motion that it cannot be the drive's."""

NEGATIVE = {
    "coulomb": "the torque is not only that of friction",
    "viscous": "friction falls with the speed wherever the joint moves (Stribeck; faster motion shows the rest), or "
    "the torque is not only that of friction",
}
"""What it may be where a parameter of friction comes out negative."""

LONG = 0.99
"""Share of the longest friction lag that is looked for from which on a lag is said to be at that end."""


def check_plausible(found: LogIdentification, log: Log) -> None:
    """Refuse a log whose friction drives the joint.

    Raises
    ------
    InputError
        It does: the sign of the torque or of the motion is reversed, or the torque is not that of a drive at all.
    """
    velocity = np.concatenate([rows.velocity[rows.slides] for rows in found.rows])
    values = found.selection.chosen.values
    friction = values["coulomb"] * np.sign(velocity) + values["viscous"] * velocity
    inertia, coulomb = (found.parameters[name].estimate for name in ("inertia", "coulomb"))
    if float(np.mean(friction * velocity)) < 0.0 and (inertia.upper < 0.0 or coulomb.upper < 0.0):
        shown = ", ".join(
            f"{name} {values[name]:.3g} {found.units[name]}" for name in ("inertia", "coulomb", "viscous")
        )
        if found.fit.relative_error > NOTHING:
            explained = 100.0 * max(0.0, 1.0 - found.fit.relative_error)
            raise InputError(
                f"{found.name}: the motion explains {explained:.0f} % of the torque: it "
                "is not that of the drive, or the drive does not move this joint; name its column with --torque"
            )
        raise InputError(
            f"{found.name}: friction would drive the joint ({shown}); the torque or the motion has the wrong sign, or "
            f"their columns are exchanged: {log.scaling('torque', '-1')}, or name the others"
        )


def cautions(found: LogIdentification, log: Log) -> list[str]:
    """Return what is probably wrong with a log, a sentence each."""
    said = []
    inertia = found.parameters["inertia"].estimate
    if inertia.upper < 0.0:
        said.append(
            f"inertia comes out negative, {inertia.value:.3g}: the columns do not belong together, are shifted in "
            "time, or another torque acts on the joint"
        )
    for name in NEGATIVE:
        estimate = found.parameters[name].estimate
        if estimate.upper < 0.0:
            said.append(f"{name} comes out negative, {estimate.value:.3g}: {NEGATIVE[name]}")
    peak = max(float(np.max(np.abs(rows.velocity))) for rows in found.rows)
    said += in_degrees(log, peak, linear=is_linear(found.units))
    if vague := unattributed(found):
        said.append(vague)
    error = found.fit.relative_error
    if error > POORLY:
        said.append(
            f"inertia and friction leave {100.0 * error:.0f} % of the torque unexplained: another torque acts on the "
            "joint (gravity, other axes, elasticity), or columns or units are not what they are named"
        )
    if found.selection.jumping is not None:
        said.append(
            f"friction over a path leaves {100.0 * error:.2g} % of the torque, more than chance explains, as where a "
            "joint sticks and slips: intervals are taken over friction that lags, too, and the values themselves may "
            "be as far off as they are wide; record motion without stops"
        )
    if found.value("friction_lag") > LONG * float(found.lags[-1]):
        said.append(
            f"friction lags by {1e3 * found.value('friction_lag'):.3g} ms, the longest time that is looked for in this "
            "band, or more, as where bristles, belts or seals bend over a long way: inertia and friction may not be "
            "those of the joint, whatever their intervals say; record longer strokes"
        )
    if found.selection.lead > found.period:
        said.append(
            f"friction seems to lead the motion by {1e3 * found.selection.lead:.3g} ms: the motion may be "
            "recorded later than the torque; if it is, give that time as --torque-delay; or the joint sticks for a "
            "moment where it reverses, or another torque acts on it"
        )
    return said


def held_words(found: LogIdentification, later: Later | None) -> list[str]:
    """Say that the torque seems to be held, where it does: one sentence or none."""
    if later is None:
        return []
    chosen = found.selection.chosen
    held, stamped = (f"{fitted.values['inertia']:.4g}" for fitted in (later.fitted, chosen))
    half = later.delay == 0.5 * found.period
    when, until = ("half a sample time", "the next") if half else (f"{1e3 * later.delay:.2g} ms", "its next period")
    return [
        f"the torque seems to act {when} after its stamp, as one that the drive holds until {until}: so "
        f"taken, the same terms {'without a lag ' if LAG in chosen.terms else ''}leave "
        f"{100.0 * gain(chosen, later.fitted)[0]:.2g} % less of the squares, with an inertia of {held} instead of "
        f"{stamped} {found.units['inertia']}; if the drive holds it, give --torque-delay "
        f"{later.delay:{'.4g' if half else '.2g'}}"
    ]
