"""Friction that a log shows without saying which it is, as at one speed: Coulomb and viscous are one number then."""

import numpy as np

from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.terms import SATURATIONS

LARGEST_SHARE = 0.25
"""Share of the friction that a log shows by which its parameters may differ from it."""


def unattributed(found: LogIdentification) -> str:
    """Say that the log does not tell which friction it shows; empty where it does.

    That is where Coulomb friction is not identifiable, or a part of friction that is confounded with it is not, and
    what is known of all parts differs from the mean friction along the motion by more than a quarter of it and the
    error of the fit.
    """
    parts = [name for name in ("viscous", *SATURATIONS) if name in found.parameters]
    is_known = found.parameters["coulomb"].identifiable
    mixed = [name for name in parts if "coulomb" in found.parameters[name].confounded]
    if is_known and all(found.parameters[name].identifiable for name in mixed):
        return ""
    velocity, friction = (
        np.concatenate([getattr(rows, name)[rows.slides] for rows in found.rows]) for name in ("velocity", "friction")
    )
    shown = float(np.mean((friction - found.value("offset")) * np.sign(velocity)))
    speeds = {"viscous": float(np.mean(np.abs(velocity))), **dict.fromkeys(SATURATIONS, 1.0)}
    counted = parts if is_known else [name for name in parts if name not in mixed]
    left = shown - is_known * found.value("coulomb") - sum(found.value(name) * speeds[name] for name in counted)
    if abs(left) <= max(LARGEST_SHARE * abs(shown), found.fit.rms_error):
        return ""
    return (
        f"the log shows friction of {shown:.3g} {found.units['torque']}, but does not separate Coulomb friction from "
        "the rest of it: record motion both ways, at slow and fast speeds"
    )
