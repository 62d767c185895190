"""Exported controllers on processors of drives: compiled, and run under emulation that counts instructions.

The machine of an Arm executes one instruction in a nanosecond of its own time, which its timer of 25 MHz shows to 40
instructions; RISC-V counts them itself. Neither knows caches and wait states: the count is of instructions, not of
cycles. The stack is what has been overwritten of a pattern.
"""

import re
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from adaptive_ff import load_scenario
from adaptive_ff.comparison.registry import make_controller
from benchmarks.export.project import STRICT, exported, run

LEARNS_ALL = {  # table ``[adaptation]`` of ``adaptive, all``
    "identify": "directions_and_gravity",
    "ripple_periods": [0.02],
    "position_periods": [0.3],
    "position_hats": 5,
    "load_friction": True,
}
ARM, RISC = ("arm-none-eabi-gcc", "-mthumb", "-mfloat-abi=hard"), ("riscv64-unknown-elf-gcc", "--specs=picolibc.specs")
STEPS = 3000


class Chip(NamedTuple):
    """A processor: its compiler, the emulator and the machine that stand for it, and the precision."""

    command: tuple[str, ...]
    machine: tuple[str, ...]
    single: bool


M4, M7 = (*ARM, "-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16"), (*ARM, "-mcpu=cortex-m7", "-mfpu=fpv5-d16")
MPS2, VIRT = ("qemu-system-arm", "-machine"), ("qemu-system-riscv32", "-machine", "virt", "-bios", "none")
CHIPS = {
    "Cortex-M4F, single precision": Chip(M4, (*MPS2, "mps2-an386"), True),
    "Cortex-M4F, double in software": Chip(M4, (*MPS2, "mps2-an386"), False),
    "Cortex-M7, single precision": Chip(M7, (*MPS2, "mps2-an500"), True),
    "Cortex-M7, double precision": Chip(M7, (*MPS2, "mps2-an500"), False),
    "rv32imafc, single precision": Chip((*RISC, "-march=rv32imafc", "-mabi=ilp32f"), VIRT, True),
    "rv32imafdc, double precision": Chip((*RISC, "-march=rv32imafdc", "-mabi=ilp32d"), VIRT, False),
}

PLACES = {"flash": 0x80000000, "flash_size": 0x200000, "ram": 0x80200000, "ram_size": 0x200000, "stack_size": 0x1000}
LINKED = {
    "qemu-system-arm": ("-T", "layout.ld", "-nostartfiles", "--specs=rdimon.specs"),
    "qemu-system-riscv32": (
        *("--oslib=semihost", "--crt0=semihost"),
        *(f"-Wl,--defsym=__{name}={value:#x}" for name, value in PLACES.items()),
    ),
}
"""How the program of an emulator is linked."""


def measured(chip: Chip, kind: str) -> dict[str, float]:
    """Return bytes of code and constants, of the controller, and of the stack of a step, and its most instructions."""
    if not (shutil.which(chip.command[0]) and shutil.which(chip.machine[0])):
        raise ValueError(f"{chip.command[0]} or {chip.machine[0]} is not installed")
    name, _, more = kind.partition(", ")
    scenario = load_scenario().modified(adaptation=LEARNS_ALL) if more else load_scenario()
    with exported(make_controller(scenario, name), single=chip.single) as folder:
        (folder / "ram.c").write_text('#include "drive.h"\ndrive_Controller controller;\n')
        (flash, _), (_, ram) = (_compiled(folder, chip.command, name) for name in ("drive", "ram"))
        version = run(folder, chip.command[0], "-dumpfullversion").strip()
        return {"flash": flash, "ram": ram, "gcc": float(version.rpartition(".")[0]), **_emulated(chip, folder)}


def _compiled(folder: Path, command: Sequence[str], name: str) -> tuple[float, float]:
    """Compile an object; return the bytes of its code and constants, and of its globals."""
    run(folder, *command, *STRICT, "-Os", "-ffunction-sections", "-fno-common", "-c", f"{name}.c", "-o", f"{name}.o")
    printed = run(folder, command[0].replace("gcc", "size"), f"{name}.o")
    text, data, bss = map(float, re.findall(r"^\s*(\d+)\s+(\d+)\s+(\d+)", printed, re.M)[0])
    return text, data + bss


def _emulated(chip: Chip, folder: Path) -> dict[str, float]:
    for name in ("chip.c", "layout.ld"):
        shutil.copy(Path(__file__).with_name(name), folder)
    defined = (f"-DREAL={'float' if chip.single else 'double'}", f"-DSTEPS={STEPS}")
    linked = (*LINKED[chip.machine[0]], "-Wl,--gc-sections", "-lm", "-o", "chip.elf")
    run(folder, *chip.command, *STRICT, "-Os", "-ffunction-sections", *defined, "chip.c", "drive.o", *linked)
    output = ("-chardev", "stdio,id=out", "-semihosting-config", "enable=on,chardev=out")
    quiet = ("-kernel", "chip.elf", *output, "-display", "none", "-monitor", "none", "-serial", "none")
    instructions, stack = map(float, run(folder, *chip.machine, *quiet, "-icount", "shift=0").split())
    return {"instructions": instructions, "stack": stack}
