"""What every recursive estimator has in common: the thin class around its kernel."""

import json
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from adaptive_ff.estimation.updates import Settings, run_updates, single_update
from adaptive_ff.learning.confidence import check_confidence
from controllers import check_positive, plain_state, rebuilt_state
from controllers.arrays import ArrayLike, NDArray
from controllers.saved_state import check_matrices

Array = NDArray[np.float64]


class Recursion(NamedTuple):
    """What a whole series gave.

    Attributes
    ----------
    errors : ndarray, shape (m,)
        Error of the prediction of each output, before it was taken into account; not a number where it was rejected.
    estimates : ndarray, shape (m, n)
        The estimate after each equation.
    """

    errors: Array
    estimates: Array


class RecursiveEstimator:
    """A linear regression, ``output = regressors . estimate + error``, estimated equation by equation.

    Subclasses set the parameters (an immutable named tuple registered in ``CORRECTIONS``, with a field ``settings``)
    and the function that makes the state of an estimator that has seen nothing (an ``EstimationState``).

    Parameters
    ----------
    block : NamedTuple
        Parameters of the kernel.
    period : float
        Nominal time between equations, s.
    initial_state : callable
        Makes a new state from the parameters.
    """

    takes_instruments = False

    def __init__(self, block: Any, period: float, initial_state: Callable[[Any], Any]) -> None:
        check_positive(period=period)
        self.parameters = block
        self.period = float(period)
        self._initial_state = initial_state
        self.state: Any = initial_state(block)

    def update(
        self,
        regressors: ArrayLike,
        output: float,
        *,
        instruments: ArrayLike | None = None,
        dt: float | None = None,
    ) -> float:
        """Take one equation into account.

        Parameters
        ----------
        regressors : array_like, shape (n,)
            Regressors.
        output : float
            What they are to explain.
        instruments : array_like, shape (n,), optional
            What stands for the regressors and is free of their noise; for an estimator that takes instruments.
        dt : float, optional
            Time since the last equation, s; the nominal period by default.

        Returns
        -------
        float
            Error of the prediction, before the equation was taken into account. Not a number where a number of the
            equation is not finite, or above 1e100: it is left out, counted in ``rejected``, and its time does not
            count.

        Raises
        ------
        ValueError
            A shape is wrong, ``dt`` is not positive, or instruments are missing or not wanted.
        """
        row = self._shaped("regressors", regressors, (self._size,))
        stand_in = self._instruments(row, instruments)
        duration = self.period if dt is None else float(dt)
        check_positive(dt=duration)
        error, self.state = single_update(self.parameters, self.state, row, stand_in, float(output), duration)
        return float(error)

    def run(
        self, rows: ArrayLike, outputs: ArrayLike, *, instruments: ArrayLike | None = None, dt: ArrayLike | None = None
    ) -> Recursion:
        """Take a whole series into account, as a loop of ``update`` would, compiled.

        Parameters
        ----------
        rows : array_like, shape (m, n)
            Regressors, a row for each equation.
        outputs : array_like, shape (m,)
            Outputs.
        instruments : array_like, shape (m, n), optional
            Instruments.
        dt : float or array_like, shape (m,), optional
            Times since the last equation, s; the nominal period by default.

        Returns
        -------
        Recursion
            Errors and estimates.

        Raises
        ------
        ValueError
            As for ``update``.
        """
        targets = np.ascontiguousarray(outputs, dtype=np.float64)
        if targets.ndim != 1:
            raise ValueError(f"outputs have shape {targets.shape}; it must be a series")
        matrix = self._shaped("rows", rows, (targets.size, self._size))
        stand_in = self._instruments(matrix, instruments)
        durations = np.empty(targets.size)
        durations[:] = (
            self.period if dt is None else self._shaped("dt", np.broadcast_to(dt, targets.shape), targets.shape)
        )
        if not np.all((durations > 0.0) & np.isfinite(durations)):
            raise ValueError("dt is not allowed: every one must be positive and finite")
        result = Recursion(np.empty(targets.size), np.empty(matrix.shape))
        self.state = run_updates(self.parameters, self.state, matrix, stand_in, targets, durations, *result)
        return result

    @property
    def estimate(self) -> Array:
        """The parameters, shape (n,)."""
        found: Array = self.state.recursion.estimate.copy()
        return found

    @property
    def noise(self) -> float:
        """Standard deviation of the equation errors, unit of the output, as the data show it.

        The expected one counts as much as one equation.
        """
        tally = self.state.tally
        return float(self._settings.noise * math.sqrt((1.0 + tally.squares) / (1.0 + tally.weight)))

    @property
    def covariance(self) -> Array:
        """Covariance of the estimate, shape (n, n), in the units of the parameters; symmetric.

        It speaks of errors of the equations that are independent, of one variance, and not in the regressors, and of
        parameters that do not change; until data say more, of the first estimate.
        """
        found: Array = self.noise**2 * self.state.spread
        return found

    @property
    def standard_errors(self) -> Array:
        """Standard errors of the parameters, shape (n,)."""
        errors: Array = np.sqrt(np.diag(self.covariance))
        return errors

    def interval(self, confidence: float = 0.95) -> Array:
        """Return the confidence intervals of the parameters (Student's t), shape (n, 2).

        Parameters
        ----------
        confidence : float, optional
            Probability that they are meant to have.

        Raises
        ------
        ValueError
            It does not lie between 0 and 1.
        """
        check_confidence(confidence)
        half = self.standard_errors * float(stats.t.ppf(0.5 + 0.5 * confidence, self._degrees_of_freedom()))
        return np.column_stack([self.estimate - half, self.estimate + half])

    @property
    def taken(self) -> int:
        """Number of equations that were taken into account."""
        return int(self.state.tally.taken)

    @property
    def rejected(self) -> int:
        """Number of equations that were not finite and so were left out."""
        return int(self.state.tally.rejected)

    def reset(self) -> None:
        """Return to the state of a new estimator."""
        self.state = self._initial_state(self.parameters)

    def state_to_json(self) -> str:
        """Return the state as a JSON text that restores it exactly."""
        return json.dumps({"estimator": type(self).__name__, "state": plain_state(self.state)}, indent=1)

    def state_from_json(self, text: str) -> None:
        """Restore a state saved by an estimator of the same class and size.

        Raises
        ------
        ValueError
            The text is no such state; the estimator keeps the one it has.
        """
        try:
            saved = json.loads(text)
            name, content = saved["estimator"], saved["state"]
        except (json.JSONDecodeError, KeyError, TypeError, RecursionError) as error:
            raise ValueError(f"text = {str(text)[:40]!r} is no saved estimator state: {error}") from error
        if name != type(self).__name__:
            raise ValueError(f"estimator = {name!r} is not allowed: this is a {type(self).__name__!r}")
        state = rebuilt_state(self._initial_state(self.parameters), content, "state")
        check_matrices(state, "state")
        self.state = state

    @property
    def _settings(self) -> Settings:
        settings: Settings = self.parameters.settings
        return settings

    @property
    def _size(self) -> int:
        return int(self._settings.first.size)

    def _degrees_of_freedom(self) -> float:
        """Equations that the weights amount to, and one for the expected level of the error."""
        tally = self.state.tally
        return float((1.0 + tally.weight) ** 2 / (1.0 + tally.weight_squared))

    def _instruments(self, regressors: Array, instruments: ArrayLike | None) -> Array:
        if instruments is None and self.takes_instruments:
            raise ValueError("instruments are missing; they must be given, one for each regressor")
        if instruments is None:
            return regressors
        if not self.takes_instruments:
            raise ValueError(f"instruments are not allowed: {type(self).__name__} takes none")
        return self._shaped("instruments", instruments, regressors.shape)

    @staticmethod
    def _shaped(name: str, given: ArrayLike, shape: tuple[int, ...]) -> Array:
        array = np.ascontiguousarray(given, dtype=np.float64)
        if array.shape != shape:
            raise ValueError(f"{name} has shape {array.shape}; it must be {shape}")
        return array


def make_settings(first: ArrayLike, first_deviation: ArrayLike, noise: float, memory: float) -> Settings:
    """Return the settings of an estimator, or raise ``ValueError`` where a value is out of range.

    Parameters
    ----------
    first : array_like, shape (n,)
        First estimate.
    first_deviation : float or array_like, shape (n,)
        How far, as a standard deviation, each parameter may be from it.
    noise : float
        Expected standard deviation of an equation's error, unit of the output.
    memory : float
        Memory, s; infinite where nothing is forgotten.
    """
    start = np.array(first, dtype=np.float64)
    if start.ndim != 1 or start.size == 0:
        raise ValueError(f"first has shape {start.shape}; it must be (parameters,), one at least")
    if not np.all(np.isfinite(start)):
        raise ValueError(f"first = {start.tolist()} is not allowed: every one must be finite")
    check_positive(noise=noise)
    if not memory > 0.0:
        raise ValueError(f"memory = {memory} is not allowed: it must be a positive number of seconds")
    deviation = check_deviations("first_deviation", first_deviation, start.size)
    return Settings(start, deviation, float(noise), float(memory))


def check_deviations(name: str, given: ArrayLike, size: int, *, zero: bool = False) -> Array:
    """Return standard deviations, one for each parameter, or raise ``ValueError`` where one is out of range."""
    try:
        deviations = np.array(np.broadcast_to(np.asarray(given, dtype=np.float64), (size,)))
    except ValueError as error:
        raise ValueError(f"{name} has shape {np.shape(given)}; it must be one number, or {(size,)}") from error
    if not np.all(np.isfinite(deviations) & ((deviations > 0.0) | (zero & (deviations == 0.0)))):
        rule = "not negative" if zero else "positive"
        raise ValueError(f"{name} = {deviations.tolist()} is not allowed: every one must be {rule} and finite")
    return deviations
