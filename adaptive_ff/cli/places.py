"""Where a command writes: a folder, and beside it single files that were asked for, all of them or none."""

import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from adaptive_ff.errors import InputError


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
        By single file where to write it for the time being.

    Raises
    ------
    InputError
        One of them cannot be written.
    """
    from adaptive_ff.files import staged

    wanted = [file for file in files if file is not None]
    with ExitStack() as stack:
        beside = {file: stack.enter_context(staged(file.parent)) / file.name for file in wanted}
        stage = stack.enter_context(staged(out))
        for file in wanted:
            if os.path.isdir(file):
                raise InputError(f"{file}: cannot be written: it is a folder")
        yield stage, beside
