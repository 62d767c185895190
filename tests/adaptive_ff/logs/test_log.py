"""Logs in every format, recordings of robots among them, written by the library of the format and read back."""

import builtins
import json
import sys

import h5py
import numpy as np
import pyarrow
import pytest
from mcap.writer import Writer
from mcap_ros2.writer import Writer as RosWriter
from pyarrow import parquet
from scenario_files import refused
from scipy import io

from adaptive_ff import InputError
from adaptive_ff.logs.columns import read_scales
from adaptive_ff.logs.log import Log, read_log

TIME = 0.01 * np.arange(7)
POSITION = np.array([0.0, 1.0, 4.0, 9.0, 16.0, 25.0, 36.0])
TORQUE = np.array([3.0, -1.0, 2.5, 0.0, 7.0, 1e-3, 8.0])
TABLE = np.column_stack([TORQUE, 2.0 * TORQUE, POSITION])


def write_text(path, separator, header="t,q,u"):
    rows = [separator.join(header.split(","))]
    rows += [separator.join(map(repr, map(float, row))) for row in zip(TIME, POSITION, TORQUE, strict=True)]
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")


def write_matlab_73(path, **arrays):
    """Write a file as MATLAB's -v7.3 does: HDF5 behind a header of 512 bytes, axes reversed."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, array in arrays.items():
            file[name] = np.atleast_2d(array).T if array.ndim == 1 else array.T
    header = b"MATLAB 7.3 MAT-file".ljust(124, b" ") + b"\x00\x02IM"
    with path.open("r+b") as stream:
        stream.write(header)


def write_hdf5(path, **arrays):
    with h5py.File(path, "w") as file:
        for name, array in arrays.items():
            file[name] = array


WRITERS = {
    "comma.csv": lambda path: write_text(path, ","),
    "semicolon.csv": lambda path: write_text(path, ";"),
    "tab.txt": lambda path: write_text(path, "\t"),
    "arrays.npz": lambda path: np.savez(path, t=TIME, q=POSITION, u=TORQUE),
    "packed.npz": lambda path: np.savez_compressed(path, t=TIME, q=POSITION[:, np.newaxis], u=TORQUE[np.newaxis]),
    "old.mat": lambda path: io.savemat(path, {"t": TIME, "q": POSITION, "u": TORQUE}),
    "new.mat": lambda path: write_matlab_73(path, t=TIME, q=POSITION, u=TORQUE),
    "plain.h5": lambda path: write_hdf5(path, t=TIME, q=POSITION, u=TORQUE),
    "table.parquet": lambda path: parquet.write_table(pyarrow.table({"t": TIME, "q": POSITION, "u": TORQUE}), path),
}


@pytest.mark.parametrize("name", WRITERS)
def test_every_format_gives_the_same_log(name, tmp_path):
    path = tmp_path / name
    WRITERS[name](path)
    log = read_log(path, time="t", position="q", torque="u")
    assert np.array_equal(log.time, TIME)
    assert np.array_equal(log.position, POSITION)
    assert np.array_equal(log.torque, TORQUE)
    assert log.velocity is None
    assert log.motion is log.position


def write_matlab_5(path, **arrays):
    io.savemat(path, arrays)


@pytest.mark.parametrize("transposed", [False, True])
@pytest.mark.parametrize(
    ("ending", "write"), [("npz", np.savez), ("mat", write_matlab_5), ("mat", write_matlab_73), ("h5", write_hdf5)]
)
def test_series_of_a_table_is_picked_by_its_number(ending, write, transposed, tmp_path):
    path = tmp_path / f"table.{ending}"
    write(path, all=TABLE.T if transposed else TABLE)
    log = read_log(path, period=0.5, position="all[2]", torque="all[1]", extra={"feedforward": "all[0]"})
    assert np.array_equal(log.position, POSITION)
    assert np.array_equal(log.torque, 2.0 * TORQUE)
    assert np.array_equal(log.extra["feedforward"], TORQUE)
    assert np.array_equal(log.time, 0.5 * np.arange(7))


def test_members_of_structs_and_groups_are_reached_by_dots_and_text_without_content_is_none(tmp_path):
    io.savemat(tmp_path / "struct.mat", {"log": {"drive": {"u": TORQUE}, "q": POSITION}})
    write_hdf5(tmp_path / "group.h5", **{"log/drive/u": TORQUE, "log/q": POSITION, "log/remark": h5py.Empty("S10")})
    for name in ("struct.mat", "group.h5"):
        log = read_log(tmp_path / name, period=1.0, velocity="log.q", torque="log.drive.u")
        assert np.array_equal(log.torque, TORQUE)
        assert np.array_equal(log.velocity, POSITION)


def test_fields_of_structured_arrays_are_reached_by_dots(tmp_path):
    kind = [("t", "f8"), ("q", "f4"), ("tau", "f8", (2,)), ("note", "S3")]
    rows = np.zeros(7, dtype=kind)
    rows["t"], rows["q"], rows["tau"][:, 1] = TIME, POSITION, TORQUE
    np.savez(tmp_path / "rows.npz", log=rows)
    write_hdf5(tmp_path / "rows.h5", log=rows)
    for name in ("rows.npz", "rows.h5"):
        log = read_log(tmp_path / name, time="log.t", position="log.q", torque="log.tau[1]")
        assert np.array_equal(log.time, TIME)
        assert np.array_equal(log.position, POSITION.astype(np.float32))
        assert np.array_equal(log.torque, TORQUE)
        with pytest.raises(InputError, match=r"no column q; there are log\.t, log\.q, log\.tau \(7, 2\)"):
            read_log(tmp_path / name, time="log.t", position="q", torque="log.tau[1]")


def test_times_and_durations_are_read_as_seconds(tmp_path):
    """As pandas writes an index of times to Parquet."""
    durations = (1e9 * TIME).round().astype("m8[ns]")
    moments = np.datetime64("2026-11-27T12:00:00", "ns") + durations
    missing = np.where(np.arange(7) == 2, np.datetime64("NaT", "ns"), moments)
    columns = {"moment": moments, "elapsed": durations, "missing": missing, "q": POSITION, "u": TORQUE}
    parquet.write_table(pyarrow.table(columns), tmp_path / "log.parquet")
    np.savez(tmp_path / "log.npz", **columns, months=np.arange(7).astype("m8[M]"))
    with pytest.raises(InputError, match="months holds months or years, which are no time in seconds"):
        read_log(tmp_path / "log.npz", time="months", position="q", torque="u")
    for name in ("log.parquet", "log.npz"):
        stamps = ("moment", "elapsed", "missing")
        read = {time: read_log(tmp_path / name, time=time, position="q", torque="u").time for time in stamps}
        assert read["moment"] == pytest.approx(TIME - TIME[0], abs=1e-9)
        assert read["elapsed"] == pytest.approx(TIME, abs=1e-9)
        assert np.isnan(read["missing"][2])
        assert np.delete(read["missing"], 2) == pytest.approx(np.delete(TIME - TIME[0], 2), abs=1e-9)


def test_lists_in_a_column_of_parquet_are_picked_by_their_number_and_must_be_alike(tmp_path):
    """As LeRobot writes vectors."""
    rows = [*TABLE.tolist()[:-1], None]
    columns = {"t": TIME, "state": rows, "ragged": [[1.0, 2.0], *[[1.0]] * 6]}
    parquet.write_table(pyarrow.table(columns), tmp_path / "log.parquet")
    log = read_log(tmp_path / "log.parquet", time="t", position="state[2]", torque="state[0]")
    assert np.array_equal(log.position, [*POSITION[:-1], np.nan], equal_nan=True)
    assert np.array_equal(log.torque, [*TORQUE[:-1], np.nan], equal_nan=True)
    path = tmp_path / "log.parquet"
    message = "ragged has lists of 1 to 2 numbers; they must be alike"
    assert message in refused(f"{path}: ", read_log, path, time="t", position="state[2]", torque="ragged[0]")


def test_factors_apply_to_their_columns_only(tmp_path):
    np.savez(tmp_path / "log.npz", ms=1e3 * TIME, all=TABLE)
    scale = {"ms": 1e-3, "all[2]": np.pi / 180.0, "all[0]": -48.0}
    log = read_log(tmp_path / "log.npz", time="ms", position="all[2]", torque="all[0]", scale=scale)
    assert log.time == pytest.approx(TIME, abs=1e-15)
    assert np.array_equal(log.position, np.pi / 180.0 * POSITION)
    assert np.array_equal(log.torque, -48.0 * TORQUE)


def test_column_whose_own_name_has_brackets_is_found(tmp_path):
    write_text(tmp_path / "log.csv", ",", "t,q[0],u")
    assert np.array_equal(read_log(tmp_path / "log.csv", time="t", position="q[0]", torque="u").position, POSITION)


def test_cells_without_a_number_become_nan_and_one_row_is_a_log_of_one_sample(tmp_path):
    (tmp_path / "one.csv").write_text("t,q,u\n0,1,5\n", encoding="utf-8")
    assert read_log(tmp_path / "one.csv", **GOOD).torque.tolist() == [5.0]
    (tmp_path / "log.csv").write_text('t,q,"u"\n0,1,5\n1,,6\n2,x,"7"\n3,4\n', encoding="utf-8")
    with pytest.warns(UserWarning, match="log.csv: q = 'x' in row 3 is no number; such samples are left out"):
        log = read_log(tmp_path / "log.csv", time="t", position="q", torque="u")
    assert np.array_equal(log.time, [0.0, 1.0, 2.0, 3.0])
    assert np.array_equal(log.position, [1.0, np.nan, np.nan, 4.0], equal_nan=True)
    assert np.array_equal(log.torque, [5.0, 6.0, 7.0, np.nan], equal_nan=True)


@pytest.mark.parametrize("known", ["known_torque", "position", "time"])
def test_column_of_two_roles_is_refused(known, tmp_path):
    (tmp_path / "log.csv").write_text("t,q,u\n0,1,5\n1,2,6\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"the column u is given as torque and as \w[\w ]+; each must have its own"):
        read_log(tmp_path / "log.csv", **{**GOOD, known: "u"})


def test_scaling_names_the_column_and_what_it_is_scaled_by_already(tmp_path):
    (tmp_path / "log.csv").write_text("t,q,u\n0,1,5\n1,2,6\n", encoding="utf-8")
    log = read_log(tmp_path / "log.csv", **GOOD, scale={"u": -48.0})
    assert log.scaling("time", "1e-3", "1e-6") == "give --scale t=1e-3 or --scale t=1e-6"
    assert log.scaling("motion", "pi/180") == "give --scale q=pi/180"
    spaced = Log("log", log.time, log.torque, velocity=log.torque, columns={"velocity": "w [rpm]"})
    assert spaced.scaling("velocity", "pi/30") == "give --scale 'w [rpm]=pi/30'"
    assert log.scaling("torque", "-1") == "give --scale 'u=-48*-1'"
    assert read_scales(["u=-48*-1"]) == {"u": 48.0}
    assert Log("log", log.time, log.torque, velocity=log.torque).scaling("motion", "2") == "scale the velocity by 2"


def test_arrays_that_are_not_wanted_are_not_read(tmp_path):
    objects = np.array([{"note": 1}, None], dtype=object)  # reading it would need pickle, which is refused
    np.savez(tmp_path / "log.npz", t=TIME, q=POSITION, u=TORQUE, note=objects)
    assert read_log(tmp_path / "log.npz", time="t", position="q", torque="u").torque.size == 7
    with pytest.raises(InputError, match="note holds Python objects; it must hold numbers"):
        read_log(tmp_path / "log.npz", time="t", position="q", torque="note")


def test_series_of_floats_is_not_copied_but_taken(tmp_path, monkeypatch):
    arrays = {"t": TIME.copy(), "q": POSITION.copy(), "u": TORQUE.copy()}
    path, loaded, archive = tmp_path / "log.npz", {}, np.lib.npyio.NpzFile
    np.savez(path, **arrays)
    original = archive.__getitem__
    monkeypatch.setattr(archive, "__getitem__", lambda file, key: loaded.setdefault(key, original(file, key)))
    log = read_log(path, time="t", position="q", torque="u")
    for name, series in {"t": log.time, "q": log.position, "u": log.torque}.items():
        assert np.shares_memory(series, loaded[name])


GOOD = {"time": "t", "position": "q", "torque": "u"}

REFUSED = [
    ({**GOOD, "torque": "tau"}, "there is no column tau; there are t, q, u, all (7, 3), short, text, phasor"),
    ({**GOOD, "torque": "all"}, "all has shape (7, 3); to pick a series of it write all[0]"),
    ({**GOOD, "torque": "all[3]"}, "all has shape (7, 3); all[3] must count one of its 3 series from 0"),
    ({**GOOD, "torque": "u[0]"}, "u is a single series: write u, not u[0]"),
    ({**GOOD, "torque": "short"}, "t has 7 samples, short has 3; they must be alike"),
    ({**GOOD, "torque": "text"}, "text holds text; it must hold real numbers"),
    ({**GOOD, "torque": "phasor"}, "phasor holds complex numbers; it must hold real numbers"),
    ({**GOOD, "torque": "one"}, "t has 7 samples, one has 1; they must be alike"),
    ({**GOOD, "time": "one"}, "one has 1 sample, u has 7; they must be alike"),
    ({**GOOD, "torque": "cube"}, "cube has shape (7, 2, 2); it must have one axis or two"),
    ({**GOOD, "velocity": "q"}, "a position or a velocity must be named, one of them"),
    ({**GOOD, "position": None}, "a position or a velocity must be named, one of them"),
    ({**GOOD, "period": 0.1}, "a column of time or a period must be given, one of them"),
    ({**GOOD, "time": None, "period": -1.0}, "period = -1 s is not allowed: it must be positive"),
    ({**GOOD, "time": None, "period": np.nan}, "period = nan s is not allowed: it must be positive"),
    ({**GOOD, "scale": {"all": 2.0}}, "scale: all is no column that is used; these are u, t, q"),
    ({**GOOD, "scale": {"q": 0.0}}, "scale: q = 0 is not allowed: it must be finite and not zero"),
]


@pytest.mark.parametrize(("arguments", "message"), REFUSED)
def test_wrong_choice_of_columns_is_refused_with_what_there_is(arguments, message, tmp_path):
    path = tmp_path / "log.npz"
    text = np.array(["a"] * 7)
    odd = {"phasor": 1j * TORQUE, "one": TORQUE[:1], "cube": np.zeros((7, 2, 2))}
    np.savez(path, t=TIME, q=POSITION, u=TORQUE, all=TABLE, short=TORQUE[:3], text=text, **odd)
    assert message in refused(f"{path}: ", read_log, path, **arguments)


def test_column_of_words_is_refused(tmp_path):
    (tmp_path / "log.csv").write_text("t,q,u\n0,a,1\n1,b,2\n", encoding="utf-8")
    with (
        pytest.warns(UserWarning, match=r"q = 'a' in row 1 is no number \(and so 1 other cell\); such samples"),
        pytest.raises(InputError, match="q holds no finite number"),
    ):
        read_log(tmp_path / "log.csv", **GOOD)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("log.csv", None, "No such file"),
        ("log.npz", b"PK no archive", "cannot be read"),
        ("log.npz", bytes(range(256)) * 10, "cannot be read: it is no NPZ archive"),
        ("log.mat", b"\x00" * 300, "cannot be read"),
        ("log.parquet", b"PAR?", "cannot be read"),
        ("log.h5", b"no HDF5", "cannot be read"),
        ("log.csv", b"", "the file is empty"),
        ("log.csv", b"\xff\xfe\x00\xd8t\x00", "cannot be read"),
        ("log.csv", b"t,q,q,u\n1,2,3,4\n", "there are 2 columns q; there must be one"),
        ("log.xlsx", b"", "the ending '.xlsx' is not known; allowed: .csv, .txt, .tsv, .dat, .npz, .mat"),
    ],
)
def test_damaged_file_is_refused_in_one_line(name, content, message, tmp_path):
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    assert message in refused(f"{path}: ", read_log, path, **GOOD)


@pytest.mark.parametrize(("name", "library"), [("new.mat", "h5py"), ("table.parquet", "pyarrow")])
def test_missing_library_is_named(name, library, tmp_path, monkeypatch):
    path = tmp_path / name
    WRITERS[name](path)
    for module in [module for module in sys.modules if module.partition(".")[0] == library]:
        monkeypatch.delitem(sys.modules, module)
    original = builtins.__import__

    def without(module, *arguments, **named):
        if module.partition(".")[0] == library:
            raise ImportError(f"No module named {module!r}")
        return original(module, *arguments, **named)

    monkeypatch.setattr(builtins, "__import__", without)
    monkeypatch.setitem(sys.modules, library, None)  # what importlib refuses
    with pytest.raises(InputError, match=rf"takes {library}, .* pip install {library}"):
        read_log(path, **GOOD)


@pytest.mark.parametrize("several", [False, True])
def test_simulink_structure_with_time_is_read(several, tmp_path):
    signals = np.empty(2, dtype=[("values", object), ("label", object)])  # an array of structs
    signals[:] = [(POSITION, "q"), (TORQUE, "u")]
    content = signals if several else {"values": np.column_stack([POSITION, TORQUE]), "dimensions": 2.0}
    io.savemat(tmp_path / "out.mat", {"out": {"time": TIME, "signals": content, "blockName": "model/Scope"}})
    names = ("out.signals.0.values", "out.signals.1.values")
    position, torque = names if several else ("out.signals.values[0]", "out.signals.values[1]")
    log = read_log(tmp_path / "out.mat", time="out.time", position=position, torque=torque)
    for series, true in ((log.time, TIME), (log.position, POSITION), (log.torque, TORQUE)):
        assert series.tolist() == true.tolist()


NAMES = {"position": "arm.joint_states.position[1]", "torque": "arm.joint_states.effort[1]"}

JOINT_STATE = """std_msgs/Header header
float64[] position
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


def write_ros(path, shorter=None):
    with path.open("wb") as stream, RosWriter(stream) as writer:
        schema = writer.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
        for k, (position, torque) in enumerate(zip(POSITION, TORQUE, strict=True)):
            size = 1 if k == shorter else 2
            message = {
                "header": {"stamp": {"sec": 5, "nanosec": round(1e9 * TIME[k])}, "frame_id": "base"},
                "position": [0.0, position][-size:],
                "effort": [0.0, torque][-size:],
            }
            nanoseconds = round(1e9 * TIME[k]) + 7
            writer.write_message("/arm/joint_states", schema, message, nanoseconds, nanoseconds)


def write_json(path, encoding="json"):
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("state", "jsonschema", b"{}")
        channel = writer.register_channel("/drive", encoding, schema)
        for t, position, torque in zip(TIME, POSITION, TORQUE, strict=True):
            axes = [{"u": -torque}, {"u": torque}]
            data = json.dumps({"t": t, "q": position, "axis": axes[1], "axes": axes, "name": "x"}).encode()
            writer.add_message(channel, round(1e9 * t), data, round(1e9 * t))
        writer.finish()


def message(types, k, first):
    stamp = types.types["builtin_interfaces/msg/Time"](sec=5, nanosec=round(1e9 * TIME[k]))
    header = types.types["std_msgs/msg/Header"](stamp=stamp, frame_id="base", **first)
    arrays = [np.array([0.0, value]) for value in (POSITION[k], 0.0, TORQUE[k])]
    return types.types["sensor_msgs/msg/JointState"](header, ["a", "b"], *arrays)


def write_bag(writer, store, serialize, with_number):
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(getattr(Stores, store))
    with writer:
        link = writer.add_connection("/arm/joint_states", "sensor_msgs/msg/JointState", typestore=types)
        for k in range(TIME.size):
            said = message(types, k, {"seq": k} if with_number else {})
            raw = getattr(types, serialize)(said, "sensor_msgs/msg/JointState")
            writer.write(link, round(1e9 * TIME[k]) + 7, raw)


def write_ros2(folder):
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    write_bag(rosbag2.Writer(folder / "bag", version=9), "ROS2_HUMBLE", "serialize_cdr", False)
    return folder / "bag" / "bag.db3"


def write_ros1(folder):
    rosbag1 = pytest.importorskip("rosbags.rosbag1")
    write_bag(rosbag1.Writer(folder / "log.bag"), "ROS1_NOETIC", "serialize_ros1", True)
    return folder / "log.bag"


def write_mcap(folder):
    write_ros(folder / "log.mcap")
    return folder / "log.mcap"


@pytest.mark.parametrize("write", [write_mcap, write_ros1, write_ros2])
def test_joint_states_of_ros_are_read(write, tmp_path):
    path = write(tmp_path)
    log = read_log(path, time="arm.joint_states.header.stamp", **NAMES)
    assert log.time == pytest.approx(5.0 + TIME, abs=1e-8)
    assert log.position.tolist() == POSITION.tolist()
    assert log.torque.tolist() == TORQUE.tolist()
    by_recorder = read_log(path, time="arm.joint_states.log_time", **NAMES)
    assert by_recorder.time == pytest.approx(TIME, abs=1e-8)
    with pytest.raises(InputError, match=r"there is no column q; there are .*arm.joint_states.position \(7, 2\)"):
        read_log(path, time="arm.joint_states.log_time", position="q", torque=NAMES["torque"])


def test_messages_in_json_are_read(tmp_path):
    write_json(tmp_path / "log.mcap")
    extra = {"same": "drive.axes.1.u"}
    log = read_log(tmp_path / "log.mcap", time="drive.t", position="drive.q", torque="drive.axis.u", extra=extra)
    assert log.time.tolist() == TIME.tolist()
    assert log.position.tolist() == POSITION.tolist()
    assert log.torque.tolist() == log.extra["same"].tolist() == TORQUE.tolist()


@pytest.mark.parametrize(
    ("name", "write", "message"),
    [
        ("log.mcap", lambda path: write_json(path, "protobuf"), "messages are encoded as protobuf; cdr"),
        ("log.mcap", lambda path: write_ros(path, shorter=2), "arm.joint_states.effort is not the same in all"),
        ("log.mcap", lambda path: path.write_bytes(b"no mcap at all"), "cannot be read"),
        ("log.mcap", lambda path: path.write_bytes(b""), "cannot be read"),
        ("log.bag", lambda path: path.write_bytes(b"no bag at all"), "cannot be read"),
    ],
)
def test_useless_recording_is_refused_in_one_line(name, write, message, tmp_path):
    write(tmp_path / name)
    assert message in refused("", read_log, tmp_path / name, time="arm.joint_states.log_time", **NAMES)
