"""Other machines: the exported program under emulation, and objects for processors of drives."""

import re
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.export.driver import build, found, in_python, random_inputs, run, write_sources
from benchmarks.export.rows import Row, skipped
from benchmarks.export.variants import SEED, adaptive, everything

WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-pedantic", "-Werror")
CLOSENESS = 1e-11
"""Largest difference to Python of any torque, over the largest torque."""

LARGEST = {"code and constants, bytes": 20_000, "state, bytes": 4096, "stack of a step, bytes": 2048, "lines": 4000}
"""Targets of the adaptive controller on a Cortex-M7, in double."""

ALLOWED = {"exp", "expm1", "log", "pow", "sqrt", "memcpy", "memset"}
EMULATED = {
    "x86_64": ("x86_64-linux-musl", ""),
    "aarch64": ("aarch64-linux-musl", "qemu-aarch64"),
    "ARMv7": ("arm-linux-musleabihf", "qemu-arm"),
    "riscv64": ("riscv64-linux-musl", "qemu-riscv64"),
}


class Processor(NamedTuple):
    """A processor for which an object is compiled, and how."""

    name: str
    command: tuple[str, ...]
    runtime: str


ARM = ("arm-none-eabi-gcc", "-mthumb", "-mfloat-abi=hard")
PROCESSORS = (
    Processor("Cortex-M7, double", (*ARM, "-mcpu=cortex-m7", "-mfpu=fpv5-d16"), "__aeabi_"),
    Processor("Cortex-M4F, double in software", (*ARM, "-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16"), "__aeabi_"),
    Processor("Cortex-M4F, single", (*ARM, "-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16"), "__aeabi_"),
    Processor("rv32imafdc, double", (sys.executable, "-m", "ziglang", "cc", "-target", "riscv32-linux-musl"), "__"),
)


def zig() -> list[str] | None:
    """Return the command of the cross compiler from the package index; none where it is not installed."""
    return [sys.executable, "-m", "ziglang", "cc"] if find_spec("ziglang") else None


def emulated(samples: int) -> list[Row]:
    """Run the adaptive controller, by direction and with a delay, on other machines with another libm."""
    target = f"{CLOSENESS:g} of the torque"
    rows = []
    maker = lambda: adaptive("directions", 1.5, 0.004)  # noqa: E731
    inputs = random_inputs(maker(), samples, SEED)
    expected = in_python(maker(), inputs)
    with tempfile.TemporaryDirectory() as folder:
        write_sources(maker(), Path(folder))
        for name, (triple, emulator) in EMULATED.items():
            what = f"random inputs, musl on {name}"
            command = zig()
            if command is None or (emulator and not found(emulator)):
                rows.append(skipped(what, "ziglang is not installed" if command is None else f"no {emulator}", target))
                continue
            try:
                flags = ("-std=c99", "-O2", "-ffp-contract=off", "-static", "-target", triple)
                built = build(Path(folder), [*command, *flags], out=name)
                outputs, _, _ = run([*([emulator] if emulator else []), built], inputs)
            except (ArithmeticError, OSError) as error:
                rows.append(Row(what, f"fails: {str(error)[:80]}", target, False))
                continue
            worst = float(np.max(np.abs(outputs[:, 0] - expected[:, 0])) / np.max(np.abs(expected[:, 0])))
            rows.append(Row(what, f"{worst:.2g}", target, worst <= CLOSENESS))
    return rows


def objects() -> list[Row]:
    """Compile objects with all warnings; list their size and what they need from elsewhere."""
    return [row for processor in PROCESSORS for row in _object(processor)]


def _object(processor: Processor) -> list[Row]:
    what = f"object for {processor.name}"
    if not found(processor.command[0]) or (processor.command[0] == sys.executable and zig() is None):
        return [skipped(what, f"no {processor.command[0]}", "no warning")]
    with tempfile.TemporaryDirectory() as folder:
        said = _compile(processor, Path(folder), adaptive("offset", 0.0, 0.0))
        if said:
            return [Row(what, f"says {said[:100]!r}", "no warning", False)]
        rows = [Row(what, "compiles silently", "no warning", True), *_needs(processor, Path(folder))]
        size = _size(processor, Path(folder))
        if size is None:
            return rows
        rows.append(Row("  size", "{} bytes of code and constants, {} of globals".format(*size)))
    return rows


MEMBERS = {"a joint with gravity": lambda: adaptive("gravity", 0.0, 0.0), "all that can be learnt": everything}


def sizes() -> list[Row]:
    """Compile the adaptive controller for a Cortex-M7; list code, state, stack and lines."""
    processor = PROCESSORS[0]
    if not found(processor.command[0]):
        return [skipped("sizes", f"no {processor.command[0]}", "20 kB, 4 kB, 2 kB")]
    rows = []
    for name, maker in MEMBERS.items():
        with tempfile.TemporaryDirectory() as folder:
            _compile(processor, Path(folder), maker())
            size = _size(processor, Path(folder)) or (0, 0)
            measured = [size[0], _state(processor, Path(folder)), _stack(Path(folder))]
            measured.append(sum(len((Path(folder) / f"drive.{end}").read_text().splitlines()) for end in "ch"))
        rows += [
            Row(f"{name}: {what}", str(value), f"at most {most}", value <= most)
            for (what, most), value in zip(LARGEST.items(), measured, strict=True)
        ]
    return rows


def _state(processor: Processor, folder: Path) -> int:
    """Return the bytes of a controller in memory."""
    (folder / "state.c").write_text('#include "drive.h"\ndrive_Controller controller;\n')
    subprocess.run([*processor.command, "-fno-common", "-c", "state.c", "-o", "drive.o"], cwd=folder, check=True)
    sizes = _size(processor, folder)
    return sizes[1] if sizes else 0


def _stack(folder: Path) -> int:
    """Return the bytes of a step's frame and of the largest one of what is not inlined in it."""
    lines = (line.split("\t") for line in (folder / "drive.su").read_text().splitlines())
    frames = {name.rpartition(":")[2]: int(size) for name, size, _ in lines}
    return frames["drive_step"] + max(size for name, size in frames.items() if not name.startswith("drive_"))


def unreached() -> list[Row]:
    """Run the controller with all that can be learnt over wild inputs; count the lines of its kernels never reached."""
    if not (found("gcc") and found("gcov")):
        return [skipped("unreached lines", "no gcov", "0")]
    inputs = random_inputs(everything(), 3000, SEED)
    rng = np.random.default_rng(SEED)
    wild = rng.random(inputs.shape) < 0.02
    wild[:, [0, 3, 6, 8]] &= rng.random((len(inputs), 4)) < 0.5
    inputs[wild] = rng.choice([1e300, -1e300, 1e-300], size=int(wild.sum()))
    inputs[:, 8] = np.abs(inputs[:, 8])
    inputs[::7, [0, 2, 9, 10]] = 0.0
    inputs[1000:1400, [0, 2, 9, 10]] = 0.0
    with tempfile.TemporaryDirectory() as folder:
        write_sources(everything(), Path(folder))
        built = build(Path(folder), ["gcc", "-std=c99", "-O0", "--coverage"])
        subprocess.run([built, str(len(inputs)), "1"], input=inputs.tobytes(), capture_output=True, check=True)
        subprocess.run(["gcov", "driver-drive.c"], cwd=folder, capture_output=True, check=True)
        lines = (Path(folder) / "drive.c.gcov").read_text().splitlines()
    last = next(place for place, line in enumerate(lines) if "write_physical(" in line)
    counts = [line.split(":", 2) for line in lines[:last]]
    reachable = [line for line in counts if line[0].strip() != "-"]
    never = [line for line in reachable if line[0].strip() == "#####"]
    rows = [Row("lines of the kernels never reached", f"{len(never)} of {len(reachable)}", "0", not never)]
    return rows + [Row(f"  line {number.strip()}", text.strip()) for _, number, text in never]


def _compile(processor: Processor, folder: Path, controller: Any) -> str:
    """Write the sources and compile them into an object; return what the compiler says."""
    single = processor.name.endswith("single")
    write_sources(controller, folder, single)
    line = [*processor.command, "-std=c99", "-Os", "-ffp-contract=off", *WARNINGS, "-c", "drive.c", "-o", "drive.o"]
    line += ["-fstack-usage"] if "arm" in processor.command[0] else []
    done = subprocess.run(line, cwd=folder, capture_output=True, text=True, check=False)
    return done.stderr.strip() or ("exits with an error" if done.returncode else "")


def _tool(processor: Processor, name: str, folder: Path, *arguments: str) -> str:
    """Return what a tool for objects prints of the object; nothing where it is not installed."""
    tool = f"{'arm-none-eabi-' if processor.command[0].startswith('arm') else ''}{name}"
    if not found(tool):
        return ""
    line = [tool, *arguments, "drive.o"]
    return subprocess.run(line, cwd=folder, capture_output=True, text=True, check=False).stdout


def _size(processor: Processor, folder: Path) -> tuple[int, int] | None:
    """Return the bytes of code and constants, and of globals."""
    numbers = re.findall(r"^\s*(\d+)\s+(\d+)\s+(\d+)", _tool(processor, "size", folder), re.MULTILINE)
    if not numbers:
        return None
    text, data, bss = (int(number) for number in numbers[0])
    return text, data + bss


def _needs(processor: Processor, folder: Path) -> list[Row]:
    """List what the object needs from elsewhere."""
    needed = {line.split()[-1] for line in _tool(processor, "nm", folder, "-u").splitlines() if line.strip()}
    if not needed:
        return []
    library = {f"{name}f" for name in ALLOWED} | ALLOWED
    own = sorted(needed - library)
    met = all(name.startswith(processor.runtime) for name in own)  # arithmetic that the processor does not have
    rows = [Row("  undefined symbols", ", ".join(sorted(needed & library)), "libm, memcpy, memset", met)]
    return rows + ([Row("  of the compiler's own runtime", ", ".join(own))] if own else [])


def sanitized(samples: int) -> list[Row]:
    """Run under the sanitizers for addresses and undefined behaviour."""
    what, target = "sanitizers: address, undefined", "silent"
    if not found("gcc"):
        return [skipped(what, "no gcc", target)]
    maker = lambda: adaptive("directions", 1.5, 0.004)  # noqa: E731
    inputs = random_inputs(maker(), samples, SEED)
    with tempfile.TemporaryDirectory() as folder:
        write_sources(maker(), Path(folder))
        flags = ("-std=c99", "-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
        try:
            outputs, _, _ = run([build(Path(folder), ["gcc", *flags])], inputs)
        except ArithmeticError as error:
            return [Row(what, str(error)[:100], target, False)]
    same = outputs.tobytes() == in_python(maker(), inputs).tobytes()
    return [Row(what, f"silent over {samples} samples, {'same' if same else 'other'} bits", target, same)]
