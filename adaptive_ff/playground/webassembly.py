"""The closed loop compiled to WebAssembly, and what it is called with.

The module is made from the text in C that kernels become on this machine. Arguments are bytes that a page puts into its
memory. A struct of kernels lies there as on this machine (:mod:`controllers.kernels.memory`): a pointer of four bytes
is followed by four that fill up to the size next to it. So the numbers are those that this package computed, none is
computed anew; only addresses of arrays are written by the page.
"""

import hashlib
import importlib.util
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from adaptive_ff.adaptive.estimates import write_deviations
from adaptive_ff.errors import InputError
from adaptive_ff.simulation.loop import run_plain
from controllers.kernels.compiler import FLAGS, ZIG_COMPILER, compile_files
from controllers.kernels.entry import entry_text, file_text, library_unit
from controllers.kernels.library import cache_directory
from controllers.kernels.memory import NUMBERS, record_type
from controllers.kernels.types import type_of

Way = tuple[str | int, ...]
Json = dict[str, Any]

SERIES: dict[Way, str] = {(2, "reference"): "reference", (2, "noise"): "noise"}
"""Arrays of the arguments that the page fills by motion and noise."""

STATE, POSITION, STOP = 1, 3, 4
"""Places of the controller's state, of that of the loop, and of the last sample; what follows is room for results."""

RUNNING = (STATE, POSITION)
"""What a run changes and the next one begins anew."""

TARGET = ("-target", "wasm32-wasi", "-mexec-model=reactor")
LINKED = (*TARGET, "-nostdlib", "-s", "-Wl,--no-entry,--export-dynamic,--export=__heap_base,--import-symbols")
"""Flags without a C library, which zig would compile first: functions such as ``exp`` are imported from the browser."""


class Leaf(NamedTuple):
    """A number or an array in the arguments, and how many bytes after their begin it lies."""

    offset: int
    value: Any


class Blob:
    """Bytes of many arrays."""

    def __init__(self) -> None:
        self.parts: list[bytes] = []
        self._size, self._known = 0, dict[bytes, int]()

    def add(self, content: bytes) -> int:
        """Add some bytes where they are new; return where they begin, at a multiple of eight."""
        if content not in self._known:
            padded = content + bytes(-len(content) % 8)
            self.parts.append(padded)
            self._known[content] = self._size
            self._size += len(padded)
        return self._known[content]


def leaves(value: Any) -> dict[Way, Leaf]:
    """Return all numbers and arrays of nested tuples by the names and places that lead to them."""
    return dict(_leaves(value, record_type(value), 0, ()))


def _leaves(value: Any, layout: np.dtype[Any], offset: int, path: Way) -> Iterator[tuple[Way, Leaf]]:
    if not isinstance(value, tuple):
        yield path, Leaf(offset, value)
        return
    names = getattr(value, "_fields", range(len(value)))
    for place, (name, item) in enumerate(zip(names, value, strict=True)):
        kind, start = layout.fields[f"f{place}"][:2]  # type: ignore[index]
        yield from _leaves(item, kind, offset + start, (*path, name))


def kind_of(value: Any) -> str:
    """Return the letter of a number's type, or of the elements of an array."""
    return next(letter for letter, kind in NUMBERS.items() if np.asarray(value).dtype == kind)


def image(arguments: tuple[Any, ...], blob: Blob) -> Json:
    """Return what a page needs to make the arguments of a compiled run: numbers, arrays, and where things lie."""
    size, found = record_type(arguments).itemsize, leaves(arguments)
    head, arrays = bytearray(size), []
    for path, leaf in found.items():
        if isinstance(leaf.value, np.ndarray):
            source = SERIES.get(path) or (blob.add(leaf.value.tobytes()) if leaf.value.any() else None)
            kind, running = kind_of(leaf.value), path[0] in RUNNING
            arrays.append([leaf.offset, leaf.value.shape, kind, source, running, "/".join(map(str, path))])
        else:
            number = np.array(leaf.value, NUMBERS[kind_of(leaf.value)]).tobytes()
            head[leaf.offset : leaf.offset + len(number)] = number
    fields = record_type(arguments).fields
    given = record_type((arguments[STATE], arguments[POSITION])).fields
    assert fields is not None
    assert given is not None
    places = [fields[f"f{place}"][1] for place in range(len(arguments))]
    position = {path[1]: leaf.offset for path, leaf in found.items() if path[0] == POSITION and len(path) == 2}
    return {
        "size": size,
        "head": blob.add(bytes(head)),
        "arrays": arrays,
        "stop": places[STOP],
        "state": [given["f0"][1], places[STATE], given["f0"][0].itemsize],
        "position": [given["f1"][1], places[POSITION], given["f1"][0].itemsize],
        "restart_places": [position["sample"], position["phase"], position["acting"]],
    }


def changes(stops: list[tuple[Any, ...]], blob: Blob) -> Json:
    """Return the numbers and arrays in which the arguments of a run differ between the stops of a slider."""
    layout = record_type(stops[0])
    found = [dict(_leaves(arguments, layout, 0, ())) for arguments in stops]
    numbers, arrays = [], []
    for path, first in found[0].items():
        if path in SERIES or int(path[0]) >= STOP:
            continue
        values = [one[path].value for one in found]
        if len({np.asarray(value).tobytes() for value in values}) == 1:
            continue
        if not isinstance(first.value, np.ndarray):
            numbers.append([first.offset, kind_of(first.value), values, path[0] in RUNNING])
        else:
            places = [[value.shape, blob.add(value.tobytes())] for value in values]
            arrays.append([first.offset, places, path[0] in RUNNING])
    return {"numbers": numbers, "arrays": arrays}


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
    flags = [*TARGET, "-c", "-mbulk-memory", *(flag for flag in FLAGS if flag != "-fPIC")]
    key = hashlib.sha256(f"{flags} {LINKED} {text}".encode()).hexdigest()[:16]
    module = cache_directory() / f"playground-{key}.wasm"
    if not module.exists():
        with tempfile.TemporaryDirectory(dir=cache_directory()) as place:
            source, compiled = Path(place, "playground.c"), Path(place, "playground.o")
            source.write_text(text, encoding="ascii")
            compile_files([source], compiled, flags, ZIG_COMPILER)
            compile_files([compiled], module, LINKED, ZIG_COMPILER)
    return module.read_bytes()
