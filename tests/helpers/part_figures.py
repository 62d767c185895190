"""Figures of parts: joints and controllers along made-up inputs, designs, fits, kernels in C, functions of numbers."""

import math
from dataclasses import asdict
from functools import partial

import numpy as np
import written_kernels
from drawn_arguments import digest, digests, plain
from exports import DELAYED, adaptive_variants, made

from adaptive_ff import fit_stribeck, identify_series, identify_torque_form, support_points
from adaptive_ff.export.sample import made_up_inputs
from controllers import (
    PI,
    DisturbanceObserver,
    ExtendedState,
    Inputs,
    KalmanDisturbance,
    PositionLoop,
    difference_velocity,
    fastest_bandwidth,
    kalman_velocity,
    kalman_velocity_gains,
    loop_margins_of,
    loop_systems,
    low_pass_velocity,
    plain_state,
)
from controllers.kernels.errors import NotTranslatable
from controllers.kernels.functions import Translator
from controllers.kernels.helpers import helper_texts
from controllers.kernels.literals import DOUBLE, SINGLE
from controllers.kernels.types import type_of
from plant import CHANGE_JOINT, SCALE_JOINT, SENSED_VELOCITY, Joint, JointChange
from plant import kinds as joints

CURVE = {"inertia": 20.0, "coulomb": 60.0, "stiction": 90.0, "viscous": 80.0, "stribeck_velocity": 0.05}
TWO_SIDED = {"coulomb_backward": 50.0, "stiction_backward": 70.0, "viscous_backward": 95.0, "offset": 4.0}
KINDS = {
    "stribeck": (joints.JointModel, {"friction_lag": 0.02, "gravity": 30.0, "gravity_phase": 0.4}),
    "lugre": (joints.LuGreJoint, {"stiffness": 2e4, "damping": 100.0}),
    "elastic": (
        joints.ElasticJoint,
        {"link_share": 0.6, "link_stiffness": 2e4, "link_damping": 30.0, "friction_lag": 0.01},
    ),
    "backlash": (
        joints.BacklashJoint,
        {"link_share": 0.6, "link_stiffness": 2e4, "link_damping": 30.0, "gap": 0.002, "hysteresis": 5.0},
    ),
    "maxwell": (joints.MaxwellJoint, {"displacements": [3e-4, 1e-3, 2e-3, 4e-3], "attraction": 5e3}),
    "rolling": (joints.RollingJoint, {"rolling_range": 0.002}),
    "elasto_plastic": (joints.ElastoPlasticJoint, {"presliding": 0.001, "friction_lag": 0.01}),
}
"""Kinds of joints, and what they need beside the curve."""


def numbers(value, name=""):
    """Yield every number of nested tables with its name."""
    if isinstance(value, dict):
        for key, one in value.items():
            yield from numbers(one, f"{name} {key}".strip())
    elif isinstance(value, list | tuple):
        for place, one in enumerate(value):
            yield from numbers(one, f"{name} {place}")
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield name, float(value)


def joint_figures(name):
    """Return where a joint of a kind comes to, of one shape of its curve after the other, changed on the way."""
    kind, further = KINDS[name]
    time, found = 1e-3 * np.arange(300), {}
    torques = 140.0 * np.sin(20.0 * time) + 60.0 * np.sin(71.0 * time)
    for label, changes in {"shape 1": {}, "shape 2": {"stribeck_shape": 2.0, **TWO_SIDED}}.items():
        joint = Joint(kind(**{**CURVE, **further, **changes}), velocity=0.02)
        for torque in torques:
            joint.step(torque, 1e-3)
        found |= dict(numbers(joint.state._asdict(), label))
        found[f"{label} sensed"] = SENSED_VELOCITY[type(joint.state)](joint.state)
        change = JointChange(*(1.1 + 0.1 * place for place, _ in enumerate(JointChange._fields)))
        parameters = type(joint._parameters)
        found |= dict(numbers(CHANGE_JOINT[parameters](joint._parameters, change)._asdict(), f"{label} changed"))
        found |= dict(numbers(SCALE_JOINT[parameters](joint._parameters, 1.3)._asdict(), f"{label} scaled"))
        for refused in (0.003, 0.01, 0.1, 1.0):
            found[f"{label} {refused}"] = words_of(kind, **{**CURVE, **further, **changes, "solver_period": refused})
    return found


def words_of(function, *arguments, **named):
    """Return a digest of what a function gives, or what it refuses with."""
    try:
        value = function(*arguments, **named)
    except (ValueError, TypeError) as error:
        return str(error).rpartition("Value error, ")[2].partition(" [type=")[0]  # of a table, without its frame
    return digest(plain(value)) if not hasattr(value, "model_dump") else "accepted"


def controller_figures(make, samples=160):
    """Return torque and state of a controller in plain Python along made-up inputs, before and after a new start."""
    controller = make()
    controller.run_uncompiled()
    found = {}
    for start in ("cold", "restarted"):
        inputs = made_up_inputs(controller.period, samples, seed=103)
        given = np.array([controller.step_plain(Inputs(*row.tolist())) for row in inputs])
        found |= {f"{start} torque": rms(given[:, 0]), f"{start} feedforward": rms(given[:, 1])}
        found |= {f"{start} last": float(given[-1, 0]), f"{start} faults": controller.faults}
        found |= dict(numbers(controller.estimates, f"{start} estimate"))
        found[f"{start} state"] = state_size(controller)
        controller.restart()
    found["refused"] = words_of(controller.take_over, 12.0, 0.1, 0.09, next_reference=0.11)
    found["taken over"] = controller.step(0.11, 0.1, next_reference=0.12)
    controller.state_from_json(controller.state_to_json())
    found["read again"] = state_size(controller)
    return found


def state_size(controller):
    values = [value for _, value in numbers(plain_state(controller.state)) if math.isfinite(value)]
    return float(np.sum(np.arctan(values) * np.cos(np.arange(len(values)))))


def rms(series):
    return float(np.sqrt(np.mean(np.square(series))))


OBSERVERS = (DisturbanceObserver, ExtendedState, KalmanDisturbance)


def design_figures():
    """Return gains and margins of loops, observers and cascades, behind estimators of velocity too, and refusals."""
    found = {}
    estimators = {"": None, "difference": difference_velocity(0.001), "low-pass": low_pass_velocity(0.001, 60.0)}
    estimators["kalman"] = kalman_velocity(*kalman_velocity_gains(1e-4, 10.0, 0.001), 0.001)
    for delay, names in ((0, estimators), (2, ("", "kalman"))):
        for name in names:
            velocity = estimators[name]
            loop = {"delay": delay, "velocity": velocity}
            limit = fastest_bandwidth(0.001, **loop)
            design = PI.design(20.0, 0.001, 0.4 * limit, **loop)
            margins = loop_margins_of(design.systems(friction_slope=-30.0))
            cascade = PositionLoop.design(0.001, 0.4 * limit, **loop)
            tables = {"limit": limit, "pi": asdict(design), "falling": asdict(margins), "cascade": asdict(cascade)}
            for kind in OBSERVERS if (delay, name) in ((0, ""), (2, "kalman")) else ():
                gains = (design.proportional, design.integral)[: 1 if kind is ExtendedState else 2]
                tables[kind.__name__] = asdict(kind.design(20.0, 0.001, *gains, **loop))
            found |= dict(numbers(tables, f"{delay} {name}".strip()))
            for function, given in (
                (PI.design, (20.0, 0.001, 1.2 * limit)),
                (PositionLoop.design, (0.001, 0.4 * limit, 900.0)),
                (PositionLoop.design, (0.001, 1.5 * limit)),
            ):
                found[f"{delay} {name} {function.__qualname__} {len(given)}"] = words_of(function, *given, **loop)
    systems = loop_systems(800.0, 0.0, 20.0, 0.001, delay=1, friction_slope=20.0)
    found |= dict(numbers({name: [*one.num[0][0], *one.den[0][0]] for name, one in systems._asdict().items()}))
    found["walk"] = KalmanDisturbance.walk(20.0, 0.001, 0.002, 8.0)
    return found


def fit_figures():
    """Return what the paper's fits give of a joint's records."""
    time = 0.005 * np.arange(2000)
    velocity = 0.2 * np.sin(1.9 * time) + 0.1 * np.sin(5.3 * time + 0.4)
    sign, generator = np.sign(velocity), np.random.default_rng(101)
    torque = (
        20.0 * np.gradient(velocity, time) + 80.0 * velocity + sign * (60.0 + 30.0 * np.exp(-np.abs(velocity) / 0.05))
    )
    torque += 0.5 * generator.standard_normal(time.size)
    series = identify_series(velocity, torque, 0.005, stribeck_velocity=0.05, use=np.abs(velocity) > 0.01)
    form = identify_torque_form(
        time, velocity, torque, stribeck_velocity=0.05, filter_pole=30.0, slowest=0.01, hold=0.1, confidence=0.9
    )
    speeds = np.geomspace(0.005, 0.4, 10)
    drives = np.repeat(np.concatenate([speeds, -speeds])[:, np.newaxis], 6, axis=1)
    readings = np.sign(drives) * (60.0 + 30.0 * np.exp(-np.abs(drives) / 0.05)) + 80.0 * drives + 2.0
    points = support_points(drives, readings + generator.standard_normal(drives.shape) * (0.5 + np.abs(drives)))
    found = {"series": tables(series.physical), "form": tables(form.physical), "used": int(np.sum(form.used))}
    found |= {"rows": int(np.sum(series.used)), "points": rms(points.standard_error), "torque": rms(points.torque)}
    both, forward = (points.velocity, points.torque, points.standard_error), points.velocity > 0.0
    found["both"] = fit_stribeck(*both, confidence=0.9).estimates
    found["forward"] = fit_stribeck(points.velocity[forward], points.torque[forward]).estimates
    return dict(numbers({name: tables(one) if name in ("both", "forward") else one for name, one in found.items()}))


def tables(estimates):
    return {name: list(one) for name, one in estimates.items()}


GIVEN = {"n": 3, "m": 2, "flag": True, "moving": True}
TABLE, ROW = np.ones((3, 4)), np.ones(4)
BODY = written_kernels.Body(True, written_kernels.Point(1.5, -2.0), 4, (1.0, 2.0, 3.0), ROW, TABLE, False)
GIVEN |= dict.fromkeys(("row", "values", "first", "second", "a_row"), ROW) | dict.fromkeys(("table", "whole"), TABLE)
GIVEN |= {"body": BODY, "point": BODY.at, "circle": written_kernels.Circle(2.0), "square": written_kernels.Square(3.0)}


def written_figures():
    """Return digests of what kernels of all that their language has become in C."""
    import inspect

    found = {}
    for name, kernel in vars(written_kernels).items():
        if not inspect.isfunction(kernel) or kernel.__module__ != written_kernels.__name__:
            continue
        for label, precision, fixed in (("double", DOUBLE, True), ("single", SINGLE, True), ("open", DOUBLE, False)):
            kinds = tuple(type_of(GIVEN.get(one, 1.5), sizes=fixed) for one in inspect.signature(kernel).parameters)
            found[f"{name} {label}"] = text_of(kernel, kinds, precision, fixed)
    return found


def text_of(kernel, kinds, precision, fixed):
    unit = Translator(precision, "x", fixed=fixed)
    try:
        unit.function(kernel, kinds)
    except NotTranslatable as error:
        return str(error).rpartition("/")[2]
    parts = [part.text for part in (*unit.structs.values(), *unit.functions.values())]
    return digest([*parts, *helper_texts(unit.helpers, "double")])


ROOMS = ("plant", "controllers", "adaptive_ff.friction", "adaptive_ff.learning", "adaptive_ff.adaptive")

STEPPED = (
    "pi",
    "pi_inertia",
    "oracle",
    "adaptive",
    "adaptive_paper",
    "adaptive_unsupervised",
    "canudas",
    "canudas_measured",
    "feedback_error",
    "lugre_observer",
    "lugre_gradient",
    "friction_observer",
    "lee_tomizuka",
    "maxwell_adaptive",
    "radial_basis",
    "super_twisting",
    "repetitive",
    "disturbance_observer",
    "extended_state",
    "kalman_disturbance",
    "observed_nominal",
)
"""Controllers that are made without a run of identification or tuning."""

MADE = {
    **{name: partial(made, name) for name in STEPPED},
    **{f"{name} late": partial(made, name, DELAYED) for name in STEPPED},
}

PARTS = {
    **{f"joint {name}": (joint_figures, (name,)) for name in KINDS},
    **{f"steps of {name}": (controller_figures, (make,)) for name, make in {**MADE, **adaptive_variants()}.items()},
    "fits": (fit_figures, ()),
    "kernels in C": (written_figures, ()),
    **{f"functions of {room}": (digests, (room,)) for room in ROOMS},
    "designs": (design_figures, ()),
}
