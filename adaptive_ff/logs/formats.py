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
from adaptive_ff.logs.messages import read_bag, read_mcap
from adaptive_ff.logs.text_tables import NO_TEXT, read_table


class Content(NamedTuple):
    """What a file holds: the shape of every array by name (of a column of text, empty), and the wanted arrays."""

    shapes: dict[str, tuple[int, ...]]
    arrays: dict[str, NDArray[Any]]

    def listed(self, names: Collection[str] | None = None) -> str:
        """Return names, by default of all arrays, with shapes of those that hold several; ``none`` for no names."""
        chosen = self.shapes if names is None else names
        shapes = {name: self.shapes.get(name, ()) for name in chosen}
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
    try:
        with path.open("rb"):  # where there is none, not every reader says so
            pass
        return reader(path, wanted)
    except InputError:
        raise
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: {NO_TEXT}") from error
    except Exception as error:  # each format has its own kinds of damage
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise InputError(f"{path}: cannot be read: {reason or type(error).__name__}") from error


def is_text(path: Path) -> bool:
    """Tell whether a file is read as a table in text."""
    return READERS.get(path.suffix.lower()) is _read_text


def _read_text(path: Path, wanted: Collection[str]) -> Content:
    names, columns = read_table(path, wanted)
    return Content(dict.fromkeys(names, ()), columns)


def _read_npz(path: Path, wanted: Collection[str]) -> Content:
    if not is_zipfile(path):  # numpy takes it for pickled objects, and advises to trust it
        raise InputError(f"{path}: cannot be read: it is no NPZ archive")
    with np.load(path, allow_pickle=False) as archive:
        series: dict[str, _Series] = {}
        for name in archive.files:
            shape, _, kind = _npz_header(archive, name)
            series.update(_series_of(name, shape, kind))
        for name in wanted:
            if name in series and series[name].kind.hasobject:
                raise InputError(f"{path}: {name} holds Python objects; it must hold numbers")
        return _content(series, wanted, archive)


class _Series(NamedTuple):
    """Where a series is: an array of a file, or a field of a structured one, with its shape and the kind of array."""

    array: str
    field: str | None
    shape: tuple[int, ...]
    kind: np.dtype[Any]


def _series_of(name: str, shape: tuple[int, ...], kind: np.dtype[Any]) -> dict[str, _Series]:
    """Return the series of an array by name: of a structured one ARRAY.FIELD, each."""
    if kind.names is None:
        return {name: _Series(name, None, tuple(shape), kind)}
    return {f"{name}.{field}": _Series(name, field, (*shape, *kind[field].shape), kind) for field in kind.names}


def _content(series: Mapping[str, _Series], wanted: Collection[str], arrays: Mapping[str, Any]) -> Content:
    """Return the shapes of all series, and the wanted ones, with each array read once."""
    found = {name: series[name] for name in wanted if name in series}
    read = {array: arrays[array][()] for array in dict.fromkeys(one.array for one in found.values())}
    return Content(
        {name: one.shape for name, one in series.items()},
        {name: read[one.array] if one.field is None else read[one.array][one.field] for name, one in found.items()},
    )


def _npz_header(archive: Any, name: str) -> Any:
    """Read shape, order and type of a member from its header alone."""
    member = name if name in archive.zip.namelist() else f"{name}.npy"
    with archive.zip.open(member) as stream:
        major = np.lib.format.read_magic(stream)[0]
        read = np.lib.format.read_array_header_1_0 if major == 1 else np.lib.format.read_array_header_2_0
        return read(stream)


def _read_mat(path: Path, wanted: Collection[str]) -> Content:
    """Read a MAT file; members of a struct are named STRUCT.MEMBER, of an array of structs STRUCT.0.MEMBER.

    So Simulink's structure with time has ``out.time`` and ``out.signals.values``. Version 7.3 is HDF5, axes reversed.
    """
    try:
        arrays = dict(_flatten(io.loadmat(path, simplify_cells=True)))
    except NotImplementedError:
        return _read_hdf5(path, wanted, transposed=True)
    shapes = {name: array.shape for name, array in arrays.items()}
    return Content(shapes, {name: arrays[name] for name in wanted if name in arrays})


def _flatten(content: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, NDArray[Any]]]:
    for name, value in content.items():
        if isinstance(value, Mapping):
            yield from _flatten(value, f"{prefix}{name}.")
        elif _are_structs(value):
            yield from _flatten({str(place): member for place, member in enumerate(value)}, f"{prefix}{name}.")
        elif not name.startswith("__") and np.asarray(value).dtype.kind in "iufb":
            yield prefix + name, np.asarray(value)


def _are_structs(value: Any) -> bool:
    is_row = isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype == object and value.ndim == 1)
    return is_row and all(isinstance(member, Mapping) for member in value)


def _read_hdf5(path: Path, wanted: Collection[str], *, transposed: bool = False) -> Content:
    """Read datasets of an HDF5 file; those in a group are named GROUP.DATASET, those of compounds DATASET.FIELD."""
    h5py = _library("h5py", path)
    with h5py.File(path, "r") as file:
        sets: dict[str, Any] = {}
        file.visititems(
            lambda name, item: sets.update({name.replace("/", "."): item}) if isinstance(item, h5py.Dataset) else None
        )
        series: dict[str, _Series] = {}
        for name, item in sets.items():
            if not name.startswith("#") and item.shape is not None:  # that of an empty dataset
                found = _series_of(name, item.shape[::-1] if transposed else item.shape, item.dtype)
                series.update({key: one for key, one in found.items() if _holds_numbers(one)})
        content = _content(series, wanted, sets)
    return content._replace(arrays={name: array.T if transposed else array for name, array in content.arrays.items()})


def _holds_numbers(series: _Series) -> bool:
    kind = series.kind if series.field is None else series.kind[series.field]
    return kind.base.kind in "iufb"


def _read_parquet(path: Path, wanted: Collection[str]) -> Content:
    parquet = _library("pyarrow.parquet", path)
    with parquet.ParquetFile(path) as file:
        rows, names = file.metadata.num_rows, file.schema_arrow.names
        table = file.read(columns=[name for name in wanted if name in names])
    arrays = {name: _parquet_column(table.column(name)) for name in table.column_names}
    shapes: dict[str, tuple[int, ...]] = dict.fromkeys(names, (rows,))
    return Content(shapes | {name: array.shape for name, array in arrays.items()}, arrays)


def _parquet_column(column: Any) -> NDArray[Any]:
    """Return a column as an array; of lists of one length, as LeRobot writes vectors, of two axes."""
    if not str(column.type).startswith(("list", "large_list", "fixed_size_list")):
        return np.asarray(column.to_numpy())
    rows = column.to_pylist()
    width = max((len(row) for row in rows if row is not None), default=0)
    if any(row is not None and len(row) != width for row in rows):
        raise InputError(f"a column of lists has rows of several lengths, up to {width}; they must be alike")
    return np.array([[np.nan] * width if row is None else row for row in rows], dtype=float)


def _read_mcap(path: Path, wanted: Collection[str]) -> Content:
    reader, ros2 = (_library(name, path) for name in ("mcap.reader", "mcap_ros2.decoder"))
    return Content(*read_mcap(path, wanted, reader, ros2))


def _read_bag(path: Path, wanted: Collection[str]) -> Content:
    anyreader, typesys = (_library(name, path) for name in ("rosbags.highlevel", "rosbags.typesys"))
    return Content(*read_bag(path, wanted, anyreader, typesys))


def _library(name: str, path: Path) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        package = name.partition(".")[0].replace("mcap_ros2", "mcap-ros2-support")
        raise InputError(
            f"{path}: to read it takes {package}, which is not installed: pip install {package}"
        ) from error


HINTS = {
    ".npy": "; save it as NPZ, numpy.savez(FILE, data=ARRAY), of which data[0] is a series",
    ".xlsx": "; save the sheet as CSV",
    ".xls": "; save the sheet as CSV",
}
"""What to do with formats that are not read."""

READERS: dict[str, Callable[[Path, Collection[str]], Content]] = {
    ".csv": _read_text,
    ".txt": _read_text,
    ".tsv": _read_text,
    ".dat": _read_text,
    ".npz": _read_npz,
    ".mat": _read_mat,
    ".h5": _read_hdf5,
    ".hdf5": _read_hdf5,
    ".parquet": _read_parquet,
    ".mcap": _read_mcap,
    ".bag": _read_bag,
    ".db3": _read_bag,
}
"""Readers by the ending of the file's name."""
