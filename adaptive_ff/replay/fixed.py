"""The fixed model that a replay is compared with: batch identification of the first half of the log."""

import numpy as np

from adaptive_ff.errors import InputError
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.logs.log import Array, Log
from adaptive_ff.model.friction import TorqueModel

MOST = 500_000
"""Samples that are fitted at most: the end of the first half, where that is longer."""


def first_half(log: Log) -> Log:
    """Return the first half of a log, or the end of it where it is long."""
    stop = log.time.size // 2
    part = slice(max(0, stop - MOST), stop)

    def cut(series: Array | None) -> Array | None:
        return None if series is None else series[part]

    return Log(log.name, log.time[part], log.torque[part], cut(log.position), cut(log.velocity))


def fit_fixed(log: Log, bandwidth: float | None, torque_delay: float) -> tuple[TorqueModel | None, str]:
    """Return the model identified from the first half of a log, and a sentence on it; None where there is none.

    Parameters
    ----------
    log : Log
        The log.
    bandwidth : float, optional
        Band of the regression, Hz.
    torque_delay : float
        Time after its stamp at which a torque acts, s.
    """
    half = first_half(log)
    try:
        found = identify_log(half, bandwidth=bandwidth, held_out=0.0, torque_delay=torque_delay)
    except InputError as error:
        return None, f"There is no fixed model: of the first half, {str(error).removeprefix(log.name + ': ')}."
    # the best value, also where its interval is wide: a loop has to be designed for some inertia
    inertia, coulomb = found.parameters["inertia"].estimate.value, found.value("coulomb")
    bend = found.value("stribeck_velocity")
    model = TorqueModel(
        inertia,
        coulomb,
        max(found.value("stiction"), coulomb),
        found.value("viscous"),
        found.value("friction_lag"),
        bend if bend > 0.0 else 1.0,  # of no consequence where stiction is Coulomb friction
        1.0,
        found.value("offset"),
    )
    if not all(np.array(model[:5]) >= 0.0):
        return None, "There is no fixed model: a parameter identified from the first half is negative."
    what = "the first half" if half.time.size == log.time.size // 2 else f"the last {MOST} samples of the first half"
    return model, f"The fixed model is fitted to {what}, in a band of {found.bandwidth:.3g} Hz."
