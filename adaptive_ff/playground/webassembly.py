"""The closed loop compiled to WebAssembly, from the text in C that kernels become on this machine."""

import hashlib
import importlib.util
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from adaptive_ff.adaptive.estimates import write_deviations
from adaptive_ff.errors import InputError
from adaptive_ff.simulation.loop import run_plain
from controllers.kernels.cache_directory import cache_directory
from controllers.kernels.compiler import FLAGS, ZIG_COMPILER, compile_files
from controllers.kernels.entry import entry_text, file_text, library_unit
from controllers.kernels.types import type_of

TARGET = ("-target", "wasm32-wasi", "-mexec-model=reactor", "-s", "-Wl,--export-dynamic,--export=__heap_base")
"""Flags beside those of kernels: the C library is linked, and nothing of an operating system is asked for."""


def run_with_deviations(
    parameters: Any, state: Any, setup: Any, position: Any, stop: int, record: Any, slopes: Any, row: Any
) -> tuple[Any, Any]:
    """Run the loop from a position to a sample, and write how far the estimates may be off there in a row."""
    state, position = run_plain(parameters, state, setup, position, stop, record)
    write_deviations(parameters, state, slopes, row)
    return state, position


def webassembly(runs: Mapping[str, tuple[Any, ...]]) -> bytes:
    """Return a module with a run for each kind of arguments, ``void name(arguments, result)``.

    Given are the arguments of :func:`run_plain`, or of :func:`run_with_deviations`, by name.
    """
    if importlib.util.find_spec("ziglang") is None:
        raise InputError("a page takes the package ziglang: pip install ziglang")
    unit = library_unit()
    texts = []
    for name, arguments in runs.items():
        kernel = run_plain if len(arguments) == 6 else run_with_deviations
        texts.append(entry_text(unit, kernel, tuple(map(type_of, arguments)), name)[0])
    text = file_text(unit, texts)
    flags = [*TARGET, *(flag for flag in FLAGS if flag != "-fPIC")]
    module = cache_directory() / f"playground-{hashlib.sha256(f'{flags} {text}'.encode()).hexdigest()[:16]}.wasm"
    if not module.exists():
        with tempfile.TemporaryDirectory(dir=cache_directory()) as place:
            source = Path(place, "playground.c")
            source.write_text(text, encoding="ascii")
            compile_files([source], module, flags, ZIG_COMPILER)
    return module.read_bytes()
