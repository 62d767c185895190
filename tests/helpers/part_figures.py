"""Figures of parts: joints and controllers along made-up inputs, designs, fits, kernels in C, functions of numbers."""

import inspect
import itertools
import json
import math
import re
import warnings
from dataclasses import asdict, replace
from functools import partial
from tempfile import TemporaryDirectory
from unittest.mock import patch

import numpy as np
from closed_loops import NAMES, SCENARIO
from drawn_arguments import digest, digests, plain
from exports import DELAYED, adaptive, adaptive_variants, made
from kernel_figures import piece_figures, written_figures
from scipy.signal import lfilter
from synthetic_logs import coloured, make_log, sines_log

import adaptive_ff
import controllers
import plant
from adaptive_ff.adaptive.tuning import Tuning
from adaptive_ff.export.sample import made_up_inputs
from adaptive_ff.friction.model import PER_DIRECTION, WITH_GRAVITY, WITH_OFFSET
from adaptive_ff.identify.scenario_text import reference_columns, scenario_text
from adaptive_ff.identify.score import score_log
from adaptive_ff.identify.simulators import ENDINGS
from adaptive_ff.logs.log import KNOWN, Log
from adaptive_ff.replay.replay import replay_log
from adaptive_ff.report.log_words import details, verdict_lines
from adaptive_ff.simulation.metrics import rms
from plant import CHANGE_JOINT, SCALE_JOINT, SENSED_VELOCITY, Joint, JointChange
from plant import kinds as joints
from plant.fields import Table
from tests.test_refused_arguments import NUMBERS, call, each, of_kind

CURVE = {"inertia": 20.0, "coulomb": 60.0, "stiction": 90.0, "viscous": 80.0, "stribeck_velocity": 0.05}
TWO_SIDED = {"coulomb_backward": 50.0, "stiction_backward": 70.0, "viscous_backward": 95.0, "offset": 4.0}
LINK = {"link_share": 0.6, "link_stiffness": 2e4, "link_damping": 30.0}
KINDS = {
    "stribeck": (joints.JointModel, {"friction_lag": 0.02, "gravity": 30.0, "gravity_phase": 0.4}),
    "lugre": (joints.LuGreJoint, {"stiffness": 2e4, "damping": 100.0}),
    "elastic": (joints.ElasticJoint, {**LINK, "friction_lag": 0.01}),
    "backlash": (joints.BacklashJoint, {**LINK, "gap": 0.002, "hysteresis": 5.0}),
    "maxwell": (joints.MaxwellJoint, {"displacements": [3e-4, 1e-3, 2e-3, 4e-3], "attraction": 5e3}),
    "rolling": (joints.RollingJoint, {"rolling_range": 0.002}),
    "elasto_plastic": (joints.ElastoPlasticJoint, {"presliding": 0.001, "friction_lag": 0.01}),
}
"""Kinds of joints, and what they need beside the curve."""
UNSUITABLE = [("solver_period", period) for period in (0.003, 0.01, 0.1, 1.0)]
UNSUITABLE += [("coulomb", 0.0), ("coulomb_backward", 0.0), ("coulomb_backward", 91.0), ("stribeck_shape", 0.7)]
UNSUITABLE += [("stiction", 59.0), ("stiction_backward", 49.0), ("motor", 1.0), ("shares", 4 * [0.5])]
UNSUITABLE += [("displacements", one) for one in ([1e-3, 1e-3, 2e-3, 3e-3], [1e-3, 2e-3, 3e-3])]


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


SIZES = """inertia coulomb stiction viscous coulomb_backward stiction_backward viscous_backward offset gravity stiffness
    damping link_stiffness link_damping hysteresis attraction"""
"""Fields of joints that are a torque, or are proportional to one."""


def joint_figures(name):
    """Return where a joint of a kind comes to, of one shape of its curve after the other, changed on the way."""
    kind, further = KINDS[name]
    time, found = 1e-3 * np.arange(300), {}
    torques = 140.0 * np.sin(20.0 * time) + 60.0 * np.sin(71.0 * time)
    shapes = {"shape 1": (1.0, {}), "shape 2": (1.0, {"stribeck_shape": 2.0, **TWO_SIDED}), "small": (1e-3, TWO_SIDED)}
    for label, (size, changes) in shapes.items():
        fields = {**CURVE, **further, **changes}
        fields |= {one: size * fields[one] for one in SIZES.split() if one in fields}
        joint = Joint(kind(**fields), velocity=0.02)
        for torque in size * torques:
            joint.step(torque, 1e-3)
        found |= dict(numbers(joint.state._asdict(), label))
        found[f"{label} sensed"] = SENSED_VELOCITY[type(joint.state)](joint.state)
        change = JointChange(*(1.1 + 0.1 * place for place, _ in enumerate(JointChange._fields)))
        parameters = type(joint._parameters)
        found |= dict(numbers(CHANGE_JOINT[parameters](joint._parameters, change)._asdict(), f"{label} changed"))
        found |= dict(numbers(SCALE_JOINT[parameters](joint._parameters, 1.3)._asdict(), f"{label} scaled"))
        for field, value in UNSUITABLE:
            found[f"{label} {field} {value}"] = words_of(kind, **{**fields, field: value})
    return found


ROUND = {"inertia": 1.0, "coulomb": 1.0, "viscous": 1.0, "stribeck_velocity": 2.0, "solver_period": 2.0**-10}
ROUND |= {"stiffness": 2.0**14, "damping": 2.0, "link_share": 0.5, "link_stiffness": 2.0**14, "link_damping": 32.0}
ROUND |= {"gap": 2.0**-9, "hysteresis": 4.0, "displacements": [2.0**-12, 2.0**-11, 2.0**-10, 2.0**-9]}
ROUND |= {"attraction": 2.0**12, "rolling_range": 2.0**-9, "presliding": 2.0**-10, "friction_lag": 0.0, "gravity": 0.0}


def round_figures(name):
    """Return digests of the ways of a joint of round numbers, whose limits torques meet exactly."""
    kind, found = KINDS[name][0], {}
    for stiction, velocity in ((1.0, 0.0), (1.5, 0.0), (1.0, 2.0**-9)):
        fields, words = {**ROUND, "stiction": stiction}, []
        made = kind(**{key: value for key, value in fields.items() if key in kind.model_fields})
        for torques in itertools.product((-2.0, -1.0, 0.0, 1.0, 1.5), repeat=3):
            joint = Joint(made, velocity=velocity)
            for torque in (*torques, 0.0):
                joint.step(torque, 2.0**-10)
                words += plain(joint.state)
        found[f"stiction {stiction} from {velocity}"] = digest(words)
    return found


def words_of(function, *arguments, show=lambda value: digest(plain(value)), **named):
    """Return a digest of what a function gives, or what it refuses with."""
    try:
        value = function(*arguments, **named)
    except (ValueError, TypeError, ArithmeticError) as error:
        return str(error).rpartition("Value error, ")[2].partition(" [type=")[0]  # of a table, without its frame
    return show(value) if not hasattr(value, "model_dump") else "accepted"


INPUTS = controllers.Inputs._fields
MOVING = [INPUTS.index(one) for one in ("reference", "next_reference", "acting_reference", "velocity")]
TORQUES = [INPUTS.index(one) for one in ("realised_torque", "feedforward", "inertia")]


def controller_figures(make, samples=110, torque=1.0, speed=1.0):
    """Return torque and state of a controller in plain Python along made-up inputs, before and after a new start.

    Torques and speeds are smaller by a factor.
    """
    controller = make()
    controller.run_uncompiled()
    found = {"new": digest(plain(controller.diagnose()))} if hasattr(controller, "diagnose") else {}
    for start in ("cold", "restarted", "held"):
        inputs = made_up_inputs(controller.period, samples, seed=103)
        inputs[:, TORQUES] *= torque
        inputs[:, MOVING] *= speed
        inputs[1:4, MOVING[1:3]] = math.nan  # what comes next is not given at first
        inputs[60:75, MOVING] = 0.0  # it rests a while
        inputs[85:, MOVING] = inputs[85:86, MOVING]  # and moves evenly at the end
        if start == "held" and hasattr(controller, "enabled"):
            controller.enabled = False
        given = np.array([controller.step_plain(controllers.Inputs(*row.tolist())) for row in inputs])
        found |= {f"{start} torque": rms(given[:, 0]), f"{start} feedforward": rms(given[:, 1])}
        found |= {f"{start} last": float(given[-1, 0]), f"{start} faults": controller.faults}
        found |= dict(numbers(controller.estimates, f"{start} estimate"))
        found[f"{start} state"] = state_size(controller)
        said = read_of(controller)
        found[f"{start} flags"] = digest([f"{name} {value}" for name, value in said.items() if isinstance(value, int)])
        found[f"{start} numbers"] = size_of({name: one for name, one in said.items() if isinstance(one, float)})
        if isinstance(controller, adaptive_ff.AdaptiveController):
            found |= {f"{start} {name}": value for name, value in told(controller).items()}
        controller.restart()
    found["refused"] = words_of(controller.take_over, 12.0, 0.1, 0.09, next_reference=0.11)
    found["taken over"] = controller.step(0.11, 0.1, next_reference=0.12)
    controller.state_from_json(controller.state_to_json())
    found["read again"] = state_size(controller)
    return found


FIRST = {"model": adaptive_ff.TorqueModel(20.0, 60.0, 90.0, 80.0, 0.02, 0.05, 1.0), "deviation": 0.3}
OPTIONS = {
    "model": FIRST,
    "first values": {"model": {"inertia": 25.0, "coulomb": 40.0, "friction_lag": 0.01}, "deviation": {"coulomb": 0.4}},
    "map given": {**FIRST, "position_hats": 5, "position_range": [-0.4, 0.4], "position_map": [1, 1.2, 0.9, 1.1, 1]},
    "map vague": {"position_hats": 3, "position_range": [-0.4, 0.4], "map_deviation": [0.2, 0.1, 0.3]},
    "waves given": {**FIRST, "position_periods": [0.5, 0.3], "position_map": [0.2, -0.1, 0.3, 0.1], "regressors": 1},
    "unknown torque": {"torque_limit": None},
    "limit": {"torque_limit": 60.0, "friction_share": 0.7, "memory": 2.0},
    "gear": {"gear_ratio": -3.0, "regressors": 2, "observer_bandwidth": 2.0},
    "dynamics": {"feedforward_includes_inertia": True, "stribeck_shape": 2.0},
}
"""Further arguments of the adaptive controller."""


def read_of(controller):
    """Return the numbers and flags that can be read of a controller, by name."""
    names = [name for name, kind in inspect.getmembers(type(controller)) if isinstance(kind, property)]
    found = {name: getattr(controller, name) for name in names if name[0] != "_"}
    return {name: value for name, value in found.items() if isinstance(value, int | float)}


def told(controller):
    """Return what an adaptive controller says of itself: uncertainties, diagnosis, the map that it has learnt."""
    found = dict(numbers(controller.uncertainties, "uncertainty"))
    found["diagnosis"] = digest(plain(controller.diagnose()))
    learnt = controller.learnt_map
    if learnt is not None:
        found |= {"map": rms(learnt.factor * np.arange(1.0, learnt.factor.size + 1.0)), "over load": learnt.load_share}
        found |= {"map from": float(np.sum(np.arctan(learnt.position))), "map again": sum(learnt.periods)}
    return found


def state_size(controller):
    return size_of(controllers.plain_state(controller.state))


def size_of(content):
    """Return one number of all finite ones of nested tables."""
    values = [value for _, value in numbers(content) if math.isfinite(value)]
    return float(np.sum(np.arctan(values) * np.cos(np.arange(len(values)))))


OBSERVERS = (controllers.DisturbanceObserver, controllers.ExtendedState, controllers.KalmanDisturbance)


def design_figures():
    """Return gains and margins of loops, observers and cascades, behind estimators of velocity too, and refusals."""
    found = {}
    settled = controllers.kalman_velocity_gains(1e-4, 10.0, 0.001)
    estimators = {"": None, "low-pass": controllers.low_pass_velocity(0.001, 60.0)}
    estimators["kalman"] = controllers.kalman_velocity(*settled, 0.001)
    for delay, names in ((0, ("", "low-pass")), (2, ("kalman",))):
        for name in names:
            velocity = estimators[name]
            loop = {"delay": delay, "velocity": velocity}
            limit = controllers.fastest_bandwidth(0.001, **loop)
            design = controllers.PI.design(20.0, 0.001, 0.4 * limit, **loop)
            margins = controllers.loop_margins_of(design.systems(friction_slope=-30.0))
            cascade = controllers.PositionLoop.design(0.001, 0.4 * limit, **loop)
            tables = {"limit": limit, "pi": asdict(design), "falling": asdict(margins), "cascade": asdict(cascade)}
            for kind in OBSERVERS if name != "low-pass" else ():
                gains = (design.proportional, design.integral)[: 1 if kind is controllers.ExtendedState else 2]
                bandwidth = 0.1 * limit if kind is controllers.KalmanDisturbance else None  # its search takes long
                tables[kind.__name__] = asdict(kind.design(20.0, 0.001, *gains, bandwidth, **loop))
            found |= dict(numbers(tables, f"{delay} {name}".strip()))
            for function, given in (
                (controllers.PI.design, (20.0, 0.001, 1.2 * limit)),
                (controllers.PositionLoop.design, (0.001, 0.4 * limit, 90.0)),
                (controllers.PositionLoop.design, (0.001, 1.5 * limit)),
            ):
                found[f"{delay} {name} {function.__qualname__} {len(given)}"] = words_of(function, *given, **loop)
    systems = controllers.loop_systems(800.0, 0.0, 20.0, 0.001, delay=1, friction_slope=20.0)
    found |= dict(numbers({name: [*one.num[0][0], *one.den[0][0]] for name, one in systems._asdict().items()}))
    for wrong in ({"delay": 0.5}, {"maximum_sensitivity": 1.0}, {"bandwidth": 90.0}):
        found[str(wrong)] = words_of(controllers.design_position_loop, **{"period": 0.01, "bandwidth": 5.0, **wrong})
    found["walk"] = controllers.KalmanDisturbance.walk(20.0, 0.001, 0.002, 8.0)
    return found


def fit_figures():
    """Return what the paper's fits give of a joint's records."""
    time = 0.005 * np.arange(2000)
    velocity = 0.2 * np.sin(1.9 * time) + 0.1 * np.sin(5.3 * time + 0.4)
    sign, generator = np.sign(velocity), np.random.default_rng(101)
    friction = sign * (60.0 + 30.0 * np.exp(-np.abs(velocity) / 0.05))
    torque = 20.0 * np.gradient(velocity, time) + 80.0 * velocity + friction
    torque += 0.5 * generator.standard_normal(time.size)
    series = adaptive_ff.identify_series(velocity, torque, 0.005, stribeck_velocity=0.05, use=np.abs(velocity) > 0.01)
    form = adaptive_ff.identify_torque_form(
        time, velocity, torque, stribeck_velocity=0.05, filter_pole=30.0, slowest=0.01, hold=0.1, confidence=0.9
    )
    speeds = np.geomspace(0.005, 0.4, 10)
    drives = np.repeat(np.concatenate([speeds, -speeds])[:, np.newaxis], 6, axis=1)
    readings = np.sign(drives) * (60.0 + 30.0 * np.exp(-np.abs(drives) / 0.05)) + 80.0 * drives + 2.0
    noise = generator.standard_normal(drives.shape) * (0.5 + np.abs(drives))
    points = adaptive_ff.support_points(drives, readings + noise)
    found = {"series": tables(series.physical), "form": tables(form.physical), "used": int(np.sum(form.used))}
    found |= {"rows": int(np.sum(series.used)), "points": rms(points.standard_error), "torque": rms(points.torque)}
    both, forward = (points.velocity, points.torque, points.standard_error), points.velocity > 0.0
    found["both"] = adaptive_ff.fit_stribeck(*both, confidence=0.9).estimates
    found["forward"] = adaptive_ff.fit_stribeck(points.velocity[forward], points.torque[forward]).estimates
    return dict(numbers({name: tables(one) if name in ("both", "forward") else one for name, one in found.items()}))


CURVES = {
    "steep": lambda speed, sign: 3.0 + 1.5 * np.exp(-((speed / 0.05) ** 2)) + 8.0 * speed,
    "no excess": lambda speed, sign: 3.0 + 8.0 * speed,
    "no coulomb": lambda speed, sign: 1.5 * np.exp(-speed / 0.1) + 8.0 * speed,
    "two-sided": lambda speed, sign: 3.0 + 0.4 * sign + (1.5 + 0.3 * sign) * np.exp(-speed / 0.05) + 8.0 * speed,
    "falling": lambda speed, sign: 9.0 - 8.0 * speed,
}
"""Friction over speed and direction, N m."""


def curve_figures():
    """Return what is made of points along curves, exact and noisy, few and many."""
    found, points = {}, [("few", 7, 0.05, 0.8), ("many", 30, 0.02, 0.95), ("nearly exact", 9, 1e-3, 0.5)]
    for name, curve in CURVES.items():
        for label, count, noise, confidence in points:
            speed = np.geomspace(0.004, 0.6, count)
            sign = np.where(np.arange(count) % 2, -1.0, 1.0) if name == "two-sided" else np.ones(count)
            error = 1.0 + np.arange(count) % 3
            torque = sign * curve(speed, sign) + noise * error * np.random.default_rng(107).standard_normal(count)
            with warnings.catch_warnings(record=True) as said:
                warnings.simplefilter("always")
                errors = error if count > 9 else None
                fit = adaptive_ff.fit_stribeck(sign * speed, torque, errors, confidence=confidence)
            found[f"{name} {label} warns"] = " | ".join(NAMED.sub("#", str(one.message)) for one in said)
            values = {"scatter": fit.scatter, "determined": int(fit.determined)}
            values["curve"] = rms(fit.curve([-0.1, 0.0, 0.02]))
            found |= dict(numbers(tables(fit.estimates) | values, f"{name} {label}"))
    return found


def sines(further, every=10, count=0.0):
    """Return a log of a joint with a further torque along three sines, some rows of those at 1 kHz, in counts (rad)."""
    log = sines_log(further, seconds=14, rate=1000)[0]
    position = count * np.round(log.position / count) if count else log.position
    return Log(log.name, log.time[::every], log.torque[::every], position=position[::every])


def lagged(velocity, lag=30):
    """Return the sign of a velocity behind a first-order lag (samples)."""
    return lfilter([1.0 / lag], [1.0, 1.0 / lag - 1.0], np.sign(velocity))


def carried(position, velocity, inertia=0.0):
    """Return the torque of a weight, and that of an inertia (at 1 kHz)."""
    return 3.0 * np.sin(position) + inertia * np.gradient(velocity)


def jittered(size):
    """Return a log whose clock jitters (s)."""
    log = make_log(14.0, 0.01, 0.05)
    return Log(log.name, log.time + size * np.sin(3.0 * log.time) ** 5, log.torque, position=log.position)


def steered(velocity, further=None):
    """Return a log of a joint along a velocity of the time (s), with a known torque, rad, beside."""
    time = 0.01 * np.arange(1400)
    speed = velocity(time)
    position = np.cumsum(speed) * 0.01
    known = 2.0 * np.cos(1.3 * position)
    torque = 2.0 * np.gradient(speed, time) + 4.0 * speed + np.sign(speed) * (3.0 + 0.2 * np.abs(known)) - known
    beside = further(position, speed) if further else 0.0
    torque += coloured(time.size, 0.01, 0.05, np.random.default_rng(105)) + beside
    return Log("steered", time, torque, position=position, extra={KNOWN: known})


def swept(time):
    return np.sin(2.0 * time + 0.3 * time**2) + 0.6 * np.sin(0.9 * time)


def another():
    """Return a log of the joint from 100 s on with a gap of a second in it."""
    log = steered(lambda time: swept(time + 3.0))
    left = log.part(np.abs(log.time - 9.0) > 0.5)
    return replace(left, name="another", time=left.time + 100.0)


LOGS = {
    "validated": (partial(steered, swept), {"torque_delay": 0.02, "load_friction": True, "validation": another}),
    "known": (partial(steered, swept), {"load_friction": True, "model": "gravity-directions"}),
    "two periods": (
        partial(steered, swept, lambda q, w: np.sin(9.0 * q) + (0.8 * np.cos(5.0 * q)) * np.sign(w)),
        {"position_periods": [2.0 * math.pi / 9.0, 2.0 * math.pi / 5.0], "model": "gravity", "confidence": 0.8},
    ),
    "linear hats": (
        partial(steered, swept, lambda q, w: np.where(np.abs(q) < 0.2, 1.5, 0.0) * np.sign(w) - 0.9 * np.abs(w)),
        {"linear": True, "is_current": True, "position_hats": 2, "model": "directions", "held_out": 0.2},
    ),
    "loaded": (
        partial(sines, lambda q, w: carried(q, w) + (0.6 + 0.3 * np.abs(carried(q, w, 500.0))) * np.tanh(80.0 * w), 4),
        {"confidence": 0.9},
    ),
    "counts": (partial(sines, lambda q, w: 2.0 * np.tanh(80.0 * w), 1, 0.02), {}),
    "early": (partial(sines, lambda q, w: 3.0 * np.tanh(80.0 * w) - lagged(w, 9), 4), {}),
    "massless": (partial(sines, lambda q, w: np.tanh(80.0 * w) - 520.0 * np.gradient(w), 5), {}),
    "two speeds": (partial(steered, lambda time: 1.0 + 0.6 * (time % 6.0 > 3.0)), {"model": "offset"}),
    "one-way": (partial(steered, lambda time: 1.2 + swept(time) * 0.5), {"model": "offset"}),
    "one sine": (partial(steered, lambda time: np.sin(5.0 * time)), {"bandwidth": 8.0, "torque_delay": -0.01}),
    "stops": (partial(steered, lambda time: swept(time) * (np.sin(1.1 * time) > -0.3)), {"model": "coulomb-viscous"}),
    "free": (partial(make_log, 14.0, 0.01, 0.05), {"confidence": 0.9}),
    "velocity": (partial(make_log, 14.0, 0.01, 0.05, as_position=False), {"held_out": 0.3, "torque_delay": 0.005}),
    "linear": (partial(make_log, 14.0, 0.01, 0.05, 102), {"linear": True, "bandwidth": 6.0, "model": "symmetric"}),
    "current": (partial(make_log, 14.0, 0.01, 0.05, asymmetry=1.5), {"is_current": True}),
    "weight": (partial(sines, lambda q, w: 3.0 * np.sin(q + 0.3) + np.tanh(50.0 * w)), {}),
    "map": (partial(sines, lambda q, w: (2.0 + 1.4 * np.sin(1.2 * q)) * np.tanh(80.0 * w)), {"position_hats": 5}),
    "waves": (partial(sines, lambda q, w: (2.0 + np.sin(4.0 * q)) * np.tanh(80.0 * w)), {"position_periods": [1.5708]}),
    "lag": (partial(sines, lambda q, w: 3.0 * lagged(w), 4), {"is_current": True}),
    "path": (partial(sines, lambda q, w: 3.0 * np.roll(np.sign(w), 40), 4), {}),
    "stick": (partial(sines, lambda q, w: (2.0 + 2.0 * np.exp(-np.abs(w) / 0.2)) * np.tanh(80.0 * w)), {}),
    "dip": (partial(sines, lambda q, w: (3.0 - 2.0 * np.exp(-np.abs(w) / 0.2)) * np.tanh(80.0 * w), 5), {}),
    "unloaded": (
        partial(steered, swept, lambda q, w: -0.8 * np.abs(np.cos(1.3 * q)) * np.sign(w)),
        {"load_friction": True},
    ),
    "jitter": (partial(jittered, 0.0005), {"confidence": 0.99}),
    "gaps": (partial(jittered, 0.008), {"model": "directions"}),
    "viscous": (partial(make_log, 14.0, 0.01, 0.05, 104, -6.0, coulomb=0.1), {}),
    "slow": (lambda: replace(make_log(15.0, 0.05, 0.05), time=0.75 * np.arange(300)), {"model": "coulomb-viscous"}),
}
"""Logs in closed form, and how they are identified."""


def identified_figures(name):
    """Return what is identified from a log, in which words it is written and said, and the score of that model."""
    make, options = LOGS[name]
    log, options = make(), {key: one() if callable(one) else one for key, one in options.items()}
    found = adaptive_ff.identify_log(log, **options)
    texts = {kind: words_of(found.simulator, kind, gear_ratio=3.0) for kind in ENDINGS}
    without_noise = partial(re.sub, r"_noise = \S+", "")  # of which the digits are those of rounding
    texts["scenario"] = words_of(lambda: without_noise(scenario_text(found, "reference.csv")))
    texts["reference"] = digest(plain(reference_columns(found)))
    texts |= {f"first {one}": words_of(found.first_estimate, *one) for one in ((), (1.7,), (1.7, WITH_OFFSET))}
    texts["turned"] = words_of(found.simulator, "mjcf", gear_ratio=-3.0)
    texts |= {"verdict": " | ".join(verdict_lines(found)), "details": " | ".join(details(found))}
    score, other, asked = {}, options.get("validation", log), {**options, "validation": options.get("validation")}
    try:
        with patch("adaptive_ff.identify.score.identify_log", lambda *given, **more: found if more == asked else None):
            score = score_log(log, other, **options).to_dict() | {"identification": {}}
    except adaptive_ff.InputError as error:
        texts["score"] = str(error)
    texts["cautions"] = " | ".join([score.get("verdict", ""), *score.get("warnings", ())])
    curve = {"curve": found.friction(np.array([-0.3, 0.0, 0.02])).tolist()}
    return dict(numbers(found.to_dict() | curve)) | dict(numbers(score, "score")) | texts


def leaves(content, name=""):
    """Yield list or table, key and full name of the numbers in content of JSON, of each list the first and last."""
    for key in content if isinstance(content, dict) else sorted({0, len(content) - 1}):
        if isinstance(content[key], dict | list):
            yield from leaves(content[key], f"{name} {key}") if content[key] else ()
        else:
            yield content, key, f"{name} {key}"


def restored_figures(make):
    """Return digests of what is said of a saved state with another number in one place, by place."""
    controller = make()
    for row in made_up_inputs(controller.period, 40, seed=104):
        controller.step_plain(controllers.Inputs(*row.tolist()))
    saved, found, learns = json.loads(controller.state_to_json()), {}, hasattr(controller, "diagnose")
    for content, key, name in leaves(saved):
        known, said = content[key], []
        is_own = "belongs_to" in name and isinstance(known, float)
        near = (known * (1.0 + 1e-10), known * (1.0 + 3e-9)) if is_own else ()
        for content[key] in (0, -1.0, 5, 1e9, -1e18, 90 * "x", *near):
            said.append(words_of(controller.state_from_json, json.dumps(saved)))
        said += [f"{one.code} {one.names}" for one in controller.diagnose().findings] if learns else []
        limits = "".join(text.partition("must be ")[2] + text.partition("at most ")[2] for text in said)
        most = {float(one) for one in NAMED.findall(limits)}
        near = [(one - 1e-9, one, float(np.nextafter(one, np.inf)), one + 1e-9, one + 2e-9) for one in sorted(most)]
        for content[key] in itertools.chain(*near):
            said.append(words_of(controller.state_from_json, json.dumps(saved)))
        found[name], content[key] = digest(said), known
    return found


LADDER = (-1e3, -1, 0.0, 1e-9, 1e-3, 0.05, 0.3, 0.5, 1, 1.5, 2, 5, 10, 11, 20, 21, 100, 1e3, 1e5, 1e6, 1e12, 1e200)
SLOW_NAMES = """Comparison Disturbance.gains Joint.step Repetitive compare design export_ fastest fit_ identify_ kalman_
    read_ run_in simulate systems"""


NAMED = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.])")


def said_at_limits(outcome):
    """Return what comes of numbers of all sizes, then of those that a refusal names, exactly and next to them."""
    said = [outcome(value) for value in LADDER]
    named = {float(one) for text in said if " " in text for one in NAMED.findall(text)}.difference(LADDER)
    return said + [outcome(float(np.nextafter(one, way))) for one in sorted(named) for way in (-np.inf, one, np.inf)]


def argument_figures():
    """Return digests of what comes of numbers, for each argument of what is public."""
    found = {}
    for name in of_kind(*NUMBERS):
        for argument in () if any(one in name for one in SLOW_NAMES.split()) else each(name, *NUMBERS):

            def outcome(one):
                return words_of(call, name, **{argument: one})  # noqa: B023

            found[f"{name} {argument}"] = digest(said_at_limits(outcome))
    return found


DESIGNS = """
    fastest_bandwidth design_pi design_position_loop kalman_velocity_gains loop_systems PI.design PositionLoop.design
    DisturbanceObserver.design ExtendedState.design"""


def edge_figures():
    """Return digests, to three digits, of what designs make of numbers of all sizes, for each argument."""
    found = {}
    for name in DESIGNS.split():
        for argument in each(f"controllers.{name}", *NUMBERS):
            further = (1000, 1001) if (name, argument) == ("loop_systems", "delay") else ()
            further = (50.0,) if argument == "bandwidth" else further  # half of the sampling frequency
            made = partial(words_of, call, f"controllers.{name}", show=lambda value: " ".join(plain(value)))
            with np.errstate(all="ignore"):
                values = (-1, 0.0, 0.5, 1e-3, 1.001, 1.2, 2, 3, 10, 1e5, 1e200, *further)
                said = [made(**{argument: value}) for value in values]
            found[f"{name} {argument}"] = digest([NAMED.sub(lambda one: f"{float(one[0]):.3g}", one) for one in said])
    return found


TABLES_OF_PLANT = {
    **{name: (kind, {**CURVE, **further}) for name, (kind, further) in KINDS.items() if name != "lugre"},  # takes long
    "two-sided": (joints.JointModel, {**CURVE, **TWO_SIDED}),
    "linear": (joints.JointModel, {**CURVE, "axis": "linear"}),
    "sensor": (plant.Sensor, {"leap": 0.3, "leap_share": 0.01, "held": 3, "held_share": 0.02}),
    "encoder": (plant.Sensor, {"encoder_resolution": 1e-3, "ripple_amplitude": 1e-3, "ripple_period": 0.2}),
    "actuator": (plant.Actuator, {"torque_limit": 300.0, "torque_resolution": 1.0, "ripple_amplitude": 3.0}),
    "change": (plant.FrictionChange, {"time": 1.0}),
    "variation": (plant.FrictionVariation, {}),
}
"""Tables, and fields that they are made with."""


def field_figures():
    """Return digests of what is said of numbers in each field of a table, those of its other fields among them."""
    found = {}
    for name, (table, fields) in TABLES_OF_PLANT.items():
        ties = [one for one in fields.values() if isinstance(one, float)]
        beside = [float(np.nextafter(one, way)) for one in ties for way in (-np.inf, one, np.inf)]
        for field in table.model_fields:

            def outcome(one):
                return words_of(table, **{**fields, field: one})  # noqa: B023

            found[f"{name} {field}"] = digest([*said_at_limits(outcome), *map(outcome, beside)])
    return found


def below(table):
    """Return the tables of joints and scenarios that are made of one."""
    own = [one for one in table.__subclasses__() if one.__module__.startswith(("plant", "adaptive_ff.scenario"))]
    return own + [further for one in own for further in below(one)]


def documented_figures():
    """Return digests of documentation that is put together: of every table, and of some controllers."""
    found = {}
    for one in (*below(Table), controllers.DisturbanceObserver, controllers.SuperTwisting):
        names = [name for name in dir(one) if not name.startswith("__")]
        text = inspect.cleandoc(str(one.__doc__))  # its indentation depends on the interpreter
        found[f"{one.__module__}.{one.__name__}"] = digest([text, str(inspect.signature(one)), *names])
    return dict(sorted(found.items()))


def tables(estimates):
    return {name: list(one) for name, one in estimates.items()}


def export_figures():
    """Return digests of the files of exported controllers, numbers of versions apart."""
    found, loop, learning = {}, controllers.PI(1256.0, 15800.0, 0.01, delay=1.5), adaptive_variants()["map"]()
    options = {"single": True, "prefix": "axis"}
    for label, exported, given in (("double", loop, {}), ("single", loop, options), ("adaptive", learning, options)):
        with TemporaryDirectory() as folder:
            for file in sorted(adaptive_ff.export_controller(exported, folder, **given)):
                text = file.read_text(encoding="utf-8").replace(adaptive_ff.__version__, "")
                if exported is loop:
                    found[f"{label} {file.name}"] = digest([text])
                elif file.stem == "axis":  # numbers of its self-test are of one processor
                    found[f"{label} {file.name}"] = digest([NAMED.sub(lambda one: f"{float(one[0]):.6g}", text)])
    return found


SLOW, HALVED = {"sampling": {"period": 0.03}, "feedback": {"bandwidth": 2.0}}, {"time": 3.0, "friction_scale": 0.5}
REFUSED = [
    {"joint": {"stiction": 59.0}},
    {"joint": {"solver_period": 0.1}, "sampling": {"period": 0.1}},
    *({"sampling": {"period": period}} for period in (0.0105, 0.0005, 0.001 / 3)),
    *({"duration": duration} for duration in (1e300, 10**18, 200_001.0, 5e-324, 0.009)),
    *({"change": [HALVED, {**HALVED, "time": time}]} for time in (3.0, 2.0, 60.0, 1e300)),
    {"change": [{"time": 3.0}]},
    {"joint": {"solver_period": 0.03}, "change": [{"time": 3.0, "friction_scale": 2.2}], **SLOW},
    {"joint": {"solver_period": 0.03}, "change": [{"time": 3.0, "inertia_scale": 0.4, "viscous_scale": 0.5}], **SLOW},
    *({"joint": {"axis": "linear"}, "adaptation": {"identify": one}} for one in ("gravity", "directions_and_gravity")),
    *({"feedback": {"inertia": inertia}} for inertia in (1e308, 1e153)),
    *({"feedback": {"bandwidth": bandwidth}} for bandwidth in (5e-324, 400.0)),
    *({"reference": {"frequencies": [0.1], "amplitudes": amplitudes}} for amplitudes in ([1.0, 2.0], [0.0])),
    *({"reference": {"frequencies": [0.1, most], "amplitudes": [1.0, 1e-9]}} for most in (50.0, 100.0, 1e308)),
    *({"reference": {"frequencies": [most], "amplitudes": [1.0]}} for most in (5.0, 40.0)),
    *({"reference": {"peak": peak}} for peak in (1e160, 1.7e308)),
    *({"reference": {"kind": "point_to_point", **one}} for one in ({}, {"positions": [0.0]}, {"distance": 0.0})),
    *({"reference": {"kind": "point_to_point", "distance": 0.1, one: -1.0}} for one in ("jerk", "dwell")),
    {"reference": {"kind": "point_to_point", "distance": 0.1, "positions": [0.1]}},
    {"reference": {"kind": "staircase", "velocities": [0.0]}},
    *({"sensor": {"velocity_noise": 0.0, one: size}} for one, size in (("leap", 3.0), ("held_share", 0.1))),
    {"sensor": {"velocity_noise": 0.0, "ripple_amplitude": 2.0}},
    {"sensor": {"velocity_noise": 0.0, "leap": 3.0, "leap_share": 0.1, "encoder_resolution": 1e-4}},
    {"sensor": {"encoder_resolution": 1e-4}},
    {"sensor": {"velocity_noise": 0.0, "encoder_resolution": 4096.0}},
    {"actuator": {"torque_limit": 400.0, "torque_resolution": 500.0}},
    {"actuator": {"delay": 0.0005}},
]
"""What no scenario may be made of, as changes of the built-in one."""


GAINS = {"proportional": 125.6, "integral": 1580.0, "inertia": 2.0, "stribeck_velocity": 0.05}
BEHIND = {**GAINS, "preceding": ["elbow"]}
UNUSABLE = [
    *(
        {"model": FIRST["model"]._replace(**one)}
        for one in ({"inertia": 1.9}, {"coulomb": -1.0}, {"viscous": math.nan}, {"stribeck_velocity": 0.1})
    ),
    *({"model": one} for one in ({"coulomb": 3.0}, {"inertia": 20.0, "colomb": 3.0})),
    *({**FIRST, "deviation": one} for one in (0.0, {"inertia": math.nan}, {"mass": 1.0})),
    *({"position_hats": count, "position_map": [0.1] * 3} for count in (0, 3)),
    *({one: [-1.0, 0.0]} for one in ("position_range", "position_periods", "ripple_periods")),
    *({"ripple_periods": [1.0], "regressors": count} for count in (18, 19)),
    *(
        {**FIRST, "position_hats": 2, **one}
        for one in ({"position_range": (1.0, 0.0)}, {"position_map": (0.1, -2.5)}, {"position_map": (2.0, -2.0)})
    ),
    {"map_deviation": -1.0},
    {"position_hats": 1},
]
JOINTS = [
    *({"a": 3}, {"a": {**GAINS, "preceding": ["b"]}}, {"shoulder": GAINS, "elbow": BEHIND}),
    *({"a": {**GAINS, "identify": one}} for one in ("all", ["offset"])),
    *({"a": {**GAINS, "preceding": one}} for one in ("a", ["a"])),
    *({"a": {**GAINS, one: -1.0}} for one in ("inertia", "regressors", "torque_limit", "period", "parameters", "mass")),
    *({"shoulder": GAINS, "elbow": {**GAINS, "preceding": ["shoulder"]}, one: BEHIND} for one in ("wrist", "shoulder")),
]
TABLES = [{}, {"period": 0.01}, *({"period": 0.01, "joints": one} for one in (1, {}, *JOINTS))]
TABLES += [{"period": period, "joints": {"a": GAINS}, **more} for period, more in ((0.0, {}), (0.01, {"gain": 1.0}))]
ARM = {"shoulder": {**GAINS, "gear_ratio": -2.0, "regressors": 1}, "elbow": {**BEHIND, "preceding": ["shoulder"]}}
ARM["wrist"] = {**BEHIND, "preceding": ["shoulder", "elbow"], "identify": "directions_and_gravity"}
WRONG = (math.nan, math.inf, "x", [1.0, 2.0], [0.1, math.nan, 0.1], 0.0, [0.1, 0.2, -1.0], [[1.0] * 3], 1e7, None)
WRONG += ([[2.0], None, []], [[2.0], None, [1.0]], [[1e7], None, None], [None], [["x"], None, None])


def group_figures():
    """Return torques and estimates of a chain of joints, and what is said of inputs, switches and states it has not."""
    group = adaptive_ff.JointGroup.from_table({"period": 0.01, "joints": ARM}).run_uncompiled()
    new = {name: state_size(one) for name, one in group.joints.items()}
    found, base = {}, {"reference": [0.1, 0.2, -0.1], "velocity": [0.1, 0.19, -0.1], "position": [0.1, 0.2, 0.3]}
    for sample in range(40):
        wave = np.sin(0.1 * sample + np.arange(3.0))
        position = [*(0.3 * wave[:2]), 0.1 if sample % 7 else math.nan]
        given = {"position": position, "regressors": [[wave[0]], None, None if sample % 2 else []]}
        torque = group.step(0.2 * wave, 0.19 * wave, next_reference=0.2 * np.cos(wave), **given)
    found |= dict(numbers({"torque": torque.tolist(), "estimate": group.estimates}))
    found |= {f"state of {name}": state_size(one) for name, one in group.joints.items()}
    saved = group.state_to_json()
    optional = [name for name in inspect.signature(group.step).parameters if name != "self"]
    for name, function in itertools.product(("torque", *optional), (group.step, group.take_over)):
        first = {} if function == group.step else {"torque": [1.0, 2.0, 3.0]}
        said = [words_of(function, **{**first, **base, name: one}) for one in WRONG]
        found[f"{function.__name__} {name}"] = digest(said)
        found[f"{function.__name__} {name} state"] = sum(state_size(one) for one in group.joints.values())
        group.state_from_json(saved)
    for name, one in itertools.product(("enabled", "feedforward_enabled"), (1, [True], [True, False, True], False)):
        found[f"{name} {one}"] = words_of(setattr, group, name, one) + str(getattr(group, name).tolist())
    mixed = adaptive_ff.JointGroup.from_table({"period": 0.01, "joints": {"a": GAINS, "b": GAINS}})
    mixed.joints["b"].run_uncompiled()
    found["mixed"] = digest(plain([mixed.step([0.1, 0.2], [0.1, 0.0]) for _ in range(3)]))
    torques = [group.step(wave, 0.9 * wave, position=wave) for _ in range(4)]
    found |= dict(numbers({"all switched off": np.transpose(torques).tolist()}))
    content = json.loads(saved)["group"]
    wrong = ({**content, "wrist": 3}, {**content, "hand": {}}, dict(reversed(content.items())), 3, [])
    texts = ("3", "{}", "x", *(json.dumps({"group": one}) for one in wrong))
    found["states"] = digest([words_of(group.state_from_json, text) for text in texts])
    group.restart()
    found["restarted"] = sum(state_size(one) for one in group.joints.values())
    group.reset()
    found["reset"] = str(new == {name: state_size(one) for name, one in group.joints.items()})
    return found


NOT_IDENTIFIED = [{"bandwidth": 200.0}, {"torque_delay": math.inf}, {"model": "lugre"}, {"load_friction": True}]
NOT_IDENTIFIED += [{"position_hats": -1}, {"position_hats": 2.5}, {"position_hats": 3, "position_periods": (1.0,)}]
NOT_IDENTIFIED += [{"held_out": one} for one in (-1e-9, 0.99, 0.9)] + [{"confidence": one} for one in (0.0, 0.5)]
NOT_IDENTIFIED += [{"bandwidth": 20.0 * (1.0 + one)} for one in (1e-9, 2e-9)]
NOT_IDENTIFIED += [{"torque_delay": one} for one in (-1.0, 1.0, -1.001, 1.001)] + [{"bandwidth": 1.0}]
NOT_IDENTIFIED += [{"position_hats": 1}, {"position_periods": (0.0,)}, {"confidence": 1.0}, {"held_out": 1.0}]


def spoilt():
    """Yield logs of which no joint can be told, with what is wrong with each."""
    log = make_log(14.0, 0.01, 0.05)
    noise = np.random.default_rng(106).standard_normal(log.time.size)
    still = np.zeros(log.time.size)
    series = {
        "opposite": (-log.torque, log.position),
        "unrelated": (40.0 * noise + log.torque, log.position),
        "exchanged": (log.position, log.torque),
        "noisy": (log.torque, log.position + 0.3 * noise),
        "still": (log.torque, still),
        "without torque": (still, log.position),
        "huge": (1e31 * log.torque, log.position),
        "tiny": (1e-32 * log.torque, log.position),
        "torn": (np.where(log.time > 7.0, math.nan, log.torque), log.position),
        "slow": (log.torque, 1e-12 * log.position),
        "holes": (np.where(log.time % 0.3 < 0.05, math.nan, 1.0), log.position),
        "degrees": (log.torque, np.degrees(log.position)),
    }
    for name, (torque, position) in series.items():
        yield name, Log(name, log.time, torque, position=position)
    yield "short", log.part(slice(60))


NOT_REPLAYED = [{"identify": "all"}, {"identify": "gravity"}, {"memory": -1.0}, {"ripple_periods": (0.0,)}]
NOT_REPLAYED += [{"state": "3"}, {"torque_delay": 3.0}]


def refused_figures():
    """Return what is said of scenarios, first models and groups of joints that cannot be, by what is given."""
    found = {str(changes): words_of(SCENARIO.modified, **changes) for changes in REFUSED}
    found |= {str(one): words_of(adaptive, WITH_OFFSET, **one) for one in UNUSABLE}
    return found | {str(one): words_of(adaptive_ff.JointGroup.from_table, one) for one in TABLES}


def refused_logs():
    """Return what is said of logs, and of options beside one, that cannot be."""
    log = make_log(14.0, 0.01, as_position=False)
    found = {f"replay {one}": words_of(replay_log, log, **one) for one in NOT_REPLAYED}
    found["validated on itself"] = words_of(adaptive_ff.identify_log, log, validation=log)
    said = partial(words_of, show=lambda value: "answered")  # digits of what such a log tells are those of rounding
    found |= {f"{name} log": said(adaptive_ff.identify_log, one) for name, one in spoilt()}
    found |= {f"{name} log replayed": said(replay_log, one) for name, one in spoilt() if name in ("still", "short")}
    found |= {f"{count} samples": words_of(adaptive_ff.identify_log, log.part(slice(count))) for count in (49, 50)}
    return found | {f"log {one}": words_of(adaptive_ff.identify_log, log, **one) for one in NOT_IDENTIFIED}


INNER = ("friction", "learning", "adaptive", "identify", "simulation")
ROOMS = ("plant", "controllers", *(f"adaptive_ff.{one}" for one in INNER))

STEPPED = (*NAMES, "adaptive_unsupervised")
"""Controllers that are made without a run of identification or tuning."""

MADE = {
    **{name: partial(made, name) for name in STEPPED},
    **{f"{name} late": partial(made, name, DELAYED) for name in STEPPED},
    **{f"adaptive with {name}": partial(adaptive, WITH_GRAVITY, **options) for name, options in OPTIONS.items()},
}

ROUNDED = {"inertia": 20.0, "stribeck_velocity": 0.0625, "parameters": PER_DIRECTION, "delay": 1.5}
ROUNDED |= {"velocity_lag": 0.004, "torque_limit": math.inf, "tuning": Tuning(velocity_deviation=0.0)}
FIXED = partial(adaptive_ff.AdaptiveController, 1024.0, 8192.0, 0.01, **ROUNDED)  # its largest torque is a round number
LIGHT = {"inertia": 0.02, "stribeck_velocity": 0.05, "parameters": WITH_GRAVITY}
SMALL = partial(adaptive_ff.AdaptiveController, *controllers.pi_gains(0.02, 10.0), 0.01, **LIGHT)
RESTORED = {"directions": FIXED, "paper": MADE["adaptive_paper late"]}

PARTS = {
    **{f"joint {name}": (joint_figures, (name,)) for name in KINDS},
    **{f"round joint {name}": (round_figures, (name,)) for name in KINDS},
    **{f"steps of {name}": (controller_figures, (make,)) for name, make in {**MADE, **adaptive_variants()}.items()},
    "steps of a small joint": (controller_figures, (SMALL, 110, 1e-3, 0.012)),
    "fits": (fit_figures, ()),
    "fits of curves": (curve_figures, ()),
    "refusals": (refused_figures, ()),
    "group of joints": (group_figures, ()),
    "refused logs": (refused_logs, ()),
    "export": (export_figures, ()),
    **{f"identified {name}": (identified_figures, (name,)) for name in LOGS},
    "kernels in C": (written_figures, ()),
    **{f"pieces of kernels {part}": (piece_figures, (part, 4)) for part in range(4)},
    **{f"functions of {room}": (digests, (room,)) for room in ROOMS},
    "designs": (design_figures, ()),
    "designs of numbers": (edge_figures, ()),
    "arguments": (argument_figures, ()),
    "fields": (field_figures, ()),
    "documentation": (documented_figures, ()),
    **{f"restored {name}": (restored_figures, (make,)) for name, make in RESTORED.items()},
}
