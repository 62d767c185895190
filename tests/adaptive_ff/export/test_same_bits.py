"""The exported code does what the kernels do: the same bits on x86-64 with glibc, and a state that goes both ways.

Single precision learns what double precision does, also where samples come fast and teach little each.
"""

import functools
import math
import platform

import numpy as np
import pytest
from closed_loops import SCENARIO as JOINT
from closed_loops import build_setup, make, own_loop
from exports import DELAYED, SIZES, adaptive, adaptive_variants, inputs, made, needs_gcc, steps_in_c, steps_in_python

from adaptive_ff import AdaptiveController, run_in_c
from adaptive_ff.baselines.repetitive import Repetitive
from adaptive_ff.errors import InputError
from adaptive_ff.export.buffer import HEADER, state_from_bytes, state_to_bytes
from controllers import PI

pytest.importorskip("cffi", reason="cffi is not installed")
pytestmark = [needs_gcc, pytest.mark.usefixtures("compiled_quickly")]

LATE = "pi oracle disturbance_observer adaptive_paper canudas_measured friction_observer lee_tomizuka"
AT_ONCE = "extended_state kalman_disturbance canudas feedback_error radial_basis lugre_gradient"
MADE = {
    **{name: functools.partial(made, name, DELAYED) for name in LATE.split()},
    **{name: functools.partial(made, name) for name in AT_ONCE.split()},
    "repetitive over 40 samples": lambda: Repetitive(2000.0, 5000.0, 0.01, inertia=20.0, cycle=40, lead=2),
    "adaptive": adaptive,
    "adaptive with offset and lag": lambda: adaptive(SIZES["offset"], 0.0, 0.004),
    "adaptive by direction with delay": lambda: adaptive(SIZES["directions"], 1.5, 0.004),
    "adaptive with ripples": adaptive_variants()["ripples"],
    "adaptive with a map of friction": adaptive_variants()["map"],
    "adaptive with a first map of friction": lambda: adaptive_variants()["map"](
        model={"inertia": 20.0, "friction_lag": 0.02, "coulomb": 60.0}, position_map=[0.3, 0.1, *[0.0] * 9]
    ),
}


EXACT = platform.machine() in ("x86_64", "AMD64") and platform.libc_ver()[0] == "glibc"


def same(found, expected):
    """Bit for bit on x86-64 with glibc, else to rounding."""
    if EXACT:
        return np.array_equal(found, expected)
    return np.allclose(found, expected, rtol=1e-11, atol=1e-11 * np.max(np.abs(expected)))


@functools.cache
def runner_of(name):
    """A runner that tests share; each leaves it as new, whichever comes first."""
    return run_in_c(MADE[name]())


@pytest.mark.parametrize("name", MADE)
def test_torque_and_state_are_those_of_the_kernels(name):
    controller, runner = MADE[name](), runner_of(name)
    rows = inputs(controller)
    assert np.isnan(rows).any(axis=0).sum() >= 3
    expected = steps_in_python(controller, rows)
    assert np.ptp(expected[:, 0]) > 10.0
    assert same(steps_in_c(runner, rows), expected)
    if EXACT:
        assert runner.state_to_json() == controller.state_to_json()
    assert runner.estimates == pytest.approx(controller.estimates)
    assert runner.rejected == controller.rejected > 0
    runner.reset()


def test_a_state_goes_from_python_to_c_and_back():
    controller = MADE["adaptive with offset and lag"]()
    rows, runner = inputs(controller, 150), runner_of("adaptive with offset and lag")
    steps_in_python(controller, rows[:50])
    runner.state_from_json(controller.state_to_json())
    found = steps_in_c(runner, rows[50:100])
    again = MADE["adaptive with offset and lag"]()
    again.state_from_json(runner.state_to_json())
    runner.reset()
    expected = steps_in_python(controller, rows[50:])
    assert same(np.vstack([found, steps_in_python(again, rows[100:])]), expected)


def test_an_exported_controller_starts_in_the_state_that_it_has_and_resets_to_that_of_a_new_one():
    controller = adaptive()
    rows = inputs(controller)
    steps_in_python(controller, rows[:100])
    runner = run_in_c(controller)
    assert runner.state_to_json() == controller.state_to_json()
    found = steps_in_c(runner, rows[100:])  # which leaves the controller as it is
    assert same(found, steps_in_python(controller, rows[100:]))
    runner.reset()
    assert runner.state_to_json() == adaptive().state_to_json()


def test_it_is_used_like_the_controller_that_it_was_made_from():
    setup = build_setup(JOINT.modified(duration=2.0))
    runner = run_in_c(make("adaptive"))
    lost = {50: math.nan}
    assert same(own_loop(runner, setup, lost=lost), own_loop(make("adaptive").run_uncompiled(), setup, lost=lost))
    assert runner.enabled
    runner.enabled = False
    before = {name: value for name, value in runner.estimates.items() if name != "offset"}
    own_loop(runner, setup)
    assert runner.estimates.items() >= before.items()
    with pytest.raises(ValueError, match="reference = nan is not allowed"):
        runner.step(math.nan, 0.0)
    with pytest.raises(ValueError, match="dt = 0"):
        runner.step(0.0, 0.0, dt=0.0)


def test_further_regressors_reach_the_c_code_and_the_last_ones_hold():
    controller = adaptive(SIZES["offset"], regressors=2)
    runner, silent = run_in_c(controller), adaptive(SIZES["offset"], regressors=2)
    found, expected, without = [], [], []
    for k in range(300):
        plan, measured = 0.2 * math.sin(0.03 * k), 0.19 * math.sin(0.03 * k - 0.03)
        given = [math.sin(0.05 * k), math.nan if k % 9 == 4 else math.cos(0.031 * k)]
        known = {"regressors": given} if k % 7 else {}
        found.append(runner.step(plan, measured, **known))
        expected.append(controller.step(plan, measured, **known))
        without.append(silent.step(plan, measured))
    assert same(np.array(found), np.array(expected))
    assert runner.regressors.tolist() == controller.regressors.tolist()
    assert np.max(np.abs(np.array(found) - without)) > 10.0
    with pytest.raises(ValueError, match=r"^regressors has shape \(1,\)"):
        runner.step(0.1, 0.1, regressors=[0.5])


def test_a_takeover_in_c_is_that_of_python():
    controller, runner = adaptive(), runner_of("adaptive")
    for one in (controller, runner):
        for k in range(50):
            one.step(0.01 * k, 0.009 * k)
        one.take_over(33.0, 0.5, 0.49)
    assert runner.step(0.5, 0.49) == pytest.approx(33.0, abs=1e-9)
    before = runner.state_to_json()
    with pytest.raises(ValueError, match=r"^reference = nan"):
        runner.take_over(33.0, math.nan, 0.49)
    assert runner.state_to_json() == before
    runner.reset()


@pytest.mark.parametrize(
    "name", ["pi", "kalman_disturbance", "adaptive by direction with delay", "adaptive with ripples"]
)
def test_a_restart_in_c_is_that_of_python(name):
    controller, runner = MADE[name](), runner_of(name)
    steps_in_python(controller, inputs(controller, 80))
    controller.restart()
    steps_in_c(runner, inputs(controller, 80))
    runner._library.controller_restart(runner._handle)
    assert runner.state_to_json() == controller.state_to_json()
    runner.reset()


def test_without_a_compiler_it_says_so(monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(InputError, match="C compiler"):
        run_in_c(made("pi"))


def test_bytes_of_a_state_that_are_damaged_or_of_another_controller_are_refused():
    controller, other = adaptive(), made("pi")
    steps_in_python(controller, inputs(controller, 50))
    content, kept = state_to_bytes(controller), controller.state_to_json()
    fresh = adaptive()
    state_from_bytes(fresh, content)
    assert fresh.state_to_json() == kept
    damaged = bytearray(content)
    damaged[HEADER.size + 3] ^= 1
    other_hash = bytearray(content)
    other_hash[HEADER.size - 1] ^= 1
    for wrong, message in (
        (bytes(damaged), "damaged"),
        (bytes(other_hash), "of another controller"),
        (b"XXXX" + content[4:], "no saved state"),
        (content[:-1], "bytes is not allowed"),
        (b"", "bytes is not allowed"),
        (state_to_bytes(other), "bytes is not allowed"),
    ):
        with pytest.raises(InputError, match=message):
            state_from_bytes(controller, wrong)
    assert controller.state_to_json() == kept


def test_a_state_of_another_joint_is_refused():
    """All axes of a machine have states of one layout; the friction of one would throw another."""

    def axis(inertia=20.0, period=0.01, stribeck_velocity=0.05, **further):
        gains = PI.design(inertia=inertia, period=period, bandwidth=10.0)
        made_for = {"inertia": inertia, "stribeck_velocity": stribeck_velocity, **further}
        return AdaptiveController(gains.proportional, gains.integral, period, **made_for)

    runner = run_in_c(axis())
    content = state_to_bytes(runner.in_python())
    for other in (axis(inertia=0.02), axis(period=0.005), axis(stribeck_velocity=0.5), axis(delay=1.0)):
        with pytest.raises(InputError, match=r"of another controller|bytes is not allowed"):
            state_from_bytes(other, content)
        foreign = state_to_bytes(other)
        assert runner._library.controller_load_state(runner._handle, foreign, len(foreign)) != 0
    limited = axis(torque_limit=400.0)
    state_from_bytes(limited, content)
    again = state_to_bytes(limited)
    assert runner._library.controller_load_state(runner._handle, again, len(again)) == 0


PERIOD = 5e-5


def learnt(controller, seconds=1.0, seed=1):
    """Estimates after a run with a joint of 20 kg m^2 that slides."""
    draws = 0.002 * np.random.default_rng(seed).standard_normal(round(seconds / PERIOD))
    time = PERIOD * np.arange(draws.size + 1)
    plan = (0.15 * np.sin(2.0 * time) + 0.09 * np.sin(4.6 * time + 1.0) + 0.06 * np.sin(0.74 * time + 2.0)).tolist()
    velocity, torque = 0.0, 0.0
    for k, draw in enumerate(draws.tolist()):
        torque = controller.step(plan[k], velocity + draw, next_reference=plan[k + 1], realised_torque=torque)
        direction = math.copysign(1.0, velocity if velocity != 0.0 else torque)
        friction = 60.0 + 20.0 * math.exp(-abs(velocity) / 0.05) + 100.0 * abs(velocity)
        if velocity != 0.0 or abs(torque) > friction:
            velocity += PERIOD / 20.0 * (torque - direction * friction)
            velocity = 0.0 if velocity * direction < 0.0 else velocity
    return controller.estimates


def test_what_is_learnt_at_20_khz_is_what_double_precision_learns():
    gains = PI.design(inertia=20.0, period=PERIOD, bandwidth=50.0)
    controller = AdaptiveController(gains.proportional, gains.integral, PERIOD, inertia=20.0, stribeck_velocity=0.05)
    single, double = learnt(run_in_c(controller, single=True)), learnt(run_in_c(controller))
    assert single["stribeck_velocity"] == pytest.approx(double["stribeck_velocity"], rel=0.05)
    assert single["coulomb"] == pytest.approx(double["coulomb"], rel=0.05)
    assert single["friction_lag"] == pytest.approx(double["friction_lag"], abs=1e-3)
