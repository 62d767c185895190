"""Files that are written whole or not at all."""

import hashlib
import json
import os
import platform
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from errno import ENOTDIR
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff import __version__
from adaptive_ff.errors import InputError

if TYPE_CHECKING:
    from jinja2 import Template

UNFINISHED, REPLACING = ".unfinished-", ".replacing-"
"""How the temporary folders begin: of files that are being written, and of a complete set that is being moved."""


def _owner() -> str:
    """Return what in the name of a temporary folder says whose it is: computer and process."""
    host = hashlib.sha256(platform.node().encode()).hexdigest()[:8]
    return f"{host}-{os.getpid()}-"


def _is_left_behind(stage: Path) -> bool:
    """Tell whether the process that made a temporary folder has ended, on this computer."""
    host, _, rest = stage.name.lstrip(".").partition("-")[2].partition("-")
    number = rest.partition("-")[0]
    if f"{host}-" != _owner().partition("-")[0] + "-" or not number.isdecimal() or os.name != "posix":
        return False
    try:
        os.kill(int(number), 0)
    except ProcessLookupError:
        return True
    except (OSError, OverflowError):
        return False
    return False


def clear_left_behind(folder: Path) -> None:
    """Remove what processes that were killed left in a folder; a set that was being moved to its place is completed."""
    for stage in sorted(folder.glob(f"{REPLACING}*")):
        if _is_left_behind(stage):
            with suppress(OSError):
                for file in sorted(path for path in stage.iterdir() if path.is_file()):
                    os.replace(file, folder / file.name)
                shutil.rmtree(stage, ignore_errors=True)
    for stage in sorted(folder.glob(f"{UNFINISHED}*")):
        if _is_left_behind(stage):
            shutil.rmtree(stage, ignore_errors=True)


def _replace_whole(stage: Path, folder: Path) -> None:
    """Move all files of a stage to their folder; where that fails or is interrupted, those replaced come back."""
    files = sorted(path for path in stage.iterdir() if path.is_file())
    kept = stage / "kept"
    kept.mkdir()
    try:
        for file in files:
            target = folder / file.name
            if target.is_file():
                os.replace(target, kept / file.name)
            os.replace(file, target)
    except BaseException:  # also Ctrl-C, between any two of these lines
        for file in files:
            with suppress(OSError):
                if (kept / file.name).exists():
                    os.replace(kept / file.name, folder / file.name)
                elif not file.exists():
                    (folder / file.name).unlink()
        raise


def make_folder(folder: Path) -> None:
    """Make a folder where it is missing; an ``OSError`` says what stands in its way."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError as error:  # true, but no help
        raise NotADirectoryError(ENOTDIR, os.strerror(ENOTDIR), str(folder)) from error


@contextmanager
def staged(folder: Path, name: Path | None = None) -> Iterator[Path]:
    """Collect files in a temporary folder; move them to their place when all are there.

    A process that is killed leaves the folder behind; the next one that writes to the same place removes it, or, where
    the files were all there, completes the move.

    Parameters
    ----------
    folder : Path
        Where the files go; it is made where it is missing. Files of the same name are replaced, others stay.
    name : Path, optional
        What an error names: the file, where a single one was asked for; the folder by default.

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
        make_folder(folder)
        clear_left_behind(folder)
        stage = Path(tempfile.mkdtemp(prefix=f"{UNFINISHED}{_owner()}", dir=folder))
        yield stage
        for file in sorted(stage.iterdir()):
            if os.path.isdir(folder / file.name):
                raise InputError(f"{folder / file.name}: cannot be written: it is a folder")
        complete = folder / stage.name.replace(UNFINISHED, REPLACING, 1)
        os.replace(stage, complete)
        stage = complete
        _replace_whole(stage, folder)
        made = []
    except OSError as error:
        raise InputError(f"{name or folder}: cannot be written: {error.strerror or error}") from error
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
    with staged(path.parent, path) as stage:
        (stage / path.name).write_text(text, encoding="utf-8")


def write_result(path: Path, content: Mapping[str, Any]) -> None:
    """Write the result of a command as :func:`write_json` does, with the version of the package that found it."""
    write_json(path, {"version": __version__, **content})


def write_csv(path: Path, columns: Mapping[str, NDArray[np.float64]]) -> None:
    """Write series of equal length as a CSV file with a header line."""
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, fmt="%.10g", delimiter=",", header=",".join(columns), comments="")


@cache
def template(package: str, name: str) -> "Template":
    """Return a template of a text file, ``templates/NAME.jinja`` of a package; a value that it lacks is an error."""
    from jinja2 import Environment, PackageLoader, StrictUndefined  # here, not above: few commands fill templates

    environment = Environment(
        loader=PackageLoader(package),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["number"] = "{:.9g}".format
    return environment.get_template(f"{name}.jinja")
