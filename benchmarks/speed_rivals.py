"""The closed loop, ours and its rivals', ready to be timed: compiled here, in C, and in python-control.

A rival runs on the course of one of our loops: same joint, reference, noise and controller. Its series must agree with
ours, see :func:`check_alike`, or timing it would mean nothing.
"""

import ctypes
import shutil
import subprocess
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff import Scenario, export_controller
from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.simulation.experiment import NO_POSITION_LOOP, Course, empty_record, lay_course
from adaptive_ff.simulation.loop import run_controller, start_position
from controllers import Controller, PIParameters
from plant import JointParameters, JointState, realise_torque, sliding, step_joint

SOURCE = Path(__file__).with_name("closed_loop.c")
COMPILE = ("-O2", "-std=c99", "-ffp-contract=off", "-shared", "-fPIC")  # no fused products: they round differently

CLOCK = time.thread_time if time.get_clock_info("thread_time").resolution < 1e-6 else time.perf_counter
"""Processor time of this thread, which other work on the machine disturbs less, where it is fine enough."""

LARGEST_DIFFERENCE = 1e-9
"""Largest difference between a rival's series and ours, relative to the largest value of the series."""


class OwnLoop:
    """Our closed loop, ready to run again and again into the same record.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    name : str
        Name of the controller.
    """

    def __init__(self, scenario: Scenario, name: str) -> None:
        self.scenario = scenario
        self.controller = make_controller(scenario, name)
        self.course = lay_course(scenario)
        self.start = start_position(self.course)
        names, watched = self.controller.estimate_names, self.controller.monitor_names
        self.record = empty_record(self.course, len(names), len(watched))

    def run(self) -> float:
        """Run and return the time that it took, s."""
        self.controller.reset()
        begin = CLOCK()
        run_controller(self.controller, self.course, self.start, self.course.noise.size, self.record)
        return CLOCK() - begin


Numbers = ctypes.c_double * 22
Counts = ctypes.c_int64 * 3
Pointers = ctypes.c_void_p * 12
FILLED = ("velocity", "position", "friction", "measured", "torque", "feedforward", "estimates")
"""Series that the C loop fills in."""

EXPORTED = "exported"
"""Prefix of the exported controller."""


class CRun(ctypes.Structure):
    """``struct run`` of the C source: its fields by type, in its order."""

    _fields_ = (("numbers", Numbers), ("counts", Counts), ("pointers", Pointers))


def compiler() -> str | None:
    """Return the local C compiler, or None."""
    return next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))), None)


def compile_loop(folder: Path, controller: Controller | None = None) -> ctypes.CDLL:
    """Compile the C loop, with the constants of the Python sources, and load it.

    Parameters
    ----------
    folder : Path
        Where the library is written.
    controller : Controller, optional
        A controller with estimates; exported to C, it takes the place of the loop's own. By default the library holds
        PI loop and feedforward from fixed parameters, written by hand.

    Raises
    ------
    OSError, subprocess.CalledProcessError
        There is no compiler, or it fails.
    """
    program = compiler()
    if program is None:
        raise OSError("there is no C compiler: none of cc, gcc, clang is found")
    constants = {
        "MAXIMUM_ITERATIONS": sliding.MAXIMUM_ITERATIONS,
        "RELATIVE_TOLERANCE": sliding.RELATIVE_TOLERANCE,
        "UPDATES": sliding.UPDATES,
        "LONGEST_UPDATE": sliding.LONGEST_UPDATE,
        "ERROR_LEFT": sliding.ERROR_LEFT,
    }
    library = folder / "closed_loop.so"
    defined = [f"-D{name}={value!r}" for name, value in constants.items()]
    sources = [str(SOURCE)]
    if controller is not None:
        export_controller(controller, folder, prefix=EXPORTED)
        defined += [f"-D{EXPORTED.upper()}", f"-I{folder}"]
        sources.append(str(folder / f"{EXPORTED}.c"))
    subprocess.run([program, *COMPILE, *defined, "-o", str(library), *sources, "-lm"], check=True)
    return ctypes.CDLL(str(library))


class CLoop:
    """The C loop on the course of one of ours, with the same controller.

    Parameters
    ----------
    library : ctypes.CDLL
        The compiled loop.
    own : OwnLoop
        Our loop; its controller is ``pi`` or one with a feedforward from fixed parameters, such as ``fixed``.

    Raises
    ------
    ValueError
        The course or the controller is none that the C loop serves.
    """

    def __init__(self, library: ctypes.CDLL, own: OwnLoop) -> None:
        self.library = library
        course, plan = own.course, own.course.plan
        check_served(course)
        numbers = [*course.joint.friction, course.joint.inertia, course.joint.friction_lag]
        numbers += [own.start.joint.velocity, own.start.joint.friction_torque]
        numbers += [course.solver_period, course.actuator.torque_limit, course.position_step]
        settings = self.settings(own.controller.parameters)
        numbers += settings
        counts = (len(settings) > 2, course.noise.size, plan.starts.size)
        record = empty_record(course, own.record.estimates.shape[1])
        self.record = record._replace(given=record.torque)  # without delay they are one
        given = (plan.starts, plan.scales, course.samples, course.reference, course.noise)
        filled = [getattr(self.record, name) for name in FILLED]
        self.arrays = (*map(np.ascontiguousarray, given), *filled)  # alive as long as the pointers to them
        pointers = [array.ctypes.data for array in self.arrays]
        self.arguments = CRun(Numbers(*numbers), Counts(*counts), Pointers(*pointers))

    def settings(self, block: Any) -> list[float]:
        """Return what the controller written by hand is given: gains, and model and period where it has a model."""
        feeds = isinstance(block, ModelBased.Parameters)
        if not feeds and not isinstance(block, PIParameters):
            raise ValueError(f"the C loop serves pi and feedforward from fixed parameters, not {type(block).__name__}")
        gains = list((block.feedback if feeds else block)[:2])
        if not feeds:
            return gains
        model = block.model
        if block.schedule.size or any(model[7:]) or block.gravity[0]:
            raise ValueError("the C loop serves a model that is symmetric, without gravity, and does not change")
        numbers = [model.coulomb, model.stiction, model.viscous, model.stribeck_velocity, model.stribeck_shape]
        return [*gains, *numbers, model.inertia, model.friction_lag, block.period]

    def run(self) -> float:
        """Run and return the time that it took, s."""
        begin = CLOCK()
        self.library.run_loop(ctypes.byref(self.arguments))
        return CLOCK() - begin


class ExportedLoop(CLoop):
    """The C loop with the controller of ours exported to C.

    Parameters
    ----------
    folder : Path
        Where the controller's source and the library are written.
    own : OwnLoop
        Our loop; its controller is any that has estimates and can be exported.
    """

    def __init__(self, folder: Path, own: OwnLoop) -> None:
        own.controller.reset()
        super().__init__(compile_loop(folder, own.controller), own)

    def settings(self, block: Any) -> list[float]:
        """Return unused gains: the exported controller has its settings as constants."""
        return [0.0, 0.0]


def check_served(course: Course) -> None:
    """Raise ``ValueError`` for a course with something that the C loop leaves out."""
    joint, actuator = course.joint, course.actuator
    if not isinstance(joint, JointParameters) or joint.backward != joint.friction or joint.offset != 0.0:
        raise ValueError("the C loop serves rigid joints with the same friction in both directions and no offset")
    special = {
        "a computation delay": course.delay > 0,
        "an encoder": course.resolution > 0.0,
        "gravity": course.gravity.amplitude > 0.0,
        "a position loop": course.outer != NO_POSITION_LOOP,
        "friction that varies": course.plan.varies,
        "a drive with lag, ripple or another gain": actuator.lag > 0.0
        or actuator.ripple_amplitude > 0.0
        or actuator.gain != 1.0,
    }
    for name, present in special.items():
        if present:
            raise ValueError(f"the C loop does not serve {name}")


class PythonControlLoop:
    """The PI loop as one discrete-time system of python-control, whose update holds the sub-steps of the joint.

    Parameters
    ----------
    own : OwnLoop
        Our loop; its controller is ``pi``.
    """

    def __init__(self, own: OwnLoop) -> None:
        import control

        if own.course.plan.starts.size > 1:
            raise ValueError("this loop serves joints whose friction does not change")
        course, period, substeps = own.course, own.scenario.sampling.period, own.scenario.substeps
        proportional, integral_gain = own.controller.parameters[:2]
        joint = course.joint
        unwinding = min(1.0, period * integral_gain / proportional)

        def update(t: float, x: NDArray[np.float64], u: NDArray[np.float64], params: dict[str, Any]) -> list[float]:
            velocity, friction_torque, position, integral, excess = x.tolist()  # plain floats: twice as fast as numpy's
            reference, noise = u.tolist()
            error = reference - (velocity + noise)
            integral += unwinding * excess + integral_gain * period * error
            command = proportional * error + integral
            torque = realise_torque(course.actuator, command, 0.0, period)
            state = JointState(velocity, friction_torque, position)
            for _ in range(substeps):
                state = step_joint(joint, state, torque, course.solver_period)
            return [*state, integral, torque - command]

        def output(t: float, x: NDArray[np.float64], u: NDArray[np.float64], params: dict[str, Any]) -> float:
            return float(x[0])

        self.system = control.nlsys(update, output, inputs=2, outputs=1, states=5, dt=period)
        self.times = np.arange(course.noise.size) * period
        self.inputs = np.vstack([course.reference[:-1:substeps], course.noise])
        self.start = [*own.start.joint, 0.0, 0.0]
        self.respond = control.input_output_response
        self.velocity = np.empty(0)

    def run(self) -> float:
        """Run and return the time that it took, s."""
        begin = CLOCK()
        self.velocity = self.respond(self.system, self.times, self.inputs, self.start).outputs
        return CLOCK() - begin


def shared_series(loop: OwnLoop | CLoop) -> list[NDArray[np.float64]]:
    """Return the series that both loops record: all but what a controller watches itself by."""
    return [getattr(loop.record, name) for name in FILLED]


def check_alike(ours: Sequence[NDArray[np.float64]], theirs: Sequence[NDArray[np.float64]], rival: str) -> float:
    """Return the largest difference of two sets of series, relative to the largest value of each.

    Raises
    ------
    ArithmeticError
        It is too large: what is timed is not the same computation.
    """
    differences = [
        float(np.max(np.abs(a - b))) / (float(np.max(np.abs(a))) or 1.0)
        for a, b in zip(ours, theirs, strict=True)
        if a.size
    ]
    largest = max(differences)
    if not largest <= LARGEST_DIFFERENCE:
        raise ArithmeticError(f"{rival} differs from our run by {largest:.3g}, more than {LARGEST_DIFFERENCE:g}")
    return largest
