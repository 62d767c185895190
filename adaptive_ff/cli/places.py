"""Where a command writes: a folder, and beside it single files that were asked for, all of them or none."""

import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from adaptive_ff.cli.common import SETTINGS
from adaptive_ff.cli.options import KNOWN_FORMATS
from adaptive_ff.errors import InputError

STANDARD_OUTPUT = Path("-")
"""What stands for standard output instead of a file."""


@contextmanager
def places(out: Path, *files: Path | None) -> Iterator[tuple[Path, dict[Path, Path]]]:
    """Stage a folder and single files elsewhere, so that they are moved to their places when all are complete.

    Parameters
    ----------
    out : Path
        The folder.
    *files : Path or None
        The single files; None for one that was not asked for.

    Yields
    ------
    stage : Path
        The temporary folder that becomes ``out``.
    beside : dict
        By single file where to write it for the time being. ``-`` is printed when all is done.

    Raises
    ------
    InputError
        One of them cannot be written.
    """
    from adaptive_ff.files import staged

    wanted = [file for file in files if file is not None]
    if STANDARD_OUTPUT in wanted:
        SETTINGS.quiet = True  # what is printed is the result and nothing else
    with ExitStack() as stack:
        beside = {file: _staged_file(file, stack) for file in wanted}
        stage = stack.enter_context(staged(out))
        for file in wanted:
            if os.path.isdir(file) and file != STANDARD_OUTPUT:
                raise InputError(f"{file}: cannot be written: it is a folder")
        yield stage, beside
        printed = beside[STANDARD_OUTPUT].read_text(encoding="utf-8") if STANDARD_OUTPUT in beside else ""
    sys.stdout.write(printed)


def of_earlier_runs(out: Path, stage: Path, pictures: Iterable[str], files: Iterable[str]) -> list[str]:
    """Say which files that a command may write stay in its folder as they are, since it does not write them now.

    Parameters
    ----------
    out : Path
        The folder.
    stage : Path
        Where the files are that will be moved there.
    pictures : iterable of str
        Names of the pictures that the command may write, without an ending.
    files : iterable of str
        Names of its other files.

    Returns
    -------
    list of str
        One sentence, or none.
    """
    names = [*(f"{name}.{ending}" for name in pictures for ending in KNOWN_FORMATS), *files]
    there = sorted(name for name in names if (out / name).is_file() and not (stage / name).exists())
    return [f"Of an earlier run, not of this one, in {out}: {', '.join(there)}"] if there else []


def _staged_file(file: Path, stack: ExitStack) -> Path:
    from adaptive_ff.files import staged

    if file == STANDARD_OUTPUT:
        return Path(stack.enter_context(TemporaryDirectory())) / "result.json"
    return stack.enter_context(staged(file.parent, file)) / file.name
