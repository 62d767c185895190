"""The motion and the torque of a log in one band: what a regression compares, row by row.

Position and torque pass the same zero-phase Butterworth low-pass, so no row lags another (M. Gautier 1997). The sign of
the velocity is taken behind a filter five times as wide, since friction changes faster than the motion, and the unit
torques that follow from it are then filtered like the torque. Where the noise of the velocity makes its sign uncertain,
the expected sign takes its place (regression calibration, R. J. Carroll 2006).
"""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
import scipy
from scipy import integrate, interpolate

from adaptive_ff.errors import InputError
from controllers.arrays import NDArray
from controllers.checks import check_numbers

Array = NDArray[np.float64]


class Tuning(NamedTuple):
    """What was chosen: of the filters, of the regression, of the models that are tried, of what is refused or assumed.

    The usual speed is that which 5 % of the rows exceed.
    """

    motion_power: float = 0.99  # fraction of the velocity's power below the frequency of the motion
    times_motion: float = 6.0  # band over the frequency of the motion
    least_hertz: float = 10.0  # smallest band without noise, Hz: reversals are short however slow the motion is
    least_times_motion: float = 2.0  # smallest band over the frequency of the motion where noise narrows it
    empty: float = 1e-3  # fraction of the velocity's power from which on an octave holds some of the motion
    noise_fraction: float = 0.01  # power of the noise of the acceleration in the band, over that of the acceleration
    whole: float = 0.05  # fraction of a count that the usual step of a position in counts may be off whole ones
    sampling_fraction: float = 0.2  # largest band over the sampling frequency
    wide: float = 5.0  # corner of the filter before the sign of the velocity, over the band
    rows_in_cycle: float = 4.0  # rows of the regression in a cycle of the band
    order: int = 2  # of the Butterworth filter, run forward and backward
    edge_cycles: float = 1.0  # rows dropped at either end of a segment, in cycles of the band
    standstill: float = 0.01  # speed over the usual one below which the joint may stick; at least the velocity's noise
    standstill_fraction: float = 0.2  # weight of standstill in a row, behind the filter, from which on it is left out
    oversampling: float = 6.0  # samples kept in a cycle of the wide filter
    folds: tuple[int, int] = (8, 20)  # fewest and most folds of rows
    ridge: float = 1e-10  # added to the scaled normal equations, against exact collinearity
    most_noise: float = 0.5  # largest fraction of a column's square that is taken for noise
    lags: tuple[float, ...] = (0.02, 0.04, 0.08, 0.16, 0.3, 0.6)  # friction lags that are tried, in cycles of the band
    paths: tuple[float, ...] = (0.002, 0.008, 0.03)  # paths that are tried, over the way in a second at the usual speed
    speeds: tuple[float, ...] = (0.02, 0.04, 0.08, 0.15, 0.3)  # Stribeck velocities that are tried, over that speed
    steps: int = 2  # Gauss-Newton steps of a shape from the best tried one
    near: float = 0.2  # logarithm of the largest factor by which a step changes a number of the shape
    safety: float = 1.5  # standard error by the band over what half of it changes: half of the factor of two grids, 3
    refinement: tuple[float, float] = (1.5, 0.1)  # standard errors by which errors of folds must fall on average, ...
    weight: tuple[float, float] = (0.7, 0.03)  # ... and the fraction of the rms residual that must go; for gravity
    collinear: float = 1e-3  # fraction of a column that the others must leave for its parameter to be identifiable
    fewest_samples: int = 50  # samples of a log ...
    fewest_rows: int = 30  # ... and sliding rows of the regression, below which nothing is tried
    largest: float = 1e30  # value of a series; one over it is the smallest peak
    longest_delay: float = 1.0  # latest that a torque may act after its stamp, s; a later one is a slip of the unit
    explained: float = 0.5  # fraction of the torque's variance from which on a model of the wrong sign is one
    unexplained: float = 0.95  # fraction of the torque that a model must not leave for there to be a joint
    vague: float = 0.25  # half width of an interval over its value from which on a parameter needs care
    assumed_lag: float = 0.01  # friction lag, s, where none is found: early throws a joint, late sticks a little
    slow: float = 0.05  # Stribeck velocity where none is identified, over the usual speed
    most_variation: float = 0.9  # largest fraction by which friction varies over the position


TUNING = Tuning()


class Segment(NamedTuple):
    """Samples of a log without a gap, at even times: start and sample time, s; position, rad; torque, N m.

    The motion is the position, or the velocity (rad/s), as measured. The known torque that was taken from the drive's
    is zero where there is none.
    """

    start: float
    period: float
    motion: Array
    position: Array
    torque: Array
    known: Array


class Spectrum(NamedTuple):
    """Where the motion ends and the noise begins, Hz.

    Frequency below which nearly all power of the velocity is; up to which the noise of the acceleration is small; and
    the middle of the velocity's power. Density of the white noise of the position, rad^2/Hz, or of the velocity,
    (rad/s)^2/Hz, and which of them.
    """

    motion: float
    quiet: float
    slow: float
    density: float
    of_position: bool

    def variance(self, corners: Sequence[float], derivatives: int, period: float) -> float:
        """Return the variance of a derivative of the velocity behind :func:`lowpass` of each corner, Hz."""
        frequency = np.linspace(0.0, min(10.0 * min(corners), 0.5 / period), 1001)
        passed = np.prod([1.0 / (1.0 + (frequency / corner) ** 4) for corner in corners], axis=0)
        power = ((2.0 * np.pi * frequency) ** (derivatives + self.of_position) * passed) ** 2
        return self.density * float(integrate.trapezoid(power, frequency))


def spectrum(motion: Array, period: float, *, is_position: bool) -> Spectrum:
    """Return where motion and noise of a position or velocity are, from its periodogram; noise is taken as white."""
    velocity = np.diff(motion) / period if is_position else motion - np.mean(motion)
    window = np.hanning(velocity.size)
    power = np.abs(np.fft.rfft(velocity * window)) ** 2
    frequency: Array = np.fft.rfftfreq(velocity.size, period).astype(np.float64)
    gain = (2.0 * np.sin(np.pi * frequency * period) / period) ** 2 if is_position else np.ones_like(frequency)
    upper = frequency > 0.3 / period
    weight = float(np.sum(window**2))
    white = float(np.median(power[upper] / gain[upper])) / math.log(2.0)
    of_counts, highest = _of_counts(motion, period) if is_position else (0.0, math.inf)
    noise = max(white, of_counts * weight / (2.0 * period))
    width = max(1, min(15, power.size // 20))
    smooth = np.convolve(power, np.ones(width) / width, "same")
    measured: Array = np.where(smooth > 4.0 * noise * gain, np.maximum(power - noise * gain, 0.0), 0.0)
    if not measured.any():
        measured = power
    measured[frequency > highest] = 0.0
    measured[frequency >= _gap(frequency, measured)] = 0.0
    end, slow = (_below(frequency, measured, fraction) for fraction in (TUNING.motion_power, 0.5))
    accelerated = float(np.sum((measured * frequency**2)[frequency <= TUNING.times_motion * end]))
    loud = np.cumsum(noise * gain * frequency**2) > TUNING.noise_fraction * accelerated
    quiet = float(frequency[int(np.argmax(loud))]) if loud.any() else math.inf
    return Spectrum(end, quiet, slow, 2.0 * period * white / weight, is_position)


def _of_counts(position: Array, period: float) -> tuple[float, float]:
    """Return the density of the error of a position in counts ``q``, rad^2/Hz, and half their rate, Hz.

    The density is ``q^2/12`` up to the rate, W. R. Bennett's of 1948; where a count takes many rows, the end of the
    spectrum does not tell it. Beyond half the rate counts hold no motion (H. Nyquist 1928). A position that is none in
    counts has no such error, and no such end.
    """
    steps = np.abs(np.diff(position))
    moved = steps[steps > 0.0]
    counts = moved / np.min(moved, initial=np.inf)
    if not moved.size or np.median(np.abs(counts - np.round(counts))) > TUNING.whole:
        return 0.0, math.inf
    density = float(np.min(moved)) ** 2 / 12.0 * period / min(moved.size / steps.size, 0.5)
    return density, 0.5 * float(np.sum(counts)) / (steps.size * period)


def choose_band(found: Spectrum, period: float, given: float | None) -> float:
    """Return the band, Hz: a multiple of the motion's frequency, narrower where the acceleration is noise beyond.

    Raises
    ------
    InputError
        A band is given that is not allowed.
    """
    highest = TUNING.sampling_fraction / period
    if given is None:
        wanted = max(TUNING.times_motion * found.motion, TUNING.least_hertz)
        return min(wanted, max(found.quiet, TUNING.least_times_motion * found.motion), highest)
    check_numbers(bandwidth=given)
    if not 0.0 < given <= highest * (1.0 + 1e-9):
        raise InputError(
            f"bandwidth = {given:g} Hz is not allowed: it must be positive and at most a fifth of the sampling "
            f"frequency, {highest:.4g} Hz"
        )
    return float(given)


def _below(frequency: Array, power: Array, fraction: float) -> float:
    """Return the frequency below which a fraction of the power is."""
    cumulated = np.cumsum(power)
    place = int(np.searchsorted(cumulated, fraction * cumulated[-1]))
    return float(frequency[min(max(place, 1), frequency.size - 1)])


def _gap(frequency: Array, power: Array) -> float:
    """Return the frequency of the first octave above the middle of the power that holds next to none of it.

    Lines beyond such a gap are those of an encoder passed at constant speed, not of the motion.
    """
    edge, least = _below(frequency, power, 0.5), TUNING.empty * float(np.sum(power))
    while edge < frequency[-1]:
        inside = (frequency >= edge) & (frequency < 2.0 * edge)
        if float(np.sum(power[inside])) < least:
            return edge
        edge *= 2.0
    return math.inf


def lowpass(corner: float, period: float) -> Callable[[Array], Array]:
    """Return the zero-phase low-pass of a corner, Hz, at which its gain is a half; it takes a series, or columns."""
    sections = scipy.signal.butter(TUNING.order, min(corner, 0.49 / period), fs=1.0 / period, output="sos")
    return partial(_lowpass, sections, math.ceil(2.0 / (corner * period)))


def _lowpass(sections: Array, padding: int, values: Array) -> Array:
    size = min(padding, values.shape[0] - 1)
    return np.asarray(scipy.signal.sosfiltfilt(sections, values, axis=0, padlen=size))


class Rows(NamedTuple):
    """A segment at the working rate (s), behind the wide filter, and which samples are rows of the regression.

    ``in_band`` is the band's filter of a series, or of columns; ``kept`` are the samples that are rows, those without
    standstill, which is below ``slow`` (rad/s), of the ``inner`` ones, away from both ends; ``noise`` is that of the
    velocity, rad/s, behind the wide filter of a ``corner``, Hz.
    """

    period: float
    time: Array
    position: Array
    velocity: Array
    torque: Array
    known: Array
    in_band: Callable[[Array], Array]
    kept: NDArray[np.int64]
    inner: slice
    slow: float
    noise: float
    corner: float

    def between(self, still: float = 0.0) -> Array:
        """Return the velocity between samples, before the first and after the last; zero where slower than a speed."""
        velocity = np.where(np.abs(self.velocity) < still, 0.0, self.velocity)
        return np.concatenate([velocity[:1], 0.5 * (velocity[1:] + velocity[:-1]), velocity[-1:]])

    def unfiltered(self) -> "Rows":
        """Return every sample as a row, as it is."""
        return self._replace(in_band=np.asarray, kept=np.arange(self.time.size), noise=0.0)


def derivative(values: Array, period: float) -> Array:
    """Return central differences of fourth order."""
    result = np.gradient(values, period)
    result[2:-2] = (8.0 * (values[3:-1] - values[1:-3]) - (values[4:] - values[:-4])) / (12.0 * period)
    return result


def cut_edges(size: int, band: float) -> slice:
    """Return the samples away from both ends, where a filter of a band (cycles in a sample) knows one side alone."""
    edge = min(math.ceil(TUNING.edge_cycles / band), max(1, size // 4))
    return slice(edge, size - edge)


def make_rows(segment: Segment, band: float, found: Spectrum, fast: float, widest: float = math.inf) -> Rows:
    """Return the rows of a segment in a band, Hz; ``fast`` is a speed that few samples exceed, rad/s.

    The filter before the sign has a corner of at most ``widest``, Hz, but never below the band.
    """
    period = segment.period
    corner = max(band, min(TUNING.wide * band, 0.4 / period, widest))
    wide = lowpass(corner, period)
    every = max(1, int(1.0 / (TUNING.oversampling * corner * period)))
    position, torque, known = map(wide, (segment.position, segment.torque, segment.known))
    velocity = derivative(position, period)
    position, torque, known, velocity = (one[::every] for one in (position, torque, known, velocity))
    step = period * every
    scatter = math.sqrt(found.variance([corner], 0, period))
    slow = max(TUNING.standstill * fast, scatter)
    in_band = lowpass(band, step)
    stands = in_band((np.abs(velocity) < slow).astype(float))
    inner = cut_edges(position.size, band * step)
    apart = max(1, int(1.0 / (TUNING.rows_in_cycle * band * step)))
    places = np.arange(inner.start, inner.stop, apart)
    kept = places[stands[places] < TUNING.standstill_fraction]
    time: Array = (segment.start + step * np.arange(position.size)).astype(np.float64)
    return Rows(step, time, position, velocity, torque, known, in_band, kept, inner, slow, scatter, corner)


def even(time: Array, values: Array, grid: Array) -> Array:
    """Return a series at the even times of a grid, cubic between its samples; as it is where it has them already."""
    if time.size == grid.size and np.max(np.abs(time - grid)) < 0.02 * float(grid[1] - grid[0]):
        return values
    return np.asarray(interpolate.make_interp_spline(time, values, k=min(3, time.size - 1))(grid))
