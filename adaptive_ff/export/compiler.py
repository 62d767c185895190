"""The C compiler of this machine."""

import os
import shlex
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from adaptive_ff.errors import InputError

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden")
"""Flags of shared libraries; without contraction the bits are those of Python."""


def compiler() -> list[str] | None:
    """Return the command of the C compiler, that of the variable CC if it is set; none where there is none."""
    command = shlex.split(os.environ.get("CC", "cc"))
    return command if command and shutil.which(command[0]) else None


def compile_library(sources: Sequence[Path], library: Path, flags: Sequence[str] = ()) -> None:
    """Compile sources into a shared library.

    Raises
    ------
    InputError
        There is no C compiler, or it fails; the message has its first line.
    """
    command = compiler()
    if command is None:
        raise InputError("C compiler = cc is not found: install one, or name it in the variable CC")
    line = [*command, *FLAGS, *flags, *map(str, sources), "-o", str(library), "-lm"]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    if done.returncode:
        first = (done.stderr.strip() or "no message").splitlines()[0]
        raise InputError(f"C compiler = {command[0]} fails: {first}")
