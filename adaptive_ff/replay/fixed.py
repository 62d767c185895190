"""The fixed model that a replay is compared with: batch identification of the first half of the log."""

from dataclasses import replace

import numpy as np

from adaptive_ff.errors import InputError
from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.further_torque import FurtherTorque, further_torque

MOST = 500_000
"""Samples that are fitted at most: the end of the first half, where that is longer."""


def first_half(log: Log) -> Log:
    """Return the first half of a log, or the end of it where it is long."""
    stop = log.time.size // 2
    return replace(log.part(slice(max(0, stop - MOST), stop)), extra={})


def fit_fixed(
    log: Log, bandwidth: float | None, torque_delay: float, *, linear: bool = False
) -> tuple[TorqueModel | None, FurtherTorque, str]:
    """Return the model identified from the first half of a log, its further terms and a sentence; None for no model.

    Parameters
    ----------
    log : Log
        The log.
    bandwidth : float, optional
        Band of the regression, Hz.
    torque_delay : float
        Time after its stamp at which a torque acts, s.
    linear : bool, optional
        Whether it is a linear axis, on which gravity does not depend on the position.
    """
    half = first_half(log)
    try:
        found = identify_log(half, bandwidth=bandwidth, held_out=0.0, torque_delay=torque_delay, linear=linear)
    except InputError as error:
        return (
            None,
            FurtherTorque(),
            f"There is no fixed model: of the first half, {str(error).removeprefix(log.name + ': ')}.",
        )
    # the best values, also where their intervals are wide: terms that make up for each other belong together
    values = found.selection.chosen.values
    coulomb = values["coulomb"]
    model = TorqueModel(
        inertia=values["inertia"],
        coulomb=coulomb,
        stiction=coulomb + values.get("stiction_excess", 0.0),
        viscous=values["viscous"],
        friction_lag=values.get("friction_lag", 0.0),
        stribeck_velocity=values.get("stribeck_velocity", 1.0),  # of no consequence where stiction is Coulomb friction
        stribeck_shape=1.0,
        offset=values.get("offset", 0.0),
        stiction_asymmetry=0.0,
        viscous_asymmetry=values.get("viscous_asymmetry", 0.0),
        presliding=values.get("presliding", 0.0),
    )
    further = further_torque(found)
    if not all(np.array(model[:3]) >= 0.0) or (model.viscous < 0.0 and not further.shape):
        reason = "There is no fixed model: a parameter identified from the first half is negative."
        return None, FurtherTorque(), reason
    what = "the first half" if half.time.size == log.time.size // 2 else f"the last {MOST} samples of the first half"
    said = f"The fixed model is fitted to {what}, in a band of {found.bandwidth:.3g} Hz.{further.sentence()}"
    return model, further, said
