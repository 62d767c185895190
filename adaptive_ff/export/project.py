"""The folder of an exported controller: its source, a test of it against a recorded run, an example of its use."""

from pathlib import Path

import numpy as np

from adaptive_ff.errors import check_among, checked_path
from adaptive_ff.export.errors import exporting
from adaptive_ff.export.export import Export
from adaptive_ff.export.fmu import VERSIONS, fmu
from adaptive_ff.export.sample import record
from adaptive_ff.export.source import header, rendered, source
from adaptive_ff.files import staged
from controllers import Controller, feedback_state
from controllers.checks import checked_switch
from controllers.interface import inertia_of

TOLERANCE = {False: 1e-9, True: 7e-5}
"""Largest difference to the recorded run, as a fraction of its largest torque, in double and in single precision.

In single precision 2.0e-5 was measured at most for controllers that identify, and 1.3e-5 for the others.
"""

SAMPLES_TO_FOLLOW = 5.0
"""Time constant of the example's loop where the controller names no inertia, sampling periods."""


def project_files(export: Export) -> dict[str, str]:
    """Return the files of an export by name.

    The self-test repeats a recorded run; the example runs in the loop of the controller's inertia, or of one that is
    stable with its gains.
    """
    prefix, controller, recording = export.prefix, export.controller, record(export.controller)
    test = {
        "tolerance": TOLERANCE[export.single],
        "recording": recording,
        "largest": max(float(np.max(np.abs(recording.outputs[np.isfinite(recording.outputs)]))), 1e-300),
        "outputs": [name for name, _ in export.output.fields],
    }
    stable = SAMPLES_TO_FOLLOW * feedback_state(controller.parameters).proportional * controller.period
    inertia = inertia_of(controller.parameters).get("inertia", max(stable, 1e-6))
    return {
        f"{prefix}.h": header(export),
        f"{prefix}.c": source(export),
        f"{prefix}_selftest.c": rendered("selftest.c", export, **test),
        "main.c": rendered("main.c", export, inertia=f"{inertia:g}"),
        "CMakeLists.txt": rendered("CMakeLists.txt", export),
    }


def export_controller(
    controller: Controller,
    out: str | Path,
    *,
    prefix: str = "controller",
    single: bool = False,
    with_fmu: bool | str = False,
) -> list[Path]:
    """Write a controller as C99 source that any compiler takes, with a self-test, an example and a CMake file.

    The code is translated from the kernels that run in Python: on x86-64 with glibc it gives the same bits. It starts
    with the settings of the controller and in the state that it is in, estimates included.

    Parameters
    ----------
    controller : Controller
        Any controller whose step is a kernel; it is left as it is.
    out : str or Path
        Folder for the files; it is made where it is missing. Either all files are written or none.
    prefix : str, optional
        Begins all names in C, and the names of the files.
    single : bool, optional
        Compute in single precision, for processors without double.
    with_fmu : bool or str, optional
        Also write ``PREFIX.fmu``, an FMU for co-simulation with the source and, where a C compiler is at hand, a binary
        for this machine: of FMI ``"2.0"``, as with True, or ``"3.0"``.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    InputError
        The controller cannot be exported, or the folder cannot be written.

    Examples
    --------
    >>> from adaptive_ff import export_controller
    >>> from controllers import PI
    >>> files = export_controller(PI(100.0, 10.0, 0.001), "drive", prefix="axis1")  # doctest: +SKIP
    """
    folder = checked_path("out", out)
    also_fmu = with_fmu if isinstance(with_fmu, str) else "2.0" if checked_switch("with_fmu", with_fmu) else ""
    if also_fmu:
        check_among("version of FMI ", also_fmu, VERSIONS)
    export = Export(controller, prefix, single)
    with exporting():  # a number may be too large for single precision
        files = {name: text.encode("ascii") for name, text in project_files(export).items()}
        if also_fmu:
            files[f"{prefix}.fmu"] = fmu(export, also_fmu)
    with staged(folder) as stage:
        for name, content in files.items():
            (stage / name).write_bytes(content)
    return [folder / name for name in files]
