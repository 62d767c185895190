"""Named arrays in the file formats that logs come in: CSV, NPZ, MAT, HDF5, Parquet, MCAP and bags.

Each reader takes a path and the wanted names. It returns the shapes of all arrays there are, and those arrays that are
wanted: only these are read into memory.
"""

import importlib
from collections.abc import Callable, Collection, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import is_zipfile

import numpy as np
from numpy.typing import NDArray
from scipy import io

from adaptive_ff.errors import InputError
from adaptive_ff.logs.messages import Read, read_bag, read_mcap
from adaptive_ff.logs.text_tables import read_table, reading

Header = tuple[tuple[int, ...], np.dtype[Any]]
"""Shape and type of an array."""


class Content(NamedTuple):
    """What a file holds: the shape of every array by name (of a column of text, empty), and the wanted arrays."""

    shapes: dict[str, tuple[int, ...]]
    arrays: dict[str, NDArray[Any]]

    def listed(self, names: Collection[str] | None = None) -> str:
        """Return names, by default of all arrays, with shapes of those that hold several; ``none`` for no names."""
        shapes = {name: self.shapes.get(name, ()) for name in (self.shapes if names is None else names)}
        return ", ".join(name + (f" {shape}" if len(shape) > 1 else "") for name, shape in shapes.items()) or "none"


def read_content(path: Path, wanted: Collection[str]) -> Content:
    """Read named arrays from a file, those that there are; its ending tells the format.

    Raises
    ------
    InputError
        The format is not known, the file cannot be read, or the format needs a library that is not installed.
    """
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        hint = HINTS.get(path.suffix.lower(), "")
        raise InputError(f"{path}: the ending {path.suffix!r} is not known; allowed: {', '.join(READERS)}{hint}")
    with reading(path):
        with path.open("rb"):  # where there is none, not every reader says so
            pass
        return Content(*reader(path, wanted))


def is_text(path: Path) -> bool:
    """Tell whether a file is read as a table in text."""
    return READERS.get(path.suffix.lower()) is _read_text


def _read_text(path: Path, wanted: Collection[str]) -> Read:
    names, columns = read_table(path, wanted)
    return dict.fromkeys(names, ()), dict(columns)


def _read_npz(path: Path, wanted: Collection[str]) -> Read:
    if not is_zipfile(path):  # numpy takes it for pickled objects, and advises to trust it
        raise InputError(f"{path}: cannot be read: it is no NPZ archive")
    with np.load(path, allow_pickle=False) as archive:
        headers = {name: _npz_header(archive, name) for name in archive.files}
        for name in wanted:
            if name in headers and headers[name][1].hasobject:
                raise InputError(f"{path}: {name} holds Python objects; it must hold numbers")
        return _series(headers, wanted, archive)


def _npz_header(archive: Any, name: str) -> Header:
    """Read shape and type of a member from its header alone."""
    with archive.zip.open(name if name in archive.zip.namelist() else f"{name}.npy") as stream:
        major = np.lib.format.read_magic(stream)[0]
        read = np.lib.format.read_array_header_1_0 if major == 1 else np.lib.format.read_array_header_2_0
        shape, _, kind = read(stream)
        return shape, kind


def _series(headers: Mapping[str, Header], wanted: Collection[str], arrays: Mapping[str, Any]) -> Read:
    """Return the shapes of all series, by shape and type of the arrays, and the wanted ones, each array read once.

    Fields of structured arrays are series of their own: ARRAY.FIELD.
    """
    places = {
        name if field is None else f"{name}.{field}": (name, field, (*shape, *(kind[field].shape if field else ())))
        for name, (shape, kind) in headers.items()
        for field in kind.names or (None,)
    }
    found = {key: places[key] for key in wanted if key in places}
    read = {name: arrays[name][()] for name in dict.fromkeys(name for name, _, _ in found.values())}
    return (
        {key: shape for key, (_, _, shape) in places.items()},
        {key: read[name] if field is None else read[name][field] for key, (name, field, _) in found.items()},
    )


def _read_mat(path: Path, wanted: Collection[str]) -> Read:
    """Read a MAT file; members of a struct are named STRUCT.MEMBER, of an array of structs STRUCT.0.MEMBER.

    So Simulink's structure with time has ``out.time`` and ``out.signals.values``. Version 7.3 is HDF5, axes reversed.
    """
    try:
        arrays = dict(_flatten(io.loadmat(path, simplify_cells=True)))
    except NotImplementedError:
        shapes, arrays = _read_hdf5(path, wanted)
        return {name: shape[::-1] for name, shape in shapes.items()}, {name: one.T for name, one in arrays.items()}
    return {name: one.shape for name, one in arrays.items()}, {name: arrays[name] for name in wanted if name in arrays}


def _flatten(content: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, NDArray[Any]]]:
    for name, value in content.items():
        is_row = isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype.kind == "O")
        if isinstance(value, Mapping):
            yield from _flatten(value, f"{prefix}{name}.")
        elif is_row and all(isinstance(member, Mapping) for member in value):
            yield from _flatten({str(place): member for place, member in enumerate(value)}, f"{prefix}{name}.")
        elif not name.startswith("__") and np.asarray(value).dtype.kind in "iufb":
            yield prefix + name, np.asarray(value)


def _read_hdf5(path: Path, wanted: Collection[str]) -> Read:
    """Read datasets of an HDF5 file; those in a group are named GROUP.DATASET, those of compounds DATASET.FIELD."""
    h5py = _library("h5py", path)
    with h5py.File(path, "r") as file:
        sets: dict[str, Any] = {}

        def visit(name: str, item: Any) -> None:
            if isinstance(item, h5py.Dataset) and item.shape is not None and not name.startswith("#"):
                sets[name.replace("/", ".")] = item  # without a shape it is empty

        file.visititems(visit)
        return _series({name: (item.shape, item.dtype) for name, item in sets.items()}, wanted, sets)


def _read_parquet(path: Path, wanted: Collection[str]) -> Read:
    with _library("pyarrow.parquet", path).ParquetFile(path) as file:
        rows, names = file.metadata.num_rows, file.schema_arrow.names
        table = file.read(columns=[name for name in wanted if name in names])
    arrays = {name: _parquet_column(table.column(name)) for name in table.column_names}
    return dict.fromkeys(names, (rows,)) | {name: array.shape for name, array in arrays.items()}, arrays


def _parquet_column(column: Any) -> NDArray[Any]:
    """Return a column as an array; of lists of one length, as LeRobot writes vectors, of two axes."""
    if not str(column.type).startswith(("list", "large_list", "fixed_size_list")):
        return np.asarray(column.to_numpy())
    rows = column.to_pylist()
    width = max((len(row) for row in rows if row is not None), default=0)
    if any(row is not None and len(row) != width for row in rows):
        raise InputError(f"a column of lists has rows of several lengths, up to {width}; they must be alike")
    return np.array([[np.nan] * width if row is None else row for row in rows], dtype=float)


def _read_mcap(path: Path, wanted: Collection[str]) -> Read:
    return read_mcap(path, wanted, *(_library(name, path) for name in ("mcap.reader", "mcap_ros2.decoder")))


def _read_bag(path: Path, wanted: Collection[str]) -> Read:
    return read_bag(path, wanted, *(_library(name, path) for name in ("rosbags.highlevel", "rosbags.typesys")))


def _library(name: str, path: Path) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        package = name.partition(".")[0].replace("mcap_ros2", "mcap-ros2-support")
        raise InputError(
            f"{path}: to read it takes {package}, which is not installed: pip install {package}"
        ) from error


SHEET = "; save the sheet as CSV"
HINTS = {
    ".npy": "; save it as NPZ, numpy.savez(FILE, data=ARRAY), of which data[0] is a series",
    ".xlsx": SHEET,
    ".xls": SHEET,
}
"""What to do with formats that are not read."""

READERS: dict[str, Callable[[Path, Collection[str]], Read]] = {
    **dict.fromkeys((".csv", ".txt", ".tsv", ".dat"), _read_text),
    ".npz": _read_npz,
    ".mat": _read_mat,
    **dict.fromkeys((".h5", ".hdf5"), _read_hdf5),
    ".parquet": _read_parquet,
    ".mcap": _read_mcap,
    **dict.fromkeys((".bag", ".db3"), _read_bag),
}
"""Readers by the ending of the file's name."""
