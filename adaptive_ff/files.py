"""Files that are written whole or not at all."""

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff import __version__
from adaptive_ff.errors import InputError
from adaptive_ff.staging import staged as staged


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
