"""Sensors, drives, and joints that change."""

import math

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import solve_ivp
from scipy.special import lambertw
from stepped_joint import leaves

import plant
from plant import Actuator, FrictionChange, FrictionVariation, JointModel, Sensor, friction_factor, heated, schedule
from plant.actuator import realise_torque, ripple_torque
from plant.schedule import check_factor
from plant.sensor import encoder_reading, measured_angle, measured_speed

FRICTION = {"inertia": 20.0, "coulomb": 60.0, "stiction": 90.0, "viscous": 80.0, "stribeck_velocity": 0.05}
CHANGE = plant.JointChange(dry=1.5, viscous=0.5, inertia=2.0, lag=0.25, load=30.0)


WARMED = {"thermal_resistance": 1.0, "thinning": 0.1}
VARYING = [{"load_share": 1e-300}, {"warm_up_excess": -0.5}, {"position_amplitude": 0.5}, WARMED]


@pytest.mark.parametrize("fields", [{}, *({one: value} for one, value in WARMED.items()), *VARYING])
def test_friction_varies_within_a_phase_where_something_makes_it(fields):
    assert schedule([], 0.01, FrictionVariation(**fields)).varies == (fields in VARYING)


def test_every_kind_can_be_changed():
    assert plant.CHANGE_JOINT.keys() == plant.SCALE_JOINT.keys() == plant.STEP_JOINT.keys()


LINK = {"link_stiffness": 5e4, "inertia": 25.0}  # 15 + 5 kg m^2 become 15 + 10
LAG, SHORTER = {"friction_lag": 0.02}, {"friction_lag": 0.005}
ELEMENTS = {"displacements": [2e-4, 5e-4, 1e-3, 2e-3]}


@pytest.mark.parametrize(
    ("kind", "before", "after"),
    [
        (plant.JointModel, LAG, SHORTER),
        (plant.LuGreJoint, {"stiffness": 1e5, "damping": 500.0}, {"stiffness": 1.5e5, "damping": 750.0}),
        (plant.ElasticJoint, LAG | {"link_share": 0.25}, SHORTER | {"link_share": 0.4} | LINK),
        (plant.BacklashJoint, {"gap": 0.002, "link_share": 0.25}, {"gap": 0.002, "link_share": 0.4} | LINK),
        (plant.MaxwellJoint, {"attraction": 2e3} | ELEMENTS, {"attraction": 12e3} | ELEMENTS),
        (plant.ElastoPlasticJoint, {"presliding": 1e-3} | LAG, {"presliding": 1e-3} | SHORTER),
    ],
)
def test_changed_joint_is_the_joint_made_with_the_changed_fields(kind, before, after):
    """What bends before it slides goes with the dry friction."""
    stiff = {"link_stiffness": 5e4} if "link_share" in before else {}
    parameters = kind(**FRICTION, offset=7.0, **stiff, **before).parameters
    fields = {"coulomb": 90.0, "stiction": 135.0, "viscous": 40.0, "inertia": 40.0, "offset": 37.0, **after}
    expected = kind(**{**FRICTION, **fields}).parameters
    changed = plant.CHANGE_JOINT[type(parameters)](parameters, CHANGE)
    assert np.hstack(leaves(changed)) == pytest.approx(np.hstack(leaves(expected)), rel=1e-14)


@pytest.mark.parametrize(("phase", "share"), [(0.0, 1.0), (0.7, 0.5)])
def test_weight_without_friction_swings_as_a_pendulum(phase, share):
    free = {"inertia": 20.0, "coulomb": 0.0, "stiction": 0.0, "viscous": 0.0, "stribeck_velocity": 0.05}
    errors = []
    for period in (1e-3, 5e-4):
        joint = plant.Joint(plant.JointModel(**free, gravity=100.0, gravity_phase=phase, solver_period=period), share)
        velocity = [joint.step(0.0, 0.01) for _ in range(300)]
        options = {"t_eval": 0.01 * np.arange(1, 301), "rtol": 1e-10, "atol": 1e-12}
        exact = solve_ivp(lambda _, y: [y[1], -5.0 * math.sin(y[0] + phase)], (0.0, 3.0), [0.0, share], **options)
        errors.append(np.max(np.abs(velocity - exact.y[1])))
    assert errors[0] < 5e-3
    assert errors[1] == pytest.approx(0.5 * errors[0], rel=0.1)  # first order


def test_lagged_torque_is_the_exact_response_of_a_first_order_lag():
    drive = plant.Actuator(lag=0.004).parameters
    mean, end = plant.lagged_torque(drive, 50.0, -10.0, 0.001)
    time = np.linspace(0.0, 0.001, 100_001)
    setup = 50.0 - 60.0 * np.exp(-time / 0.004)
    assert end == pytest.approx(setup[-1], rel=1e-12)
    assert mean == pytest.approx(np.trapezoid(setup, time) / 0.001, rel=1e-9)
    assert plant.lagged_torque(plant.Actuator().parameters, 50.0, -10.0, 0.001) == (50.0, 50.0)


def changes(*pairs):
    return [FrictionChange(time=time, friction_scale=scale) for time, scale in pairs]


HEATING = FrictionVariation(thermal_resistance=2.0, thermal_time=40.0, thinning=0.03)
WATTS = 30.0
"""Power of the cold joint's friction at a constant speed."""


def warmth_after(seconds, period):
    plan, warmth = schedule([], period, HEATING), 0.0
    for _ in range(round(seconds / period)):
        warmth = heated(plan, warmth, WATTS * friction_factor(plan, 0, 0.0, 0.0, 0.0, warmth), period)
    return warmth


def test_joint_at_constant_speed_settles_at_the_temperature_of_lamberts_function():
    """``theta = R P exp(-beta theta)``: the less friction there is, the less it heats."""
    settled = lambertw(0.03 * 2.0 * WATTS).real / 0.03
    assert warmth_after(1200.0, 0.5) == pytest.approx(settled, rel=1e-9)


def test_heating_solves_its_differential_equation_with_an_error_of_first_order():
    def slope(t, y):
        return [(2.0 * WATTS * math.exp(-0.03 * y[0]) - y[0]) / 40.0]

    exact = solve_ivp(slope, (0.0, 30.0), [0.0], rtol=1e-12, atol=1e-12).y[0, -1]
    coarse, fine = (abs(warmth_after(30.0, period) - exact) for period in (0.1, 0.05))
    assert fine < 1e-3 * exact
    assert coarse / fine == pytest.approx(2.0, abs=0.05)


STARTS = [(0.0, 0.001, 0), (30.0, 0.001, 30_000), (3600.0, 0.0001, 36_000_000)]
STARTS += [(0.3, 0.1, 3), (0.07, 0.01, 7)]  # 0.3/0.1 is 2.9999999999999996, and 0.07/0.01 is 7.000000000000001
STARTS += [(0.0011, 0.001, 2), (0.0019, 0.001, 2)]  # between two solver steps: the later of them


@pytest.mark.parametrize(("time", "period", "start"), STARTS)
def test_change_takes_effect_at_the_first_solver_step_not_before_its_time(time, period, start):
    assert schedule(changes((time, 0.5)), period).starts.tolist() == [0, start]


def test_changes_are_refused_for_the_most_friction_that_they_come_to():
    """Twice, half as much more when cold, 0.3 more at a place, and 1 % more for each of 30 N m."""
    joint = JointModel(inertia=20.0, coulomb=60.0, stiction=90.0, viscous=80.0, stribeck_velocity=0.05).parameters
    varying = FrictionVariation(warm_up_excess=0.5, position_amplitude=0.3, load_share=0.01)
    plan = schedule([FrictionChange(time=1.0, friction_scale=2.0, load=-10.0)], 0.01, varying)
    longest = 20.0 / 520.0 / (2.0 * 1.5 * 1.3 * 1.3)  # as of test_joint.py, over the factor
    check_factor(joint, plan, 0.999 * longest, 20.0)
    with pytest.raises(ValueError, match=r"^friction up to 5.07 times the joint's is"):
        check_factor(joint, plan, 1.001 * longest, 20.0)
    check_factor(joint, plan._replace(warm_up_excess=-0.5), 1.49 * longest, 20.0)  # less when cold is no more when warm


def test_noise_is_white_and_gaussian_with_the_stated_deviation():
    samples = 100_000
    noise = Sensor(velocity_noise=0.002).draw(samples, np.random.default_rng(1))
    assert noise.shape == (samples,)
    assert stats.kstest(noise / 0.002, "norm").pvalue > 0.01
    correlations = [np.corrcoef(noise[lag:], noise[:-lag])[0, 1] for lag in (1, 2, 10)]
    assert np.max(np.abs(correlations)) < 4.0 / math.sqrt(samples)


def test_seed_reproduces_the_noise_and_another_seed_does_not():
    sensor = Sensor(velocity_noise=0.002)
    first = sensor.draw(100, np.random.default_rng(7))
    assert np.array_equal(first, sensor.draw(100, np.random.default_rng(7)))
    assert not np.any(first == sensor.draw(100, np.random.default_rng(8)))


def test_noise_free_sensor_uses_up_as_much_randomness_as_a_noisy_one():
    quiet, loud = np.random.default_rng(7), np.random.default_rng(7)
    assert np.all(Sensor().draw(100, quiet) == 0.0)
    Sensor(velocity_noise=0.002).draw(100, loud)
    assert quiet.random() == loud.random()


def test_faults_of_a_sensor_come_as_often_as_stated_and_leave_the_noise_as_it_is():
    samples, plain = 100_000, Sensor(velocity_noise=0.002)
    noise = plain.draw(samples, np.random.default_rng(1))
    leaping = Sensor(velocity_noise=0.002, leap=3.0, leap_share=0.01).draw(samples, np.random.default_rng(1)) - noise
    assert np.unique(np.abs(np.round(leaping, 9))).tolist() == [0.0, 3.0]
    assert np.count_nonzero(leaping) == pytest.approx(0.01 * samples, rel=0.1)
    assert abs(np.mean(np.sign(leaping[leaping != 0.0]))) < 0.1
    sensor, generator = Sensor(velocity_noise=0.002, held=5, held_share=0.01), np.random.default_rng(1)
    assert np.array_equal(sensor.draw(samples, generator), noise)
    held = sensor.draw_held(samples, generator)
    assert not np.any(plain.draw_held(samples, generator))
    assert np.mean(held) == pytest.approx(1.0 - 0.99**5, rel=0.1)
    runs = np.diff(np.flatnonzero(np.diff(np.concatenate([[0], held.astype(int), [0]]))))[::2]
    assert np.min(runs[:-1]) == 5
    assert Sensor().is_random is False
    assert all(sensor.is_random for sensor in (plain, Sensor(held=2, held_share=0.1), Sensor(leap=1.0, leap_share=0.1)))


@pytest.mark.parametrize(
    ("fields", "commands", "given"),
    [
        ({}, (1e9, -1e9), (1e9, -1e9)),
        ({"torque_limit": 50.0}, (70.0, 50.0, 7.0, -70.0), (50.0, 50.0, 7.0, -50.0)),
        ({"torque_resolution": 0.5}, (7.3, 7.2, -7.2, 1e9), (7.5, 7.0, -7.0, 1e9)),
        ({"torque_resolution": 3.0, "torque_limit": 50.0}, (70.0, -70.0, 4.0), (48.0, -48.0, 3.0)),
        ({"torque_resolution": 50.0, "torque_limit": 50.0}, (30.0, 20.0), (50.0, 0.0)),
        ({"rate_limit": 200.0}, (70.0, 11.0, -70.0), (12.0, 11.0, 8.0)),  # within 10 ms of 10 N m
        ({"rate_limit": 200.0, "torque_limit": 11.5, "torque_resolution": 1.0}, (70.0, 8.6), (11.0, 9.0)),
    ],
)
def test_drive_gives_what_slope_limit_and_resolution_leave_of_a_command(fields, commands, given):
    drive = Actuator(**fields).parameters
    assert tuple(realise_torque(drive, command, 10.0, 0.01) for command in commands) == given


def test_ripple_and_measured_angle_are_sines():
    drive = Actuator(ripple_amplitude=2.0, ripple_period=0.1).parameters
    assert [ripple_torque(drive, angle) for angle in (0.0, 0.025, -0.025)] == pytest.approx([0.0, 2.0, -2.0])
    ripple, plain = Sensor(ripple_amplitude=0.01, ripple_period=0.5).angle_ripple, Sensor().angle_ripple
    assert measured_angle(ripple, 0.625) == pytest.approx(0.635)
    slope = (measured_angle(ripple, 0.3 + 1e-6) - measured_angle(ripple, 0.3 - 1e-6)) / 2e-6
    assert measured_speed(ripple, 0.3, 1.5) == pytest.approx(1.5 * slope, rel=1e-6)
    assert (measured_angle(plain, 0.3), measured_speed(plain, 0.3, 1.5)) == (0.3, 1.5)
    assert [encoder_reading(0.2, angle) for angle in (0.31, -0.31)] == pytest.approx([0.4, -0.4])
