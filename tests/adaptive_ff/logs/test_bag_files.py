"""Bags of ROS, written by the library of the format and read back."""

import numpy as np
import pytest

from adaptive_ff import InputError
from adaptive_ff.logs.log import read_log

rosbags = pytest.importorskip("rosbags")

TIME = 0.01 * np.arange(7)
POSITION = np.array([0.0, 1.0, 4.0, 9.0, 16.0, 25.0, 36.0])
TORQUE = np.array([3.0, -1.0, 2.5, 0.0, 7.0, 1e-3, 8.0])
NAMES = {"position": "arm.joint_states.position[1]", "torque": "arm.joint_states.effort[1]"}


def message(types, k, first):
    stamp = types.types["builtin_interfaces/msg/Time"](sec=5, nanosec=round(1e9 * TIME[k]))
    header = types.types["std_msgs/msg/Header"](stamp=stamp, frame_id="base", **first)
    arrays = [np.array([0.0, value]) for value in (POSITION[k], 0.0, TORQUE[k])]
    return types.types["sensor_msgs/msg/JointState"](header, ["a", "b"], *arrays)


def write_ros2(folder):
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS2_HUMBLE)
    with Writer(folder / "bag", version=9) as writer:
        link = writer.add_connection("/arm/joint_states", "sensor_msgs/msg/JointState", typestore=types)
        for k in range(TIME.size):
            raw = types.serialize_cdr(message(types, k, {}), "sensor_msgs/msg/JointState")
            writer.write(link, round(1e9 * TIME[k]) + 7, raw)
    return folder / "bag" / "bag.db3"


def write_ros1(folder):
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS1_NOETIC)
    with Writer(folder / "log.bag") as writer:
        link = writer.add_connection("/arm/joint_states", "sensor_msgs/msg/JointState", typestore=types)
        for k in range(TIME.size):
            raw = types.serialize_ros1(message(types, k, {"seq": k}), "sensor_msgs/msg/JointState")
            writer.write(link, round(1e9 * TIME[k]) + 7, raw)
    return folder / "log.bag"


@pytest.mark.parametrize("write", [write_ros1, write_ros2])
def test_joint_states_of_a_bag_are_read(write, tmp_path):
    path = write(tmp_path)
    log = read_log(path, time="arm.joint_states.header.stamp", **NAMES)
    assert log.time == pytest.approx(5.0 + TIME, abs=1e-8)
    assert log.position.tolist() == POSITION.tolist()
    assert log.torque.tolist() == TORQUE.tolist()
    with pytest.raises(InputError, match=r"there is no column q; there are .*arm.joint_states.position \(7, 2\)"):
        read_log(path, time="arm.joint_states.log_time", position="q", torque=NAMES["torque"])


def test_a_file_that_is_no_bag_is_refused_in_one_line(tmp_path):
    (tmp_path / "log.bag").write_bytes(b"no bag at all")
    with pytest.raises(InputError, match="cannot be read") as refused:
        read_log(tmp_path / "log.bag", time="t", position="q", torque="u")
    assert "\n" not in str(refused.value)
