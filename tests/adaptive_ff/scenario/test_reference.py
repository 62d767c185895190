"""Reference motions: the spectrum of the multisine, series on even grids, recorded motions and those that are none."""

import json
import math
import warnings
from pathlib import Path

import numpy as np
import pytest
from scenario_files import built_in, refused, to_toml

from adaptive_ff import InputError, load_scenario
from adaptive_ff.files import write_csv
from adaptive_ff.scenario import content as module
from adaptive_ff.scenario import file
from adaptive_ff.scenario.reference import Multisine, Recorded
from adaptive_ff.scenario.series import CHUNK, size_and_lost_fraction, sum_of_sines
from adaptive_ff.scenario.tables import Sampling

MULTISINE = load_scenario().reference
PERIOD = 0.001


def grid(duration, period=PERIOD):
    return period * np.arange(round(duration / period) + 1)


def draw(multisine, time, seed=0):
    return multisine.velocity(time, np.random.default_rng(seed))


def motion(time):
    """Position (rad) and velocity (rad/s) of a smooth motion that comes back to where it started after 20 s."""
    slow, fast = 2.0 * math.pi * 0.05, 2.0 * math.pi * 0.4
    position = 0.5 * np.sin(slow * time) - 0.08 * np.cos(fast * time)
    return position, 0.5 * slow * np.cos(slow * time) + 0.08 * fast * np.sin(fast * time)


def write(folder, columns):
    write_csv(folder / "motion.csv", columns)
    return folder / "motion.csv"


def read(path, **names):
    return Recorded(kind="csv", path=str(path), **names).read()


def test_a_written_scenario_finds_its_reference_wherever_it_lies(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    time = grid(20.0)
    write(tmp_path, {"time": time, "velocity": motion(time)[1]})
    for folder in ("one", "other"):
        Path(folder).mkdir()
    Path("one/j.toml").write_text(to_toml({**built_in(), "reference": {"kind": "csv", "path": "../motion.csv"}}))
    scenario = load_scenario("one/j.toml")
    Path("other/k.toml").write_text(file.to_toml(scenario))
    assert np.array_equal(load_scenario("other/k.toml").reference_velocity(), scenario.reference_velocity())


def test_multisine_has_the_stated_frequencies_with_amplitudes_in_the_stated_ratios():
    time = grid(100.0)[:-1]  # whole cycles of all frequencies
    velocity = draw(MULTISINE.model_copy(update={"fade_in": 0.0}), time)
    spectrum = 2.0 * np.abs(np.fft.rfft(velocity)) / time.size
    lines = np.rint(np.array(MULTISINE.frequencies) * 100.0).astype(int)
    found = spectrum[lines]
    assert found / found[0] == pytest.approx(np.array(MULTISINE.amplitudes) / MULTISINE.amplitudes[0], rel=1e-9)
    spectrum[lines] = 0.0
    assert np.max(spectrum) < 1e-12


@pytest.mark.parametrize("scale", [1.0, 1e-320, 1e305])
def test_largest_velocity_is_the_peak_whatever_the_size_of_the_amplitudes(scale):
    multisine = Multisine(amplitudes=[scale * 100.0, -scale * 50.0], frequencies=[0.1, 0.3], peak=0.35, fade_in=0.0)
    for seed in range(5):
        velocity = draw(multisine, grid(10.0), seed)
        assert np.max(np.abs(velocity)) == pytest.approx(0.35, rel=1e-12)
    assert np.max(np.abs(load_scenario().reference_velocity())) == pytest.approx(0.35, rel=1e-12)


def test_fade_in_starts_from_rest_without_a_jump_and_leaves_the_rest_alone():
    time = grid(10.0)
    faded, whole = draw(MULTISINE, time), draw(MULTISINE.model_copy(update={"fade_in": 0.0}), time)
    share = np.minimum(time / 2.0, 1.0)
    assert faded == pytest.approx(whole * (3.0 * share**2 - 2.0 * share**3), abs=1e-15)
    assert faded[0] == 0.0
    assert np.array_equal(faded[2000:], whole[2000:])
    jumps = np.abs(np.diff(faded))
    assert np.max(jumps[:2000]) < 2.0 * np.max(jumps[2000:])


def test_phases_come_from_the_generator():
    time = grid(20.0)
    assert np.array_equal(draw(MULTISINE, time, 3), draw(MULTISINE, time, 3))
    sine = Multisine(frequencies=[0.1], amplitudes=[1.0], peak=0.35, fade_in=0.0)
    phases = [math.asin(draw(sine, time, seed)[0] / 0.35) for seed in range(200)]
    assert np.std(phases) == pytest.approx(math.pi / math.sqrt(12.0), rel=0.1)  # of evenly spread ones, folded


OMEGAS = 2.0 * math.pi * np.array([0.01, 0.23, 1.0])
PHASES, WEIGHTS = np.array([0.3, 6.1, 2.5]), np.array([1.0, -0.4, 0.25])


@pytest.mark.parametrize("size", [1, 2, 3, 60001, CHUNK + 700])
def test_sum_is_that_of_the_sines_of_the_whole_grid(size):
    time = 0.001 * np.arange(size)
    angles = OMEGAS[:, None] * time + PHASES[:, None]
    found = sum_of_sines(OMEGAS, PHASES, WEIGHTS, time)
    np.testing.assert_allclose(found, WEIGHTS @ np.sin(angles), rtol=0.0, atol=4e-13)


@pytest.mark.parametrize("period", [0.001, 0.002, 0.01, 0.3])
@pytest.mark.parametrize("jitter", [0.0, 0.9])
@pytest.mark.parametrize("length", [3.0, 1.2e-3 * CHUNK])
def test_size_and_lost_fraction_are_those_of_an_interpolation(period, jitter, length):
    """Oracle: numpy's interpolation of the whole series."""
    steps = Sampling(period=period, jitter=jitter).steps(length, 0.001)
    series = np.random.default_rng(1).standard_normal(steps[-1] + 1).cumsum() + 5.0
    lost = series - np.interp(np.arange(series.size), steps, series[steps])
    size, fraction = size_and_lost_fraction(series, steps)
    assert size == pytest.approx(math.sqrt(np.mean(series**2)), rel=1e-12)
    assert fraction == pytest.approx(math.sqrt(np.mean(lost**2) / np.mean(series**2)), rel=1e-9, abs=1e-15)


def test_straight_line_loses_nothing_and_a_wave_that_is_zero_at_every_sample_all():
    steps = 10 * np.arange(41)
    assert size_and_lost_fraction(0.5 * np.arange(401.0), steps)[1] < 1e-15
    assert size_and_lost_fraction(np.sin(0.1 * math.pi * np.arange(401)), steps)[1] == pytest.approx(1.0, rel=1e-12)
    assert size_and_lost_fraction(np.zeros(401), steps) == (0.0, 0.0)


def test_recorded_reference_that_is_too_fast_for_the_sampling_is_refused(tmp_path):
    time = grid(1.0)
    path = write(tmp_path, {"time": time, "velocity": np.sin(2.0 * math.pi * 50.0 * time)})  # zero at every sample
    said = r"^built-in scenario: reference: 0\.7\d* of 0\.7\d* rad/s \(rms\) lie between"
    with pytest.raises(InputError, match=said):
        load_scenario(reference=path)


@pytest.mark.parametrize(
    ("column", "tolerance"),
    [("velocity", 5e-4), ("position", 2e-5)],  # rad/s, of a peak of 0.35 rad/s
)
def test_recorded_motion_with_jittered_times_is_resampled_closely(tmp_path, column, tolerance):
    jitter = np.random.default_rng(0).uniform(-0.009, 0.009, 1001)
    jitter[[0, -1]] = 0.0
    recorded = 12.5 + grid(20.0, 0.02) + jitter  # the clock of a recording need not start at zero
    position, velocity = motion(recorded - 12.5)
    path = write(tmp_path, {"time": recorded, column: {"position": position, "velocity": velocity}[column]})
    scenario = load_scenario(reference=path).modified(sampling={"period": 0.004})
    assert np.max(np.abs(scenario.reference_velocity() - motion(scenario.times())[1])) < tolerance


def test_velocity_is_taken_where_there_are_both_and_never_overshoots(tmp_path):
    time = grid(60.0, 1.0)
    steps = np.where(time % 4.0 < 2.0, 0.1, -0.1)
    path = write(tmp_path, {"position": 0.0 * time, "velocity": steps, "torque": 3.0 + time, "time": time})
    velocity = read(path).velocity(grid(60.0))
    assert np.max(np.abs(velocity)) == 0.1
    assert np.array_equal(velocity[::1000], steps)


def test_columns_may_have_other_names(tmp_path):
    time = grid(60.0, 0.1)
    path = write(tmp_path, {"t": time, "dq": motion(time)[1], "q": motion(time)[0]})
    by_velocity = read(path, time="t", velocity="dq").velocity(grid(60.0))
    by_position = read(path, time="t", position="q").velocity(grid(60.0))
    assert np.max(np.abs([by_velocity, by_position] - motion(grid(60.0))[1])) < 2e-2
    assert not np.array_equal(by_velocity, by_position)


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_byte_order_mark_blank_lines_spaces_and_trailing_commas_do_not_matter(tmp_path, newline):
    lines = ["", " time , velocity", "0, 0", "", " 1 ,1.5", "2,1e0,", ",", "3,-.5", "   ", "4,0", ""]
    path = tmp_path / "motion.csv"
    path.write_bytes(("\ufeff" + newline.join(lines)).encode("utf-8"))
    recorded = read(path)
    assert recorded.duration == 4.0
    assert recorded.velocity(np.arange(4.0)).tolist() == [0.0, 1.5, 1.0, -0.5]


def test_motion_shorter_than_a_minute_repeats_until_then(tmp_path):
    time = grid(20.0, 0.02)
    scenario = load_scenario(reference=write(tmp_path, {"time": time, "velocity": motion(time)[1]}))
    repeated = scenario.modified(duration=None)
    assert (repeated.motion.duration, repeated.length) == (20.0, 60.0)
    velocity = repeated.reference_velocity()
    assert np.max(np.abs(velocity[20_000:60_000] - np.tile(velocity[:20_000], 2))) < 1e-12
    assert scenario.modified(duration=10.0).length == 10.0


def test_seam_that_jumps_is_warned_of_when_it_is_reached(tmp_path):
    recorded = read(write(tmp_path, {"time": grid(4.0, 1.0), "velocity": [0.0, 0.3, 0.2, 0.1, 0.03]}))
    with pytest.warns(UserWarning, match=r"motion\.csv: the motion is repeated every 4 s, but ends 0\.03 rad/s away"):
        velocity = recorded.velocity(grid(9.0))
    assert velocity[[3999, 4001, 8001]] == pytest.approx([0.03, 0.0, 0.0], abs=1e-3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert recorded.velocity(grid(4.0))[-1] == 0.03  # the end itself belongs to the first time
        read(write(tmp_path, {"time": grid(4.0, 1.0), "velocity": [0.0, 0.3, 0.2, 0.1, 0.01]})).velocity(grid(9.0))


@pytest.mark.parametrize("duration", [75.0, 75.0072])
def test_motion_longer_than_a_minute_is_followed_to_its_end(tmp_path, duration):
    time = np.linspace(0.0, duration, 751)
    path = write(tmp_path, {"time": time, "velocity": 0.002 * time})  # ends far from where it starts
    scenario = load_scenario(reference=path).modified(duration=None)
    assert scenario.length == duration
    assert scenario.times()[-1] == pytest.approx(75.0, abs=1e-9)
    assert np.max(np.abs(scenario.reference_velocity() - 0.002 * scenario.times())) < 1e-12


def test_reference_is_computed_once_and_handed_out_as_a_copy(monkeypatch):
    scenario = load_scenario().modified(duration=3.0, seed=123)
    kind = type(scenario.reference)
    calls = []
    original = kind.velocity
    monkeypatch.setattr(kind, "velocity", lambda self, *rest: calls.append(1) or original(self, *rest))
    first = scenario.modified(actuator={"torque_limit": 90.0}).reference_velocity()
    first[:] = 0.0
    second = scenario.reference_velocity()
    assert not calls
    assert second.flags.writeable
    assert np.any(second)
    module.measured_motion.cache_clear()
    np.testing.assert_array_equal(scenario.reference_velocity(), second)
    assert len(calls) == 1


@pytest.mark.parametrize("change", [{"seed": 124}, {"duration": 4.0}, {"joint": {"solver_period": 0.0005}}])
def test_reference_is_another_one_where_what_it_depends_on_differs(change):
    scenario = load_scenario().modified(duration=3.0, seed=123)
    other = scenario.modified(**change).reference_velocity()
    kept = other.copy()
    module.measured_motion.cache_clear()
    np.testing.assert_array_equal(scenario.modified(**change).reference_velocity(), kept)
    assert other.size != scenario.reference_velocity().size or np.any(other != scenario.reference_velocity())


def test_reference_too_fast_for_one_sampling_is_still_refused_after_another():
    wave = {"frequencies": [4.0], "amplitudes": [1.0]}
    scenario = load_scenario().modified(duration=3.0, reference=wave, feedback={"bandwidth": 1.0})
    with pytest.raises(InputError, match="lie between the samples"):
        scenario.modified(sampling={"period": 0.1})


GOOD = ["time,velocity", "0,0.0", "20,0.1", "40,-0.1", "60,0.0"]


def refusal(path):
    """The message; the same, behind its own name, when the motion is asked for by a scenario."""
    message = refused(f"{path}: ", read, path)
    assert refused(f"built-in scenario: {path}: ", load_scenario, reference=path) == message
    return message


def refusal_of(folder, lines):
    path = folder / "motion.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return refusal(path)


def with_line(number, line):
    return [*GOOD[:number], line, *GOOD[number + 1 :]]


def test_motion_is_read_as_logs_are(tmp_path):
    """In all ways in which tables of a log are: here comments, semicolons and decimal commas."""
    plain, other = tmp_path / "plain.csv", tmp_path / "other.csv"
    plain.write_text("\n".join(GOOD), encoding="utf-8")
    other.write_text("# by the drive\ntime;velocity\n0;0,0\n\n20;0,1\n40;-0,1\n60;0,0", encoding="utf-8")
    time = np.linspace(0.0, 60.0, 61)
    motions = [read(path).velocity(time) for path in (plain, other)]
    assert np.array_equal(*motions)
    assert np.ptp(motions[0]) > 0.1


COLUMNS = ("t,velocity", "time,speed", "time", "0,0.0", "Time,Velocity")
CELLS = ("nan", "inf", "-inf", "1e400", "", " ", "fast", "0.1 rad/s", "0x10", "1_0", "--1", "None", "\u00bd")
NUMBER = "is not allowed: it must be a finite number"
MESSAGES = [
    *((lines, "the file is empty; it must have a header line and rows of numbers") for lines in ([], ["", "  ", ",,"])),
    *((GOOD[:rows], f"{rows - 1} rows are not enough for a motion; there must be at least 4") for rows in (1, 2, 4)),
    *(
        (with_line(0, one), f"the columns are {one.replace(',', ', ')}; there must be time and velocity or position")
        for one in COLUMNS
    ),
    *((with_line(3, f"40,{cell}"), f"velocity = {cell!r} in row 3 {NUMBER}") for cell in CELLS),
    *((with_line(3, f"{cell},0.1"), f"time = {cell!r} in row 3 {NUMBER}") for cell in CELLS),
    (with_line(2, "20"), f"velocity = '' in row 2 {NUMBER}"),
    ([f"{line},{line.split(',')[1]}" for line in GOOD], "there are 2 columns velocity; there must be one"),
    *(
        (lines, f"time = {time} s in row {row} follows {before} s; times must ascend strictly")
        for lines, time, row, before in (
            (with_line(3, "20,0.1"), 20, 3, 20),
            (with_line(3, "19.9,0.1"), 19.9, 3, 20),
            (with_line(3, "-1e300,0.1"), "-1e+300", 3, 20),
            (with_line(3, "60,0.1"), 60, 4, 60),
            (with_line(1, "-1e18,0"), 40, 3, 20),  # too far from the first to be told apart
            ([GOOD[0], "-1e308,0", "0,0", "1e308,0", "1.1e308,0"], "1.1e+308", 4, "1e+308"),
        )
    ),
]


@pytest.mark.parametrize(("lines", "message"), MESSAGES)
def test_lines_that_are_no_motion(tmp_path, lines, message):
    assert refusal_of(tmp_path, lines) == message


@pytest.mark.parametrize(
    ("lines", "begin"),
    [
        # as decimal commas would make it
        (with_line(2, "20,0,0,1"), "the header has 2 names, but row 2 has 4 cells: "),
        (with_line(2, "20,0.1,,7"), "the header has 2 names, but row 2 has 4 cells: "),
        ([GOOD[0], "-1e308,0", "-1e307,0", "0,0", "1e308,0"], "no smooth curve goes through the values: "),
        (with_line(0, ",".join(f'"column\n{i}"' for i in range(100))), "the columns are column 0, column 1"),
    ],
)
def test_message_of_long_lines_is_short(tmp_path, lines, begin):
    message = refusal_of(tmp_path, lines)
    assert message.startswith(begin)
    assert len(message) < 200


NO_TEXT = (b"\xff\xfe\x00\xd8t\x00i\x00", b"time,velocity\n0,\xe9\n", b"x" * 200_000)
UNREADABLE = [*(("motion.csv", content) for content in NO_TEXT)]
UNREADABLE += [(name, "\n".join(GOOD).encode()) for name in (".", "missing.csv", "motion.csv/inside", "x" * 300)]


@pytest.mark.parametrize(("name", "content"), UNREADABLE)
def test_file_that_cannot_be_read(tmp_path, name, content):
    (tmp_path / "motion.csv").write_bytes(content)
    assert refusal(tmp_path / name).startswith("cannot be read: ")


ROOT = Path(__file__).resolve().parents[3]
SCENARIO = ROOT / "benchmarks" / "kuka_kr300_axis4.toml"
DATA = ROOT.parent / "shared" / "data" / "kuka_kr300"
AXIS = 3
LINK_INERTIA = 50.0  # kg m^2, assumed: the source does not hold it

needs_data = pytest.mark.skipif(
    not DATA.is_dir(), reason=f"the recorded data lie outside the repository and are not there: {DATA}"
)


@needs_data
def test_scenario_holds_the_figures_of_the_source():
    source = json.loads((DATA / "source_model_parameters.json").read_text(encoding="utf-8"))
    motor_inertia = source["u"][AXIS] ** 2 * source["J_mr"][AXIS]  # on the link side
    coulomb, viscous = source["f_coul"][AXIS] + source["f_a"][AXIS], source["f_vis"][AXIS]
    scenario = load_scenario(SCENARIO)
    joint, fixed = scenario.joint, scenario.fixed
    assert joint.inertia == pytest.approx(motor_inertia + LINK_INERTIA, abs=0.005)
    assert (joint.coulomb, joint.viscous) == pytest.approx((coulomb, viscous), abs=0.005)
    assert joint.stiction == pytest.approx(1.5 * coulomb, rel=0.01)
    assert scenario.actuator.torque_limit == pytest.approx(source["torque_amp_limit"] * source["u"][AXIS], rel=1e-12)
    assert scenario.feedback.inertia == fixed.inertia == pytest.approx(motor_inertia, abs=0.005)
    assert (fixed.coulomb, fixed.viscous) == (joint.coulomb, joint.viscous)


@needs_data
def test_reference_is_the_recorded_motion_until_a_minute_is_over(tmp_path):
    with np.load(DATA / "trajectory_A.npz") as record:
        time, velocity = record["t"], record["dphi_ref_rad_per_s"][:, AXIS]
    write_csv(tmp_path / "motion.csv", {"time": time, "velocity": velocity})
    scenario = load_scenario(SCENARIO, reference=tmp_path / "motion.csv")
    assert scenario.length == 60.0
    reference = scenario.reference_velocity()
    assert np.interp(time, scenario.times(), reference) == pytest.approx(velocity, abs=1e-5)
    assert np.interp(50.0 + time[:-10], scenario.times(), reference) == pytest.approx(velocity[:-10], abs=1e-3)
