"""A program around an exported controller that steps it over rows of inputs, on this machine or an emulated one."""

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.export.export import Export
from adaptive_ff.export.sample import made_up_inputs
from adaptive_ff.export.source import header, source
from controllers import Inputs

PREFIX = "drive"

DRIVER = """#include "drive.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

/* Arguments: number of rows, repetitions. Rows of doubles on standard input, outputs and the state on standard output;
 * nanoseconds a step on standard error. */
int main(int count, char **arguments)
{
    const int rows = count > 1 ? atoi(arguments[1]) : 0;
    const int repeats = count > 2 ? atoi(arguments[2]) : 1;
    drive_Inputs *inputs = malloc((size_t)rows * sizeof *inputs);
    drive_Output *outputs = malloc((size_t)rows * sizeof *outputs);
    static drive_Controller controller;
    static unsigned char buffer[DRIVE_STATE_SIZE];
    double best = 1e30;
    if (inputs == NULL || outputs == NULL) {
        return 2;
    }
    for (int k = 0; k < rows; k++) {
        double row[FIELDS];
        if (fread(row, sizeof row, 1, stdin) != 1) {
            return 2;
        }
GIVEN
    }
    for (int r = 0; r < repeats; r++) {
        drive_init(&controller);
        const clock_t begin = clock();
        for (int k = 0; k < rows; k++) {
            if (drive_step(&controller, &inputs[k], &outputs[k]) != DRIVE_OK) {
                return 3;
            }
        }
        const double spent = (double)(clock() - begin) / CLOCKS_PER_SEC / rows;
        best = spent < best ? spent : best;
    }
    for (int k = 0; k < rows; k++) {
        const double found[2] = {(double)outputs[k].torque, (double)outputs[k].feedforward};
        fwrite(found, sizeof found, 1, stdout);
    }
    drive_save_state(&controller, buffer, sizeof buffer);
    fwrite(buffer, sizeof buffer, 1, stdout);
    fprintf(stderr, "%.3f", 1e9 * best);
    free(inputs);
    free(outputs);
    return 0;
}
"""


def write_sources(controller: Any, folder: Path, single: bool = False) -> Export:
    """Write a controller's source and the program around it into a folder."""
    export = Export(controller, PREFIX, single)
    real = "float" if single else "double"
    given = "\n".join(f"        inputs[k].{name} = ({real})row[{i}];" for i, name in enumerate(Inputs._fields))
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "drive.h").write_text(header(export))
    (folder / "drive.c").write_text(source(export))
    text = DRIVER.replace("FIELDS", str(len(Inputs._fields))).replace("GIVEN", given)
    (folder / "driver.c").write_text(text)
    return export


def build(folder: Path, command: Sequence[str], out: str = "driver") -> Path:
    """Compile the program with a compiler's command; what it says on failure is the error."""
    done = subprocess.run(
        [*command, "drive.c", "driver.c", "-o", out, "-lm"], cwd=folder, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise ArithmeticError(f"{' '.join(command)}: {done.stderr.strip()[:300]}")
    return folder / out


def run(program: Sequence[str | Path], rows: NDArray[np.float64], repeats: int = 1) -> tuple[Any, bytes, float]:
    """Run the program; return outputs (shape (n, 2)), the state at the end as bytes, and nanoseconds a step."""
    line = [*map(str, program), str(len(rows)), str(repeats)]
    done = subprocess.run(line, input=rows.tobytes(), capture_output=True, check=False)
    if done.returncode:
        raise ArithmeticError(f"{line[0]} ends with {done.returncode}: {done.stderr[:200]!r}")
    size = 16 * len(rows)
    outputs = np.frombuffer(done.stdout[:size]).reshape(len(rows), 2)
    return outputs, done.stdout[size:], float(done.stderr)


def in_python(controller: Any, rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Step the kernels in plain Python over the same rows; return torque and feedforward."""
    controller.run_uncompiled()
    return np.array([controller.step_plain(Inputs(*row)) for row in rows.tolist()])


def random_inputs(controller: Any, samples: int, seed: int) -> NDArray[np.float64]:
    """Return rows of inputs with jitter, lost samples and missing previews."""
    return made_up_inputs(controller.period, samples, seed)


def found(*programs: str) -> bool:
    """Tell whether all programs are on this machine."""
    return all(shutil.which(program) for program in programs)
