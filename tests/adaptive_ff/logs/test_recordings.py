"""Recordings of robots, MCAP files and bags of ROS, written by the libraries of the formats and read back."""

import json

import numpy as np
import pytest
from mcap.writer import Writer
from mcap_ros2.writer import Writer as RosWriter
from scenario_files import refused

from adaptive_ff import InputError
from adaptive_ff.logs.log import read_log

TIME = 0.01 * np.arange(7)
POSITION = np.array([0.0, 1.0, 4.0, 9.0, 16.0, 25.0, 36.0])
TORQUE = np.array([3.0, -1.0, 2.5, 0.0, 7.0, 1e-3, 8.0])
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
            data = json.dumps({"t": t, "q": position, "axis": {"u": torque}, "name": "x"}).encode()
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
    log = read_log(tmp_path / "log.mcap", time="drive.t", position="drive.q", torque="drive.axis.u")
    assert log.time.tolist() == TIME.tolist()
    assert log.position.tolist() == POSITION.tolist()
    assert log.torque.tolist() == TORQUE.tolist()


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
def test_useless_file_is_refused_in_one_line(name, write, message, tmp_path):
    write(tmp_path / name)
    assert message in refused("", read_log, tmp_path / name, time="arm.joint_states.log_time", **NAMES)
