"""Exported controllers on processors of drives: compiled, and run under emulation that counts instructions.

The machine of an Arm executes one instruction in a nanosecond of its own time, which its timer of 25 MHz shows to 40
instructions; RISC-V counts them itself. Neither knows caches and wait states: the count is of instructions, not of
cycles. The stack is what has been overwritten of a pattern.
"""

import shutil
from pathlib import Path
from typing import NamedTuple

from adaptive_ff import load_scenario
from adaptive_ff.comparison.registry import make_controller
from benchmarks.export.project import STRICT, compiled, exported, run

KINDS = ("pi", "fixed", "adaptive")
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

MAIN = """#include "drive.h"
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
static drive_Controller controller;
#ifdef __riscv
#define BOTTOM ((uint8_t *)0x80300000)
#define STACK(top) __asm volatile("mv %0, sp" : "=r"(top))
#define MASK 0xFFFFFFFFu
#define EACH 1u
static uint32_t count(void)
{
    uint32_t read;
    __asm volatile("csrr %0, minstret" : "=r"(read));
    return read;
}
#else
#define REGISTER(place) (*(volatile uint32_t *)(place))
#define BOTTOM ((uint8_t *)0x20200000)
#define STACK(top) __asm volatile("mov %0, sp" : "=r"(top))
#define MASK 0xFFFFFFu
#define EACH 40u
static uint32_t count(void) { return 0u - REGISTER(0xE000E018); }
int main(void);
void reset(void)
{
    REGISTER(0xE000ED88) |= 0xFu << 20;
    __asm volatile("dsb\\n isb");
    REGISTER(0xE000E014) = MASK;
    REGISTER(0xE000E018) = 0u;
    REGISTER(0xE000E010) = 5u;
    extern void initialise_monitor_handles(void);
    initialise_monitor_handles();
    exit(main());
}
__attribute__((section(".vectors"), used)) static void *const vectors[] = {(void *)0x20300000, (void *)reset};
#endif
int main(void)
{
    uint32_t most = 0, here = 0;
    uint8_t *top, *low = BOTTOM;
    STACK(top);
    drive_init(&controller);
    while (low < top - 128) *low++ = 0xA5u; /* below what the loop itself takes */
    for (uint32_t k = 0; k < STEPS; k++) {
        drive_Inputs inputs = drive_default_inputs();
        drive_Output output;
        inputs.reference = (REAL)(0.3 * sin(0.02 * k));
        inputs.next_reference = (REAL)(0.3 * sin(0.02 * (k + 1)));
        inputs.velocity = (REAL)(0.29 * sin(0.02 * k - 0.05));
        here = count();
        if (drive_step(&controller, &inputs, &output) != DRIVE_OK) return 1;
        here = (count() - here) & MASK;
        if (here > most) most = here;
    }
    for (low = BOTTOM; *low == 0xA5u;) low++;
    printf("%u %u\\n", (unsigned)(EACH * most), (unsigned)(top - low));
    return 0;
}
"""

LAYOUT = """ENTRY(reset)
SECTIONS
{
    .text 0x0 : { KEEP(*(.vectors)) *(.text*) *(.rodata*) *(.ARM.ex*) }
    .data 0x20000000 : { *(.data*) }
    .bss : { *(.bss*) *(COMMON) }
    end = .;
}
"""

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
    with exported(make_controller(load_scenario(), kind), single=chip.single) as folder:
        flash, ram = compiled(folder, chip.command, "-ffunction-sections")
        version = run(folder, chip.command[0], "-dumpfullversion").strip()
        figures = {"flash": float(flash), "ram": float(ram), "gcc": float(version.rpartition(".")[0])}
        return figures | _emulated(chip, folder)


def _emulated(chip: Chip, folder: Path) -> dict[str, float]:
    real = "float" if chip.single else "double"
    (folder / "main.c").write_text(MAIN.replace("REAL", real).replace("STEPS", str(STEPS)))
    (folder / "layout.ld").write_text(LAYOUT)
    linked = (*LINKED[chip.machine[0]], "-Wl,--gc-sections", "-lm", "-o", "chip.elf")
    run(folder, *chip.command, *STRICT, "-Os", "-ffunction-sections", "main.c", "drive.o", *linked)
    output = ("-chardev", "stdio,id=out", "-semihosting-config", "enable=on,chardev=out")
    quiet = ("-kernel", "chip.elf", *output, "-display", "none", "-monitor", "none", "-serial", "none")
    instructions, stack = map(float, run(folder, *chip.machine, *quiet, "-icount", "shift=0").split())
    return {"instructions": instructions, "stack": stack}
