"""Files that are written whole or not at all."""

import json
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff import __version__
from adaptive_ff.errors import InputError


@contextmanager
def staged(folder: Path) -> Iterator[Path]:
    """Collect files in a temporary folder; move them to their place when all are there.

    Parameters
    ----------
    folder : Path
        Where the files go; it is made where it is missing. Files of the same name are replaced, others stay.

    Yields
    ------
    Path
        The temporary folder. Where the body fails, it is removed and everything else is left as it was.

    Raises
    ------
    InputError
        The folder cannot be made or written.
    """
    stage, made = None, []
    try:
        made = [part for part in (folder, *folder.parents) if not part.exists()]
        folder.mkdir(parents=True, exist_ok=True)
        stage = Path(tempfile.mkdtemp(prefix=".unfinished-", dir=folder))
        yield stage
        files = sorted(stage.iterdir())
        for file in files:
            if os.path.isdir(folder / file.name):
                raise InputError(f"{folder / file.name}: cannot be written: it is a folder")
        for file in files:
            os.replace(file, folder / file.name)
        made = []
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {error.strerror or error}") from error
    finally:
        if stage is not None:
            shutil.rmtree(stage, ignore_errors=True)
        for part in made:  # innermost first
            with suppress(OSError):
                part.rmdir()


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a JSON file, whole or not at all.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    text = json.dumps(content, indent=2, allow_nan=False) + "\n"
    if os.path.isdir(path):
        raise InputError(f"{path}: cannot be written: it is a folder")
    with staged(path.parent) as stage:
        (stage / path.name).write_text(text, encoding="utf-8")


def write_result(path: Path, content: Mapping[str, Any]) -> None:
    """Write the result of a command as a JSON file, with the version of the package that found it.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    write_json(path, {"version": __version__, **content})


def write_csv(path: Path, columns: Mapping[str, NDArray[np.float64]]) -> None:
    """Write series of equal length as a CSV file with a header line."""
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, fmt="%.10g", delimiter=",", header=",".join(columns), comments="")
