"""Closed loops for tests: a course laid by hand, and controllers run on it."""

import numpy as np

from adaptive_ff import load_scenario
from adaptive_ff.loop import Course, empty_record, run_compiled, run_plain, start_position
from adaptive_ff.simulate import lay_course
from plant import Actuator, initial_state, schedule

SCENARIO = load_scenario()


def course_along(reference, *, joint=SCENARIO.joint, substeps=1, noise=0.0, seed=0, limit=400.0):
    """Course of a joint along a reference on the solver's grid, sampled every so many solver steps."""
    samples = (len(reference) - 1) // substeps
    return Course(
        schedule(joint.parameters, [], joint.solver_period),
        Actuator(torque_limit=limit).parameters,
        joint.solver_period,
        np.arange(samples + 1, dtype=np.int64) * substeps,
        np.asarray(reference, dtype=float)[: samples * substeps + 1],
        noise * np.random.default_rng(seed).standard_normal(samples),
    )


def begin(course):
    """Position at the start of a course, the joint moving with the reference."""
    return start_position(course, initial_state(course.plan.joint, float(course.reference[0])))


def drive(controller, course, *, position=None, run=run_compiled):
    """Run a controller over a course; return the record and the position at the end."""
    record = empty_record(course, len(controller.estimate_names))
    start = begin(course) if position is None else position._replace(sample=0)
    controller.state, end = run(controller.parameters, controller.state, course, start, course.noise.size, record)
    return record, end


__all__ = ["SCENARIO", "begin", "course_along", "drive", "lay_course", "run_compiled", "run_plain"]
