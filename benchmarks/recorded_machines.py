"""The recorded machines: where their data come from, and how their columns are read."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy import io

from adaptive_ff.logs.log import Log, read_log

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


@dataclass(frozen=True)
class DataSet:
    """Files of a machine, and where they come from."""

    name: str  # name of the machine
    folder: str  # folder of its files, beside those of the other machines
    files: tuple[str, ...]  # files that are needed
    origin: str  # how to get them

    def missing(self, data: Path) -> list[str]:
        """Return the files that are not there."""
        return [file for file in self.files if not (data / self.folder / file).is_file()]


EMPS = DataSet(
    "EMPS",
    "emps",
    ("DATA_EMPS.mat", "DATA_EMPS_PULSES.mat"),
    "A. Janot, M. Gautier, M. Brunot, Data Set and Reference Models of EMPS, 2019 (nonlinearbenchmark.org); copies "
    "in github.com/forgi86/sysid-neural-continuous, commit 956aa7ecd73061b0321c6f6098d74c9e4a7ce67a, "
    "examples/EMPS/data/{DATA_EMPS,DATA_EMPS_PULSES}.mat",
)

STAUBLI = DataSet(
    "Staubli TX40",
    "staubli_tx40",
    ("tx40_exciting_trajectory.npz",),
    "github.com/thanhndv212/figaroh-plus, commit c3b5172849b744984b7181fd9d517c83fb4242e1, "
    "examples/staubli_TX40/data/{curr_data,pos_read_data}.csv (Apache-2.0); pack them into "
    "tx40_exciting_trajectory.npz as motor_torque_Nm and motor_position_rad, both (samples, 6)",
)

KUKA = DataSet(
    "KUKA KR300",
    "kuka_kr300",
    ("trajectory_A.npz", "trajectory_B.npz"),
    "J. Weigand et al., github.com/JonasWeigand/Robot_Identification, commit 9e403c07d9dadbb391a9f3921e8d219f714636a8, "
    "data/recorded_trajectories/2020-10-21 10s FF {A,B} 08ms/data.mat (MIT); pack t, act_pos_mot_deg, "
    "act_torque_abs_nm, dphi_ref_rad_per_s and tau_ff_all, axes as columns, into trajectory_{A,B}.npz",
)

RATIOS = (32.0, 32.0, 45.0, -48.0, 45.0, 32.0)  # gear ratios of the Staubli TX40, from its source


@dataclass(frozen=True)
class Job:
    """Logs of a joint: one to identify and to start cold on, and perhaps another one of the same joint."""

    data: DataSet  # the machine
    joint: str  # name of the joint; empty where there is only one
    records: tuple[str, ...]  # names of the logs
    read: Callable[[Path, str], Log]  # reads a log: ``read(data, record)``
    held_out: float = 0.25  # share of the first log that is validated on where there is no other
    linear: bool = False  # whether it is a linear axis
    settings: dict[str, Any] = field(default_factory=dict)  # what the adaptive controller assumes
    simulated: bool = False  # whether the identified joint is simulated in a closed loop, too
    scored: bool = False  # whether the second log is simulated in open loop by a model trained on the first

    @property
    def name(self) -> str:
        """Machine and joint."""
        return f"{self.data.name} {self.joint}".strip()


def read_emps(data: Path, record: str) -> Log:
    """Read a record of the EMPS, with its reference position."""
    path = data / EMPS.folder / record
    gain = io.loadmat(path, variable_names=["gtau"])["gtau"].item()
    return read_log(
        path, time="t", position="qm", torque="vir", scale={"vir": gain}, extra={"reference_position": "qg"}
    )


def staubli_reader(joint: int) -> Callable[[Path, str], Log]:
    """Return the reader of a joint of the Staubli TX40, from the motor's to the joint's side."""
    torque, position = f"motor_torque_Nm[{joint - 1}]", f"motor_position_rad[{joint - 1}]"
    ratio = RATIOS[joint - 1]

    def read(data: Path, record: str) -> Log:
        path = data / STAUBLI.folder / record
        scale = {position: 1.0 / ratio, torque: ratio}
        return read_log(path, period=2e-4, position=position, torque=torque, scale=scale)

    return read


def kuka_reader(axis: int) -> Callable[[Path, str], Log]:
    """Return the reader of an axis of the KUKA KR300: motion on the link's side, torque on the motor's.

    The position is read, not the velocity, which lags it by a sample.
    """
    position = f"act_pos_mot_deg[{axis - 1}]"

    def read(data: Path, record: str) -> Log:
        return read_log(
            data / KUKA.folder / record,
            time="t",
            position=position,
            torque=f"act_torque_abs_nm[{axis - 1}]",
            scale={position: np.pi / 180.0},
            extra={
                "reference_velocity": f"dphi_ref_rad_per_s[{axis - 1}]",
                "feedforward": f"tau_ff_all[{axis - 1}]",
            },
        )

    return read


SETTINGS = {"memory": 2.0, "identify": "directions"}
KUKA_SETTINGS = {"stribeck_velocity": 0.01, **SETTINGS}
"""Chosen on record A of axes 1, 4 and 6 together; record B took no part, and neither did the other machines."""

JOBS = (
    Job(EMPS, "", EMPS.files, read_emps, linear=True, settings=SETTINGS, simulated=True, scored=True),
    Job(STAUBLI, "joint 1", STAUBLI.files, staubli_reader(1), held_out=1.0 / 3.0, settings=SETTINGS),
    Job(STAUBLI, "joint 4", STAUBLI.files, staubli_reader(4), held_out=1.0 / 3.0, settings=SETTINGS),
    Job(KUKA, "axis 1", KUKA.files, kuka_reader(1), settings=KUKA_SETTINGS),
    Job(KUKA, "axis 4", KUKA.files, kuka_reader(4), settings=KUKA_SETTINGS, simulated=True),
    Job(KUKA, "axis 6", KUKA.files, kuka_reader(6), settings=KUKA_SETTINGS, simulated=True),
)
"""All joints."""
