"""A week in the life of a drawn joint, in parts of ten minutes, from rest to rest, with the controller's state kept.

Each part is made of minutes of a drawn kind: motion, rest, constant speed, motion beyond the torque limit, lost
measurement, sensor faults. Friction and load change once in each part, and after some of them the controller is made
anew and goes on from its saved state. The first and the last part are the same undisturbed motion of the same joint.
"""

import resource
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff import Run, Scenario, load_scenario, simulate
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.simulation.experiment import build_plain_setup
from adaptive_ff.simulation.metrics import rms
from adaptive_ff.studies.study import Found
from adaptive_ff.studies.sweep import draw_scenario
from benchmarks.suite import seeded
from plant import FrictionChange, schedule

Array = NDArray[np.float64]

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
    """Return the scenario of a drawn joint that keeps its solution under all changes that it will meet."""
    changes = [{"time": 1.0 + place, "friction_scale": scale} for place, scale in enumerate(FRICTION)]
    base = load_scenario().modified(joint={"solver_period": SOLVER_PERIOD}, change=changes)
    return draw_scenario(base, 1, draw).modified(duration=float(PART), change=[])


class Life:
    """A joint through the week: its controller, which limits the torque itself, and how friction and load are.

    The scenario is the undisturbed motion of the joint; the generator draws what happens.
    """

    def __init__(self, scenario: Scenario, generator: np.random.Generator) -> None:
        self.scenario, self.draw = scenario, generator
        self.limit = scenario.actuator.torque_limit or 400.0
        self.controller = self._made()
        self.undisturbed = scenario.reference_velocity()
        self.speed = float(np.max(np.abs(self.undisturbed)))
        samples = scenario.sample_steps.size - 1
        self.noise = scenario.velocity_noise * np.random.default_rng(1).standard_normal(samples)
        self.now = FrictionChange(time=0.0, friction_scale=1.0)

    def _made(self) -> Any:
        return CONTROLLERS["adaptive"](self.scenario, torque_limit=self.limit)

    def restart(self) -> None:
        """Make the controller anew and let it go on from the saved state."""
        saved = self.controller.state_to_json()
        self.controller = self._made()
        self.controller.state_from_json(saved)

    def run(self, reference: Array, noise: Array, changes: list[FrictionChange]) -> Run:
        """Run a part with a drive that gives whatever is asked."""
        setup = build_plain_setup(self.scenario.joint, self.scenario.sample_steps, reference, noise)
        setup = setup._replace(plan=schedule(changes, self.scenario.joint.solver_period))
        return simulate(self.scenario, self.controller, setup=setup, uncertain=False)

    def calm_part(self) -> float:
        """Run the undisturbed motion; return the rms error of its second half, rad/s."""
        run = self.run(self.undisturbed, self.noise, [])
        return rms((run.reference - run.velocity)[run.reference.size // 2 :])

    def drawn_part(self) -> Run:
        """Run ten drawn minutes with a change of friction and load; what held so far holds on until then."""
        reference, noise = self._minutes()
        period = self.scenario.sampling.period
        scale = float(np.exp(self.draw.uniform(*np.log(FRICTION))))
        load = float(LOAD * self.limit * self.draw.uniform(-1.0, 1.0))
        time = round(self.draw.uniform(1.0, PART - 1.0) / period) * period
        before = self.now.model_copy(update={"time": 0.0})
        self.now = FrictionChange(time=time, friction_scale=scale, load=load)
        return self.run(reference, noise, [before, self.now])

    def _minutes(self) -> tuple[Array, Array]:
        """Return reference and noise of ten drawn minutes; each begins and ends at rest."""
        draw, minutes = self.draw, PART // MINUTE
        length, samples = (self.undisturbed.size - 1) // minutes, self.noise.size // minutes
        time = self.scenario.joint.solver_period * np.arange(length)
        ramp = np.clip(np.minimum(time, MINUTE - time), 0.0, 1.0)
        window = ramp * ramp * (3.0 - 2.0 * ramp)
        reference, noise = np.zeros(self.undisturbed.size), self.noise[draw.permutation(self.noise.size)]
        for minute in range(minutes):
            kind = KINDS[draw.integers(len(KINDS))]
            reference[minute * length : (minute + 1) * length] = window * self._motion(kind, time)
            part = noise[minute * samples : (minute + 1) * samples]
            if kind == "dropout":
                self._spoil(part, LONGEST_LOSS, np.nan)
            elif kind == "sensor fault":
                self._spoil(part, 0.05, ABSURD[draw.integers(len(ABSURD))])
                self._spoil(part, 0.05, 50.0 * self.speed * draw.uniform(-1.0, 1.0))
                self._spoil(part, 1.0, self.speed * draw.uniform(-0.5, 0.5))
        return reference, noise

    def _motion(self, kind: str, time: Array) -> Array:
        draw = self.draw
        if kind == "rest":
            return np.zeros(time.size)
        if kind == "constant speed":
            return np.full(time.size, self.speed * draw.uniform(-1.0, 1.0))
        frequencies = np.exp(draw.uniform(np.log(0.05), np.log(1.0), 4)) * (HURRY if kind == "saturation" else 1.0)
        sines = np.sin(2.0 * np.pi * frequencies[:, None] * time + draw.uniform(0.0, 2.0 * np.pi, (4, 1)))
        motion = np.sum(sines, axis=0)
        peak = self.speed * (1.0 if kind == "saturation" else draw.uniform(0.3, 1.0))
        return motion * (peak / np.max(np.abs(motion)))

    def _spoil(self, noise: Array, longest: float, value: float) -> None:
        """Add a value to the noise for a drawn time (s) at a drawn place."""
        count = 1 + int(self.draw.uniform(0.0, longest) / self.scenario.sampling.period)
        first = int(self.draw.integers(noise.size - count))
        noise[first : first + count] += value


def memory() -> float:
    """Return the largest memory that the process has had, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def run_weeks(hours: float, draw: int, controllers: list[str]) -> Found:
    """Run a drawn joint through so many hours, two parts at least.

    ``last_over_first`` is the error of the last part over that of the first, ``torque`` the largest torque over the
    limit, ``lost`` the parts in which an estimate was not finite, ``growth`` that of the memory after the first hour
    (MB).
    """
    (name,), generator = controllers, np.random.default_rng([1, draw])
    life = Life(drawn_joint(draw), generator)
    before, lost, largest, start = life.calm_part(), 0, 0.0, memory()
    for part in range(1, max(2, round(3600.0 * hours / PART)) - 1):
        run = life.drawn_part()
        largest = max(largest, float(np.max(np.abs(run.torque))))
        lost += not all(np.all(np.isfinite(series)) for series in run.estimates.values())
        if part == 6:
            start = memory()
        if generator.uniform() < RESTARTS:
            life.restart()
    ratio = life.calm_part() / before
    figures = {"last_over_first": ratio, "torque": largest / life.limit, "lost": lost, "growth": memory() - start}
    return {"": {"row": f"{hours:g} h"}, name: figures}


weeks = seeded(run_weeks, lambda hours: {"joint": (hours,)}, first=0)
