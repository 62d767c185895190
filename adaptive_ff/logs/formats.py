"""Named arrays in the file formats that logs come in: CSV, NPZ, MAT, HDF5, Parquet, MCAP and bags of ROS.

Each reader takes a path and the wanted names. It returns the shapes of all arrays there are, and those arrays that are
wanted: only these are read into memory.

A number of a recorded message is called ``TOPIC.FIELD``, with dots for members of members and without the slash before
the topic: ``joint_states.effort[2]`` picks one of an array. ``TOPIC.log_time`` is the time at which the recorder had
the message, ``TOPIC.header.stamp`` that of its header, both in s since 1970. Series of different topics have clocks of
their own, so time, motion and torque must be of one topic.
"""

import json
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple
from zipfile import is_zipfile

import numpy as np
from numpy.typing import NDArray
from scipy import io

from adaptive_ff.errors import InputError, library
from adaptive_ff.logs.text_tables import read_table, reading

Header = tuple[tuple[int, ...], np.dtype[Any]]
"""Shape and type of an array."""

Messages = Iterator[tuple[int, Any]]
"""Time, ns, and content of each message."""

NANO = 1e-9  # seconds in a nanosecond

JSON = SimpleNamespace(decoder_for=lambda encoding, schema: json.loads if encoding == "json" else None)
"""Makes decoders of JSON messages, as the library of MCAP asks for them."""


class Content(NamedTuple):
    """What a file holds: the shape of every array by name (of a column of text, empty), and the wanted arrays.

    A table in text may have a row of units, by column.
    """

    shapes: dict[str, tuple[int, ...]]
    arrays: dict[str, NDArray[Any]]
    units: Mapping[str, str] = {}

    def listed(self) -> str:
        """Return the names of all arrays, with shapes of those that hold several; ``none`` for no names."""
        shown = (name + (f" {shape}" if len(shape) > 1 else "") for name, shape in self.shapes.items())
        return ", ".join(shown) or "none"


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
        return reader(path, wanted)


def _read_text(path: Path, wanted: Collection[str]) -> Content:
    layout, columns = read_table(path, wanted)
    return Content(dict.fromkeys(layout.names, ()), columns, layout.units)


def _read_npz(path: Path, wanted: Collection[str]) -> Content:
    if not is_zipfile(path):  # numpy takes it for pickled objects, and advises to trust it
        raise InputError(f"{path}: cannot be read: it is no NPZ archive")
    with np.load(path, allow_pickle=False) as archive:
        headers = {name: _npz_header(archive, name) for name in archive.files}
        for name in wanted:
            if name in headers and headers[name][1].hasobject:
                raise InputError(f"{path}: {name} holds Python objects; it must hold numbers")
        return _fields(headers, wanted, archive)


def _npz_header(archive: Any, name: str) -> Header:
    """Read shape and type of a member from its header alone."""
    with archive.zip.open(name if name in archive.zip.namelist() else f"{name}.npy") as stream:
        major = np.lib.format.read_magic(stream)[0]
        read = np.lib.format.read_array_header_1_0 if major == 1 else np.lib.format.read_array_header_2_0
        shape, _, kind = read(stream)
        return shape, kind


def _fields(headers: Mapping[str, Header], wanted: Collection[str], arrays: Mapping[str, Any]) -> Content:
    """Return all arrays by their headers, and the wanted ones; fields of structured arrays are ARRAY.FIELD."""
    places = {
        name if field is None else f"{name}.{field}": (name, field, (*shape, *(kind[field].shape if field else ())))
        for name, (shape, kind) in headers.items()
        for field in kind.names or (None,)
    }
    found = {key: places[key] for key in wanted if key in places}
    read = {name: arrays[name][()] for name in dict.fromkeys(name for name, _, _ in found.values())}
    series = {key: read[name] if field is None else read[name][field] for key, (name, field, _) in found.items()}
    return Content({key: shape for key, (_, _, shape) in places.items()}, series)


def _read_mat(path: Path, wanted: Collection[str]) -> Content:
    """Read a MAT file; members of a struct are named STRUCT.MEMBER, of an array of structs STRUCT.0.MEMBER.

    So Simulink's structure with time has ``out.time`` and ``out.signals.values``. Version 7.3 is HDF5, axes reversed.
    """
    try:
        content = io.loadmat(path, simplify_cells=True)
    except NotImplementedError:
        shapes, arrays, _ = _read_hdf5(path, wanted)
        return Content({name: one[::-1] for name, one in shapes.items()}, {name: one.T for name, one in arrays.items()})
    arrays = dict(_numbers({name: value for name, value in content.items() if not name.startswith("__")}))
    return Content({name: one.shape for name, one in arrays.items()}, arrays)


def _read_hdf5(path: Path, wanted: Collection[str]) -> Content:
    """Read datasets of an HDF5 file; those in a group are named GROUP.DATASET, those of compounds DATASET.FIELD."""
    h5py = library("h5py", f"{path}: to read it")
    with h5py.File(path, "r") as file:
        names: list[str] = []
        file.visit(names.append)
        items = {name.replace("/", "."): file[name] for name in names if not name.startswith("#")}
        # a set without a shape is empty
        sets = {name: item for name, item in items.items() if getattr(item, "shape", None) is not None}
        return _fields({name: (item.shape, item.dtype) for name, item in sets.items()}, wanted, sets)


def _read_parquet(path: Path, wanted: Collection[str]) -> Content:
    with library("pyarrow.parquet", f"{path}: to read it").ParquetFile(path) as file:
        rows, names = file.metadata.num_rows, file.schema_arrow.names
        table = file.read(columns=[name for name in wanted if name in names])
    arrays = {name: _parquet_column(path, name, table.column(name)) for name in table.column_names}
    return Content(dict.fromkeys(names, (rows,)) | {name: array.shape for name, array in arrays.items()}, arrays)


def _parquet_column(path: Path, name: str, column: Any) -> NDArray[Any]:
    """Return a column as an array; of lists of one length, as LeRobot writes vectors, of two axes."""
    if "list" not in str(column.type):
        return np.asarray(column.to_numpy())
    rows = column.to_pylist()
    widths = {len(row) for row in rows if row is not None}
    if len(widths) > 1:
        raise InputError(f"{path}: {name} has lists of {min(widths)} to {max(widths)} numbers; they must be alike")
    missing = [np.nan] * max(widths, default=0)
    return np.array([missing if row is None else row for row in rows], dtype=float)


def _read_mcap(path: Path, wanted: Collection[str]) -> Content:
    mcap, ros2 = library("mcap.reader", f"{path}: to read it"), library("mcap_ros2.decoder", f"{path}: to read it")
    with path.open("rb") as stream:
        reader = mcap.make_reader(stream, decoder_factories=[ros2.DecoderFactory(), JSON])
        summary = reader.get_summary()
        if summary is None:
            raise InputError(f"{path}: the file has no summary, as of a recording that broke off; run 'mcap recover'")
        counts: Counter[str] = Counter()
        for number, channel in summary.channels.items():
            if channel.message_encoding in ("cdr", "json"):
                counts[channel.topic] += summary.statistics.channel_message_counts.get(number, 0)
        if not counts:
            found = ", ".join(sorted({one.message_encoding for one in summary.channels.values()})) or "no topic"
            raise InputError(f"{path}: messages are encoded as {found}; cdr (ROS 2) and json are read")

        def messages(topic: str) -> Messages:
            return ((one[2].log_time, one[3]) for one in reader.iter_decoded_messages(topics=[topic]))

        return _collected(path, wanted, counts, messages)


def _read_bag(path: Path, wanted: Collection[str]) -> Content:
    """Read a bag of ROS 1 (.bag), or one of ROS 2 (.db3 in its folder)."""
    highlevel, typesys = (library(f"rosbags.{name}", f"{path}: to read it") for name in ("highlevel", "typesys"))
    is_folder = path.suffix == ".db3"
    if is_folder and not (path.parent / "metadata.yaml").exists():
        raise InputError(f"{path}: there is no metadata.yaml beside it; run ros2 bag reindex on its folder")
    types = typesys.get_typestore(typesys.Stores.LATEST)
    with highlevel.AnyReader([path.parent if is_folder else path], default_typestore=types) as reader:
        topics = reader.topics

        def messages(topic: str) -> Messages:
            raw = reader.messages(connections=topics[topic].connections)
            return ((stamp, reader.deserialize(content, link.msgtype)) for link, stamp, content in raw)

        return _collected(path, wanted, {name: topic.msgcount for name, topic in topics.items()}, messages)


def _collected(
    path: Path, wanted: Collection[str], counts: Mapping[str, int], messages: Callable[[str], Messages]
) -> Content:
    """Return what messages hold, by their number and by the messages of each topic.

    Shapes are those of the first message of each topic, and a wanted series must have its own throughout.
    """
    content = Content({}, {})
    for topic, count in counts.items():
        prefix = topic.lstrip("/").replace("/", ".")
        first = next((_named(*message, prefix) for message in messages(topic)), {})
        content.shapes.update({name: (count, *value.shape) for name, value in first.items()})
        rows: dict[str, list[NDArray[Any]]] = {name: [] for name in wanted if name in first}
        for named in (_named(*message, prefix) for message in messages(topic)) if rows else ():
            for name, values in rows.items():
                if name not in named or named[name].shape != first[name].shape:
                    raise InputError(f"{path}: {name} is not the same in all messages; it must have one length")
                values.append(named[name])
        content.arrays.update({name: np.array(values) for name, values in rows.items()})
    return content


def _named(stamp: int, content: Any, prefix: str) -> dict[str, NDArray[Any]]:
    return {f"{prefix}.log_time": np.asarray(stamp * NANO), **dict(_numbers(content, f"{prefix}."))}


def _numbers(content: Any, prefix: str = "") -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield all numbers in nested content, and arrays of them, by name; a stamp of a message is a number, too."""
    is_row = isinstance(content, list) or (isinstance(content, np.ndarray) and content.dtype.kind == "O")
    names = getattr(content, "__dataclass_fields__", getattr(type(content), "__slots__", ()))
    if is_row and all(isinstance(member, Mapping) for member in content):
        members: Mapping[Any, Any] = dict(enumerate(content))
    else:
        members = content if isinstance(content, Mapping) else {name: getattr(content, name) for name in names}
    if {"sec", "nanosec"} <= set(members):
        yield prefix[:-1], np.asarray(members["sec"] + NANO * members["nanosec"])
    for name, member in members.items():
        yield from _numbers(member, f"{prefix}{name}.")
    values = np.asarray("" if members or isinstance(content, str | bytes) else content)
    if values.dtype.kind in "iufb":
        yield prefix[:-1], values


HINTS = {
    ".npy": "; save it as NPZ, numpy.savez(FILE, data=ARRAY), of which data[0] is a series",
    **dict.fromkeys((".xlsx", ".xls"), "; save the sheet as CSV"),
    **dict.fromkeys((".gz", ".zip", ".bz2", ".xz", ".zst"), "; unpack it first"),
}
"""What to do with formats that are not read."""

READERS: dict[str, Callable[[Path, Collection[str]], Content]] = {
    **dict.fromkeys((".csv", ".txt", ".tsv", ".dat"), _read_text),
    ".npz": _read_npz,
    ".mat": _read_mat,
    **dict.fromkeys((".h5", ".hdf5"), _read_hdf5),
    ".parquet": _read_parquet,
    ".mcap": _read_mcap,
    **dict.fromkeys((".bag", ".db3"), _read_bag),
}
"""Readers by the ending of the file's name."""
