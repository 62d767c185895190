"""Programs beside an exported controller: a test of it against a recorded run, and an example of its use."""

from typing import Any

import numpy as np

from adaptive_ff.export.export import Export
from adaptive_ff.export.rendering import rendered
from controllers import feedback_state
from controllers.interface import inertia_of
from controllers.kernels.names import c_name

TOLERANCE = {False: 1e-9, True: 7e-5}
"""Largest difference to the recorded run, as a fraction of its largest torque, in double and in single precision.

In single precision 2.0e-5 was measured at most for controllers that identify, and 1.3e-5 for the others.
"""

SAMPLES_TO_FOLLOW = 5.0
"""Time constant of the example's loop where the controller names no inertia, sampling periods."""


def self_test(export: Export) -> str:
    """Return a program that repeats a recorded run."""
    recording, names = export.recording, export.input_names
    outputs = [name for name, _ in export.output.fields]
    torques = recording.outputs[np.isfinite(recording.outputs)]
    tolerance = TOLERANCE[export.single]
    return rendered(
        "selftest.c",
        prefix=export.prefix,
        upper=export.upper,
        real=export.precision.real,
        samples=len(recording.inputs),
        tolerance=tolerance,
        largest=max(float(np.max(np.abs(torques))), 1e-300),
        columns=", ".join(names),
        width=len(names),
        inputs=_rows(export, recording.inputs),
        outputs_columns=", ".join(outputs),
        outputs_width=len(outputs),
        outputs=_rows(export, recording.outputs),
        given="\n".join(f"        inputs.{c_name(name)} = INPUTS[k][{i}];" for i, name in enumerate(names)),
        found=", ".join(f"(double)output.{c_name(name)}" for name in outputs),
    )


def _rows(export: Export, table: Any) -> str:
    literal = export.precision.literal
    rows = [[literal(float(item)) for item in row] for row in table.tolist()]
    return "\n".join(f"    {{{', '.join(row)}}}," for row in rows)


def example(export: Export) -> str:
    """Return a program that runs the controller in a loop."""
    return rendered(
        "main.c",
        prefix=export.prefix,
        upper=export.upper,
        real=export.precision.real,
        zero=export.precision.literal(0.0),
        inertia=_inertia(export),
    )


def _inertia(export: Export) -> str:
    """Return the inertia that the controller was made with, or one that the loop of its gains is stable with."""
    controller = export.controller
    stable = SAMPLES_TO_FOLLOW * feedback_state(controller.parameters).proportional * controller.period
    return f"{inertia_of(controller.parameters).get('inertia', max(stable, 1e-6)):g}"
