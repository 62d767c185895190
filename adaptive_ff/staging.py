"""Files that are written whole or not at all."""

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

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
