"""The friction laws of ``plant`` along an imposed motion, and their fits to a record.

Each law is the one of the joint's own step: a joint too heavy to be moved by its friction is pushed along the motion.
The measured record is of a reciprocating contact of 0.24 mm stroke under a constant normal load of 5 N. A record of one
speed shows neither a Stribeck curve nor viscous friction, so stiction is Coulomb friction here.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, minimize_scalar

from adaptive_ff.simulation.metrics import rms
from benchmarks.cases.reports import Row, limited
from controllers import compiled, dispatched
from plant import STEP_JOINT, ElastoPlasticJoint, LuGreJoint, MaxwellJoint, RollingJoint, initial_state

HEAVY = 1e12  # inertia of the joint that is pushed along, kg
STEP = 0.005  # solver period that the joints are checked for, s; the record's is the same but for a few samples
DATA = Path(__file__).resolve().parents[3] / "shared/data/tribometer_presliding/reciprocating_presliding.npz"

LOADED = 4.9  # normal load from which on the contact counts as loaded, N
RUN_IN = 15.0  # time that is left out: the load is put on and the first stroke begins elsewhere, s
PLAY = 2e-7  # half width of the play operator that takes the flicker of the last digit (1e-7 m) out of the position, m


class PreslidingRecord(NamedTuple):
    """A record of friction over an imposed motion."""

    period: NDArray[np.float64]  # shape (n,): time since the sample before, s
    position: NDArray[np.float64]  # shape (n,): position, m, without its flicker
    velocity: NDArray[np.float64]  # shape (n,): mean velocity since the sample before, m/s
    force: NDArray[np.float64]  # shape (n,): friction force against motion in the direction of the position, N

    def part(self, which: slice) -> "PreslidingRecord":
        """Return some of the samples."""
        return PreslidingRecord(*(series[which] for series in self))


def without_flicker(position: NDArray[np.float64], play: float = PLAY) -> NDArray[np.float64]:
    """Return the output of a play operator: it follows a position only where that has moved by more than the play."""
    kept, held = np.empty_like(position), float(position[0])
    for index, value in enumerate(position.tolist()):
        held = min(max(held, value - play), value + play)
        kept[index] = held
    return kept


def read_record(path: Path = DATA) -> PreslidingRecord:
    """Read the loaded part of the record; the source's friction has the other sign."""
    with np.load(path) as arrays:
        time, load = arrays["t_s"], 1e-6 * arrays["normal_uN"]
        used = (load > LOADED) & (time > RUN_IN)
        time, position, force = time[used], 1e-3 * arrays["position_mm"][used], -1e-6 * arrays["friction_uN"][used]
    position = without_flicker(position - np.mean(position))
    period = np.diff(time)
    return PreslidingRecord(period, position[1:], np.diff(position) / period, force[1:])


step_joint = dispatched(STEP_JOINT)  # of any kind of joint


def _push(joint: Any, state: Any, velocity: Any, period: Any, force: Any) -> None:
    for k in range(velocity.size):
        push = joint.inertia * (velocity[k] - state.velocity) / period[k]
        state = step_joint(joint, state, push, period[k])
        force[k] = state.friction_torque


push_along = compiled(_push)


def force_along(joint: Any, velocity: NDArray[np.float64], period: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the friction force (N) of a joint (a model of ``plant``) along velocities (m/s), from rest."""
    force = np.empty(velocity.size)
    parameters = joint.parameters
    push_along(parameters, initial_state(parameters, 0.0), velocity, period, force)
    return force


@dataclass(frozen=True)
class Law:
    """A friction law with parameters to fit."""

    name: str  # name for tables and pictures
    start: dict[str, float]  # its parameters, all positive, where the search begins
    make: Callable[..., Any]  # makes the joint from them
    fraction: float  # largest error that is asked for, as a fraction of Coulomb friction's


def _fields(coulomb: float) -> dict[str, float]:
    friction = {"coulomb": coulomb, "stiction": coulomb, "viscous": 0.0, "stribeck_velocity": 1.0}
    return {"inertia": HEAVY, "solver_period": STEP, **friction}


def _maxwell(*values: float) -> MaxwellJoint:
    """Four forces and four steps between the displacements, so that these ascend whatever the values."""
    forces, steps = np.array(values[:4]), np.array(values[4:])
    total = float(np.sum(forces))
    shares = (forces / total).tolist()
    return MaxwellJoint(**_fields(total), displacements=np.cumsum(steps).tolist(), shares=shares)


LAWS = (
    Law(
        "LuGre",
        {"coulomb": 2.3, "stiffness": 5e4},
        lambda coulomb, stiffness: LuGreJoint(**_fields(coulomb), stiffness=stiffness, damping=0.0),
        0.5,
    ),
    Law(
        "Maxwell slip",
        {f"{name}_{i}": value for name, value in (("force", 0.6), ("step", 1e-5)) for i in (1, 2, 3, 4)}
        | {"step_1": 2e-5},
        _maxwell,
        0.25,
    ),
    Law(
        "rolling",
        {"coulomb": 2.3, "rolling_range": 5e-5, "exponent - 1": 0.5},
        lambda coulomb, way, exponent: RollingJoint(**_fields(coulomb), rolling_range=way, exponent=1.0 + exponent),
        0.5,
    ),
    Law(
        "elasto-plastic",
        {"coulomb": 2.3, "presliding": 1e-4},
        lambda coulomb, presliding: ElastoPlasticJoint(**_fields(coulomb), presliding=presliding),
        0.25,
    ),
)


@dataclass(frozen=True)
class Fit:
    """A law fitted to a record."""

    law: str  # name of the law
    values: dict[str, float]  # its parameters; ``offset`` is a constant force, N, that every law has
    force: NDArray[np.float64]  # shape (n,): its force along the whole record, N
    fitted: float  # fitted, tested: error (rms, N) over the half that was fitted and the half that was not
    tested: float


def _result(law: str, values: dict[str, float], force: NDArray[np.float64], record: PreslidingRecord) -> Fit:
    error, half = force - record.force, record.force.size // 2
    return Fit(law, values, force, rms(error[:half]), rms(error[half:]))


def last_sign(velocity: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the sign of the last motion; zero before the first.

    At rest Coulomb friction may have any value; to keep its sign is the best that it could do on this record.
    """
    sign = np.sign(velocity)
    places = np.maximum.accumulate(np.where(sign != 0.0, np.arange(sign.size), 0))
    return np.asarray(sign[places])


def _fit_column(name: str, column: NDArray[np.float64], record: PreslidingRecord, more: dict[str, float]) -> Fit:
    matrix, half = np.column_stack([column, np.ones(column.size)]), column.size // 2
    (coulomb, offset), *_ = np.linalg.lstsq(matrix[:half], record.force[:half], rcond=None)
    values = {"coulomb": float(coulomb), **more, "offset": float(offset)}
    return _result(name, values, matrix @ [coulomb, offset], record)


def fit_coulomb(record: PreslidingRecord) -> Fit:
    """Fit Coulomb friction."""
    return _fit_column("Coulomb", last_sign(record.velocity), record, {})


def fit_lagged(record: PreslidingRecord) -> Fit:
    """Fit Coulomb friction behind the lag of the paper's (1), that of ``plant.step``."""
    sign = last_sign(record.velocity).tolist()

    def fit(lag: float) -> Fit:
        force, column = 0.0, []
        for value, period in zip(sign, record.period.tolist(), strict=True):
            force = (lag * force + period * value) / (lag + period)
            column.append(force)
        return _fit_column("lagged Coulomb", np.array(column), record, {"friction_lag": lag})

    found = minimize_scalar(lambda lag: fit(lag).fitted, bounds=(0.0, 2.0), method="bounded")
    return fit(float(found.x))


def fit_law(law: Law, record: PreslidingRecord) -> Fit:
    """Fit a law to the first half of a record by least squares over the logarithms of its parameters."""
    first = record.part(slice(None, record.force.size // 2))

    def residuals(point: NDArray[np.float64]) -> NDArray[np.float64]:
        force = force_along(law.make(*np.exp(point[:-1]).tolist()), first.velocity, first.period)
        return force + point[-1] - first.force

    start = np.append(np.log(list(law.start.values())), 0.0)
    found = least_squares(residuals, start, x_scale=0.1, diff_step=1e-4, max_nfev=60)
    parameters = np.exp(found.x[:-1]).tolist()
    force = force_along(law.make(*parameters), record.velocity, record.period) + found.x[-1]
    values = dict(zip(law.start, parameters, strict=True)) | {"offset": float(found.x[-1])}
    return _result(law.name, values, force, record)


def fit_all(record: PreslidingRecord) -> list[Fit]:
    """Fit Coulomb friction, without and with lag, and every law."""
    return [fit_coulomb(record), fit_lagged(record), *(fit_law(law, record) for law in LAWS)]


def report() -> list[Row]:
    """Return the errors of the laws on the measured record over that of Coulomb friction."""
    if not DATA.is_file():
        raise ValueError("the measured record is not beside this repository")
    fits, asked = fit_all(read_record(DATA)), {law.name: law.fraction for law in LAWS}
    over = {fit.law: fit.tested / fits[0].tested for fit in fits}
    return [
        limited(law, fraction, asked[law]) if law in asked else Row(law, fraction) for law, fraction in over.items()
    ]


EXPERIMENTS = {"presliding record": report}
