"""Files that are written whole or not at all."""

import json
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.errors import InputError


def prepare_folder(folder: Path) -> None:
    """Make a folder and check that files can be written there.

    Raises
    ------
    InputError
        They cannot.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {error.strerror or error}") from error


@contextmanager
def staged(folder: Path) -> Iterator[Path]:
    """Collect files in a temporary folder; move them to their place when all are there.

    Parameters
    ----------
    folder : Path
        Where the files go; files of the same name are replaced, others stay.

    Yields
    ------
    Path
        The temporary folder. Where the body fails, it is removed and the real one is left as it was.
    """
    stage = Path(tempfile.mkdtemp(prefix=".unfinished-", dir=folder))
    try:
        yield stage
        for file in sorted(stage.iterdir()):
            os.replace(file, folder / file.name)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {error.strerror or error}") from error
    finally:
        shutil.rmtree(stage, ignore_errors=True)


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a JSON file, whole or not at all.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    text = json.dumps(content, indent=2, allow_nan=False) + "\n"
    prepare_folder(path.parent)
    if path.is_dir():
        raise InputError(f"{path}: cannot be written: it is a folder")
    with staged(path.parent) as stage:
        (stage / path.name).write_text(text, encoding="utf-8")


def write_csv(path: Path, columns: Mapping[str, NDArray[np.float64]]) -> None:
    """Write series of equal length as a CSV file with a header line."""
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, fmt="%.10g", delimiter=",", header=",".join(columns), comments="")
