"""The controllers that watch a log, and what is kept of it."""

from typing import Any

import numpy as np

from adaptive_ff.adaptive.adaptive_state import initial_adaptive_state
from adaptive_ff.adaptive.controller import UnsupervisedController
from adaptive_ff.errors import InputError
from adaptive_ff.logs.derivatives import Array
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.further_torque import FurtherTorque
from adaptive_ff.replay.judging import Judge
from adaptive_ff.replay.parts import RECORDED, Part
from adaptive_ff.replay.result import NONE, ReplaySeries
from adaptive_ff.replay.result import RECORDED as RECORDED_NAME
from adaptive_ff.replay.watching import watch
from controllers import Controller, initial_velocity_state


class Runner:
    """A controller that watches, with what makes a velocity of the measurement.

    Parameters
    ----------
    controller : Controller
        The controller; it is advanced.
    observer : NamedTuple
        What makes a velocity.

    Attributes
    ----------
    further : FurtherTorque
        Terms that are fed forward beside what the controller does.
    """

    def __init__(self, controller: Controller, observer: Any) -> None:
        self.controller, self._observer = controller, observer
        self._observed: Any = None
        self.further, self._lagged = FurtherTorque(), 0.0

    def run(self, part: Part) -> tuple[Array, Array]:
        """Run along a part of the log; return feedforward (N m) and estimates at its samples."""
        controller, seen = self.controller, part.seen
        if part.begins:
            self._restart(float(seen.measurement[0]), float(seen.reference[0]))
        feedforward = np.empty(part.time.size)
        estimates = np.empty((part.time.size, len(controller.estimate_names)))
        observer, observed = self._observer, self._observed
        _, self._observed = watch(controller.native, 0, observer, observed, seen, feedforward, estimates)
        if self.further != FurtherTorque():
            further, self._lagged = self.further.along(seen, controller.period, self._lagged)
            feedforward += further
        return feedforward, estimates

    def _restart(self, measurement: float, reference: float) -> None:
        """Begin a piece: what is known of the joint stays, filters over its motion start anew, at the reference."""
        controller = self.controller
        self._lagged = 0.0
        self._observed = initial_velocity_state(self._observer, measurement, reference)
        if isinstance(controller, UnsupervisedController):
            fresh, known = initial_adaptive_state(controller.parameters), controller.state
            timing = fresh.timing._replace(evidence=known.timing.evidence, lag=known.timing.lag)
            controller.state = fresh._replace(estimator=known.estimator, timing=timing, enabled=known.enabled)
        else:
            controller.reset()


class Tape:
    """Runs all controllers along a log, judges their feedforwards and keeps thinned series.

    Parameters
    ----------
    log : Log
        The log.
    runners : dict of Runner
        By the name of their feedforward.
    period : float
        Sample time, s.
    band : float or None
        Band in which is judged, Hz.
    """

    def __init__(self, log: Log, runners: dict[str, Runner], period: float, band: float | None) -> None:
        self._log, self._runners, self._has_recorded = log, runners, RECORDED in log.extra
        recorded = (RECORDED_NAME,) if self._has_recorded else ()
        self.judge = Judge((NONE, *recorded, *runners), log.time.size, band, period)
        self._width, count = self.judge.needed.width, self.judge.needed.low.size
        self._estimates = {
            name: np.full((count, len(runner.controller.estimate_names)), np.nan) for name, runner in runners.items()
        }

    def run(self, part: Part) -> None:
        """Run along a part of the log."""
        feedforwards = [np.zeros(part.time.size)]
        if part.recorded is not None:
            feedforwards.append(part.recorded)
        place = (part.start + np.arange(part.time.size)) // self._width
        for name, runner in self._runners.items():
            feedforward, estimates = runner.run(part)
            if not np.all(np.isfinite(feedforward)):
                raise _diverged(self._log, name, part, feedforward)
            feedforwards.append(feedforward)
            self._estimates[name][place] = estimates  # of several in a bin the last one stays
        self.judge.add(part.start, part.needed, feedforwards, part.seen.reference != 0.0, last=part.ends)

    def adaptive(self) -> dict[str, UnsupervisedController]:
        """Return the adaptive controllers in the state that they have come to."""
        controllers = {name: runner.controller for name, runner in self._runners.items()}
        return {name: found for name, found in controllers.items() if isinstance(found, UnsupervisedController)}

    def series(self) -> ReplaySeries:
        """Return the thinned series."""
        judge = self.judge
        return ReplaySeries(
            self._log.time[:: self._width].copy(),
            judge.needed.series(),
            {name: extremes.series() for name, extremes in zip(judge.names, judge.feedforwards, strict=True)},
            {name: extremes.series() for name, extremes in zip(judge.names, judge.left, strict=True)},
            {
                name: dict(zip(controller.estimate_names, self._estimates[name].T, strict=True))
                for name, controller in self.adaptive().items()
            },
        )


def _diverged(log: Log, name: str, part: Part, feedforward: Array) -> InputError:
    """Return the error of values that are finite, but absurd."""
    place = int(np.flatnonzero(~np.isfinite(feedforward))[0])
    speed, torque = (float(np.nanmax(np.abs(values))) for values in (part.seen.reference, part.needed))
    return InputError(
        f"{log.name}: the feedforward {name} does not stay finite at sample {part.start + place}, where the reference "
        f"reaches {speed:.3g} rad/s and the torque {torque:.3g} N m; such values must be taken out of the log"
    )
