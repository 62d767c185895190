"""Named arrays in bags of ROS 1 (.bag) and ROS 2 (.db3 in its folder); series are named as those of MCAP files."""

from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

from adaptive_ff.errors import InputError
from adaptive_ff.logs.mcap_files import LOG_TIME, NANO, Series, collect, numbers

METADATA = "metadata.yaml"
"""File beside a .db3 that says what is in it."""


def read_bag(path: Path, wanted: Collection[str], anyreader: Any, typesys: Any) -> tuple[dict[str, Any], Series]:
    """Return the shapes of all series of a bag, and the wanted ones.

    Parameters
    ----------
    path : Path
        The file.
    wanted : collection of str
        Names of series.
    anyreader, typesys : module
        ``rosbags.highlevel`` and ``rosbags.typesys``.

    Raises
    ------
    InputError
        A .db3 has no metadata beside it, or an array of a wanted series changes its length.
    """
    if path.suffix == ".db3" and not (path.parent / METADATA).exists():
        raise InputError(f"{path}: there is no {METADATA} beside it; run ros2 bag reindex on its folder")
    source = path.parent if path.suffix == ".db3" else path
    types = typesys.get_typestore(typesys.Stores.LATEST)
    shapes: dict[str, Any] = {}
    arrays: Series = {}
    with anyreader.AnyReader([source], default_typestore=types) as reader:
        for connection in reader.connections:
            prefix = connection.topic.lstrip("/").replace("/", ".")

            def messages(connection: Any = connection, prefix: str = prefix) -> Any:
                for link, stamp, raw in reader.messages(connections=[connection]):
                    content = dict(numbers(reader.deserialize(raw, link.msgtype), prefix))
                    yield {f"{prefix}.{LOG_TIME}": np.asarray(stamp * NANO), **content}

            first = next(messages(), None)
            if first is None:
                continue
            found = {name: (connection.msgcount, *value.shape) for name, value in first.items()}
            shapes |= found
            names = [name for name in wanted if name in found]
            if names:
                arrays |= collect(path, messages(), names)
    return shapes, arrays
