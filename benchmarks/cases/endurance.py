"""A week in the life of a drawn joint, in parts of ten minutes with the state handed on.

Each part is made of minutes of a drawn kind: motion, rest, constant speed, motion beyond the torque limit, lost
measurement, sensor faults. Friction and load change once in each part, and after some of them the controller is made
anew and goes on from its saved state. The first and the last part are the same undisturbed motion of the same joint.
"""

import resource
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff import load_scenario
from adaptive_ff.comparison.registry import make_adaptive
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.experiment import Record, RunSetup, build_plain_setup, empty_record
from adaptive_ff.simulation.loop import Position, run_compiled, start_position
from adaptive_ff.simulation.metrics import rms
from adaptive_ff.studies.drawn_joints import draw_scenario
from adaptive_ff.studies.study import Found
from benchmarks.suite import Case
from plant import FrictionChange, schedule

PART = 600  # length of a part, s
MINUTE = 60  # length of one kind of motion, s
SOLVER_PERIOD = 0.0025  # solver period, s; a drawn joint that this is too long for gets a shorter one

KINDS = ("motion", "motion", "rest", "constant speed", "saturation", "dropout", "sensor fault")
"""What a minute may hold; motion twice as often as the others."""

FRICTION = (0.6, 1.5)  # range of the factor on friction
LOAD = 0.15  # largest load, as a fraction of the torque limit
HURRY = 6.0  # how many times faster the motion that meets the torque limit reverses
LONGEST_LOSS = 5.0  # longest loss of the measurement, s
ABSURD = (np.inf, -np.inf, 1e306, -1e160, 1e12)  # values of a broken word on a bus, rad/s
RESTARTS = 0.2  # fraction of the parts after which the controller is made anew


def drawn_joint(draw: int) -> Scenario:
    """Return the scenario of a drawn joint with all changes that it will meet."""
    changes = [{"time": 1.0 + place, "friction_scale": scale} for place, scale in enumerate(FRICTION)]
    base = load_scenario().modified(joint={"solver_period": SOLVER_PERIOD}, change=changes)
    return draw_scenario(base, 1, draw)


class Joint:
    """A joint through the week.

    Parameters
    ----------
    scenario : Scenario
        What was drawn.
    generator : Generator
        Draws what happens.
    """

    def __init__(self, scenario: Scenario, generator: np.random.Generator) -> None:
        self.scenario, self.generator = scenario, generator
        self.limit = scenario.actuator.torque_limit or 400.0
        self.period, self.step = scenario.sampling.period, scenario.joint.solver_period
        self.samples = round(PART / self.period)
        self.time = self.step * np.arange(self.samples * round(self.period / self.step) + 1)
        self.grid = np.arange(self.samples + 1, dtype=np.int64) * round(self.period / self.step)
        self.undisturbed = scenario.modified(duration=float(PART), change=[]).reference_velocity()
        self.noise = scenario.velocity_noise * np.random.default_rng(1).standard_normal(self.samples)
        self.controller = self.new_controller()
        self.position: Position | None = None
        self.record: Record | None = None
        self.scale, self.load = 1.0, 0.0

    def new_controller(self) -> Any:
        """Return a controller that limits the torque itself: the drive of these runs gives whatever is asked."""
        return make_adaptive(self.scenario, torque_limit=self.limit)

    def restart(self) -> None:
        """Make the controller anew and let it go on from the saved state."""
        saved = self.controller.state_to_json()
        self.controller = self.new_controller()
        self.controller.state_from_json(saved)

    def calm_part(self) -> float:
        """Run the undisturbed motion; return the rms error of its second half, rad/s."""
        self.scale, self.load = 1.0, 0.0
        setup = self._setup(self.undisturbed, self.noise, [])
        record = self._run(setup)
        half = self.grid[self.samples // 2]
        return rms((setup.reference - record.velocity)[half:])

    def drawn_part(self) -> Record:
        """Run ten drawn minutes with a change of friction and load."""
        draw = self.generator
        reference, noise = self._minutes()
        # what held so far holds on until the change
        changes = [FrictionChange(time=0.0, friction_scale=self.scale, load=self.load)]
        self.scale = float(np.exp(draw.uniform(*np.log(FRICTION))))
        self.load = float(LOAD * self.limit * draw.uniform(-1.0, 1.0))
        time = round(draw.uniform(1.0, PART - 1.0) / self.period) * self.period
        changes.append(FrictionChange(time=time, friction_scale=self.scale, load=self.load))
        return self._run(self._setup(reference, noise, changes))

    def _setup(
        self, reference: NDArray[np.float64], noise: NDArray[np.float64], changes: list[FrictionChange]
    ) -> RunSetup:
        setup = build_plain_setup(self.scenario.joint, self.grid, reference, noise)
        return setup._replace(plan=schedule(changes, self.step))

    def _run(self, setup: RunSetup) -> Record:
        if self.position is None:
            self.position = start_position(setup)
            self.record = empty_record(setup, len(self.controller.estimate_names))
        # commands of the last part are not those of this one
        position = self.position._replace(sample=0, phase=0, acting=-1)
        assert self.record is not None
        state, self.position = run_compiled(
            self.controller.parameters, self.controller.state, setup, position, self.samples, self.record
        )
        self.controller.state = state
        return self.record

    def _minutes(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return reference and noise of ten drawn minutes; each begins and ends at rest."""
        draw, minutes = self.generator, PART // MINUTE
        length = (self.time.size - 1) // minutes
        local = self.time[:length]
        ramp = np.clip(np.minimum(local, MINUTE - local), 0.0, 1.0)
        window = ramp * ramp * (3.0 - 2.0 * ramp)
        reference, noise = np.zeros(self.time.size), self.noise[draw.permutation(self.samples)]
        for minute in range(minutes):
            kind = KINDS[draw.integers(len(KINDS))]
            reference[minute * length : (minute + 1) * length] = window * self._motion(kind, local)
            part = noise[minute * self.samples // minutes : (minute + 1) * self.samples // minutes]
            if kind == "dropout":
                self._spoil(part, LONGEST_LOSS, np.nan)
            elif kind == "sensor fault":
                self._spoil(part, 0.05, ABSURD[draw.integers(len(ABSURD))])
                self._spoil(part, 0.05, 50.0 * self._speed * draw.uniform(-1.0, 1.0))
                self._spoil(part, 1.0, self._speed * draw.uniform(-0.5, 0.5))
        return reference, noise

    @property
    def _speed(self) -> float:
        return float(np.max(np.abs(self.undisturbed)))

    def _motion(self, kind: str, time: NDArray[np.float64]) -> NDArray[np.float64]:
        draw = self.generator
        if kind == "rest":
            return np.zeros(time.size)
        if kind == "constant speed":
            return np.full(time.size, self._speed * draw.uniform(-1.0, 1.0))
        frequencies = np.exp(draw.uniform(np.log(0.05), np.log(1.0), 4)) * (HURRY if kind == "saturation" else 1.0)
        sines = np.sin(2.0 * np.pi * frequencies[:, None] * time + draw.uniform(0.0, 2.0 * np.pi, (4, 1)))
        motion = np.sum(sines, axis=0)
        peak = self._speed * (1.0 if kind == "saturation" else draw.uniform(0.3, 1.0))
        return motion * (peak / np.max(np.abs(motion)))

    def _spoil(self, noise: NDArray[np.float64], longest: float, value: float) -> None:
        """Add a value to the noise for a drawn time (s) at a drawn place."""
        count = 1 + int(self.generator.uniform(0.0, longest) / self.period)
        first = int(self.generator.integers(noise.size - count))
        noise[first : first + count] += value


def memory() -> float:
    """Return the largest memory that the process has had, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def run_weeks(draw: int, hours: float, controllers: list[str]) -> Found:
    """Run a drawn joint through so many hours, two parts at least.

    ``last_over_first`` is the error of the last part over that of the first, ``torque`` the largest torque over the
    limit, ``lost`` the parts in which an estimate was not finite, ``growth`` that of the memory after the first hour
    (MB).
    """
    (name,), generator = controllers, np.random.default_rng([1, draw])
    joint = Joint(drawn_joint(draw), generator)
    before, lost, largest, start = joint.calm_part(), 0, 0.0, memory()
    for part in range(1, max(2, round(3600.0 * hours / PART)) - 1):
        record = joint.drawn_part()
        largest = max(largest, float(np.max(np.abs(record.given))))
        lost += not np.all(np.isfinite(record.estimates))
        if part == 6:
            start = memory()
        if generator.uniform() < RESTARTS:
            joint.restart()
    ratio = joint.calm_part() / before
    figures = {"last_over_first": ratio, "torque": largest / joint.limit, "lost": lost, "growth": memory() - start}
    return {"": {"row": f"{hours:g} h"}, name: figures}


def weeks(count: int, hours: float, first: int = 0) -> list[Case]:
    """Return drawn joints, each for so many hours."""
    return [Case(f"joint/{draw}", draw, partial(run_weeks, draw, hours)) for draw in range(first, first + count)]
