"""Exported controllers on processors of drives: compiled, and run under emulation that counts instructions.

The machine of an Arm executes one instruction in a nanosecond of its own time, which its timer of 25 MHz shows to 40
instructions; RISC-V counts them itself. Neither knows caches and wait states: the count is of instructions, not of
cycles. The stack is what has been overwritten of a pattern.
"""

import re
import shutil
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from adaptive_ff import load_scenario
from adaptive_ff.comparison.registry import make_for_machine
from benchmarks.export.project import STRICT, exported, run

TABLES = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
CHIPS: dict[str, dict[str, Any]] = {name: TABLES[chip["kind"]] | chip for name, chip in TABLES["chips"].items()}
STEPS = 3000


def measured(name: str, kind: str) -> dict[str, float]:
    """Return bytes of code and constants, of the controller, and of the stack of a step, and its most instructions."""
    chip = CHIPS[name]
    command, emulator = [*chip["command"], *chip["flags"]], [*chip["emulator"], chip["machine"]]
    if not (shutil.which(command[0]) and shutil.which(emulator[0])):
        raise ValueError(f"{command[0]} or {emulator[0]} is not installed")
    controller, _, more = kind.partition(", ")
    scenario = load_scenario().modified(**({"adaptation": TABLES["all"]} if more else {}))
    with exported(make_for_machine(scenario, controller), single=chip["single"]) as folder:
        (folder / "ram.c").write_text('#include "drive.h"\ndrive_Controller controller;\n')
        (flash, _), (_, ram) = (_compiled(folder, command, name) for name in ("drive", "ram"))
        version = run(folder, command[0], "-dumpfullversion").strip()
        for part in ("chip.c", "layout.ld"):
            shutil.copy(Path(__file__).with_name(part), folder)
        defined = (f"-DREAL={'float' if chip['single'] else 'double'}", f"-DSTEPS={STEPS}")
        linked = (*chip["linked"], "-Wl,--gc-sections", "-lm", "-o", "chip.elf")
        run(folder, *command, *STRICT, "-Os", "-ffunction-sections", *defined, "chip.c", "drive.o", *linked)
        output = ("-chardev", "stdio,id=out", "-semihosting-config", "enable=on,chardev=out")
        quiet = ("-kernel", "chip.elf", *output, "-display", "none", "-monitor", "none", "-serial", "none")
        instructions, stack = map(float, run(folder, *emulator, *quiet, "-icount", "shift=0").split())
        sizes = {"flash": flash, "ram": ram, "gcc": float(version.rpartition(".")[0])}
        return sizes | {"instructions": instructions, "stack": stack}


def _compiled(folder: Path, command: Sequence[str], name: str) -> tuple[float, float]:
    """Compile an object; return the bytes of its code and constants, and of its globals."""
    run(folder, *command, *STRICT, "-Os", "-ffunction-sections", "-fno-common", "-c", f"{name}.c", "-o", f"{name}.o")
    printed = run(folder, command[0].replace("gcc", "size"), f"{name}.o")
    text, data, bss = map(float, re.findall(r"^\s*(\d+)\s+(\d+)\s+(\d+)", printed, re.M)[0])
    return text, data + bss
