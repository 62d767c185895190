"""The C compiler of this machine."""

import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path

RUNTIME = "exp expm1 log log1p pow sin cos tan asin acos atan atan2 sinh cosh tanh asinh"
"""Functions whose bits are those of the library at run time, as Python's are: compilers may not replace them."""

FLAGS = (
    "-std=c99",
    "-O2",
    "-fno-gcse",  # which is a fifth of the compiler's time and makes no kernel faster
    "-ffp-contract=off",
    "-fwrapv",
    "-fno-strict-aliasing",
    "-fPIC",
    "-fvisibility=hidden",
    *(f"-fno-builtin-{name}" for name in RUNTIME.split()),
)
"""Flags of kernels: products and sums stay as they are, integers wrap around."""

ZIG_COMPILER = (sys.executable, "-m", "ziglang", "cc")
"""The compiler of the package ``ziglang``, which compiles for other machines as well."""

ZIG = ("-mcpu=baseline", "-fno-sanitize=undefined")
"""Further flags of zig: no instructions that other machines lack."""

SUFFIX = ".dll" if sys.platform == "win32" else ".so"
"""End of the names of libraries."""


class NoCompiler(RuntimeError):
    """There is no C compiler, or it fails; one line says what to do."""


def compiler() -> tuple[str, ...] | None:
    """Return the command of a C compiler that works: that of CC, else one that is found, or zig's."""
    return _compiler(os.environ.get("CC", ""))


@cache
def _compiler(given: str) -> tuple[str, ...] | None:
    for command in [shlex.split(given)] if given else [["cc"], ["gcc"], ["clang"]]:
        if shutil.which(command[0]) and _works(command):
            return tuple(command)
    if not given and importlib.util.find_spec("ziglang") is not None:
        return ZIG_COMPILER
    return None


def _works(command: Sequence[str]) -> bool:
    """Tell whether a command compiles: on some systems one is there that only says what could be installed."""
    if sys.platform == "darwin" and command[0] in ("cc", "gcc", "clang"):
        chosen = subprocess.run(["xcode-select", "-p"], capture_output=True, check=False)
        if chosen.returncode:  # else the call would open a dialogue
            return False
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder, "works.c")
        source.write_text("#include <math.h>\ndouble f(double x) { return exp(x); }\n", encoding="ascii")
        line = [*command, "-std=c99", "-c", str(source), "-o", str(Path(folder, "works.o"))]
        try:
            return subprocess.run(line, capture_output=True, check=False).returncode == 0
        except OSError:
            return False


def compile_files(
    sources: Sequence[Path], target: Path, flags: Sequence[str], command: Sequence[str] | None = None
) -> None:
    """Compile sources to one file that appears at once and complete, whoever else makes it at the same time.

    The command is that of :func:`compiler` unless another is given. Further flags, such as those of sanitizers, stand
    in the variable ``ADAPTIVE_FF_CFLAGS``.
    """
    command = compiler() if command is None else command
    if command is None:
        raise NoCompiler("no C compiler is found: install one, name it in the variable CC, or pip install ziglang")
    extra = [*(ZIG if "ziglang" in command else ()), *shlex.split(os.environ.get("ADAPTIVE_FF_CFLAGS", ""))]
    part = target.with_name(f"{target.name}.{os.getpid()}.part")
    line = [*command, *flags, *extra, *map(str, sources), "-o", str(part), *([] if "-nostdlib" in flags else ["-lm"])]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    if done.returncode:
        part.unlink(missing_ok=True)
        lines = (done.stderr.strip() or "no message").splitlines()
        first = next((each for each in lines if "error" in each), lines[0])
        raise NoCompiler(f"C compiler = {command[0]} fails: {first}")
    os.replace(part, target)
