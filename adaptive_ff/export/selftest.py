"""Programs beside an exported controller: a test of it against a recorded run, and an example of its use."""

from typing import Any

import numpy as np

from adaptive_ff.export.export import Export
from controllers import feedback_state
from controllers.interface import inertia_of
from controllers.kernels.names import c_name

TOLERANCE = {False: 1e-9, True: 7e-5}
"""Largest difference to the recorded run, as a share of its largest torque, in double and in single precision.

In single precision 2.0e-5 was measured at most for the adaptive controllers, whose candidates have another prior there
(``single.IN_SINGLE``; 1.6e-6 with that of double precision), and 1.3e-5 for the others.
"""

SELF_TEST = """/* Test of {prefix}.c on a machine: a run recorded in Python in double precision, repeated here.
 *
 * Prints the largest difference of an output as a share of the largest torque; the status is 1 beyond the tolerance.
 * On x86-64 with glibc and in double precision the difference is zero.
 */
#include "{prefix}.h"

#include <math.h>
#include <stdio.h>

#define SAMPLES {samples}
#define TOLERANCE {tolerance}
#define LARGEST {largest}

/* {columns} */
static const {real} INPUTS[SAMPLES][{width}] = {{
{inputs}
}};

/* {outputs_columns} */
static const {real} OUTPUTS[SAMPLES][{outputs_width}] = {{
{outputs}
}};

int main(void)
{{
    static {prefix}_Controller controller;
    static unsigned char buffer[{upper}_STATE_SIZE];
    double worst = 0.0;
    {prefix}_init(&controller);
    for (int k = 0; k < SAMPLES; k++) {{
        if (k == SAMPLES / 2) {{ /* a saved state goes on where it was */
            if ({prefix}_save_state(&controller, buffer, sizeof buffer) != {upper}_OK) {{
                return 1;
            }}
            {prefix}_init(&controller);
            if ({prefix}_load_state(&controller, buffer, sizeof buffer) != {upper}_OK) {{
                return 1;
            }}
        }}
        {prefix}_Inputs inputs = {prefix}_default_inputs();
        {prefix}_Output output = {{0}};
{given}
        if ({prefix}_step(&controller, &inputs, &output) != {upper}_OK) {{
            return 1;
        }}
        const double found[] = {{{found}}};
        for (int i = 0; i < {outputs_width}; i++) {{
            const double difference = fabs(found[i] - (double)OUTPUTS[k][i]) / LARGEST;
            if (!(difference <= worst)) {{
                worst = difference; /* also where it is not a number */
            }}
        }}
    }}
    printf("largest difference %.3g of the largest torque, allowed %.3g\\n", worst, TOLERANCE);
    return worst <= TOLERANCE ? 0 : 1;
}}
"""

SAMPLES_TO_FOLLOW = 5.0
"""Time constant of the example's loop where the controller names no inertia, sampling periods."""

EXAMPLE = """/* The controller in the loop of a drive: here an inertia stands for the machine. */
#include "{prefix}.h"

#include <math.h>
#include <stdio.h>

int main(void)
{{
    static {prefix}_Controller controller;
    {real} velocity = {zero};
    {real} given = {zero};
    {prefix}_init(&controller);
    for (int k = 0; k < 500; k++) {{
        const double time = k * (double){upper}_PERIOD;
        {prefix}_Inputs inputs = {prefix}_default_inputs();
        inputs.reference = ({real})(0.2 * sin(time));
        inputs.next_reference = ({real})(0.2 * sin(time + (double){upper}_PERIOD));
        inputs.velocity = velocity; /* from the encoder; NAN where the reading failed */
        inputs.realised_torque = given; /* in the last period: of a drive that may saturate */
        {prefix}_Output output;
        if ({prefix}_step(&controller, &inputs, &output) != {upper}_OK) {{
            return 1; /* an input was not finite: keep the last torque, or brake */
        }}
        /* output.torque goes to the drive for the coming period */
        given = output.torque;
        velocity += {upper}_PERIOD * given / ({real}){inertia};
        if (k % 100 == 99) {{
            printf("%5.2f s: %8.4f of %8.4f rad/s\\n", time, (double)velocity, (double)inputs.reference);
        }}
    }}
    return 0;
}}
"""


def self_test(export: Export) -> str:
    """Return a program that repeats a recorded run."""
    recording, names = export.recording, export.input_names
    outputs = [name for name, _ in export.output.fields]
    torques = recording.outputs[np.isfinite(recording.outputs)]
    tolerance = TOLERANCE[export.single]
    return SELF_TEST.format(
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
    return EXAMPLE.format(
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
