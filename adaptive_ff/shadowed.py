"""Notices a stranger in the place of ``plant`` or ``controllers``, which are packages of this distribution."""

import os
import sys
from importlib.util import find_spec
from pathlib import Path

NAMES = ("plant", "controllers")


def check_not_shadowed() -> None:
    """Refuse to go on where a user's own file or folder has the name of one of our packages.

    Raises
    ------
    ImportError
        It has; the message says which file and what to do.
    """
    here = Path(__file__).resolve().parent.parent
    for name in NAMES:
        found = _origin(name)
        if found is None or not (here / name / "__init__.py").is_file():
            continue  # not installed beside this package: the import itself says what is missing
        if os.path.realpath(found) != str(here / name / "__init__.py"):
            raise ImportError(
                f"{found} stands in the place of the package {name!r} that is installed with adaptive-ff; rename that "
                "file or folder, or run Python from another folder (python -P leaves the current one out)"
            )


def _origin(name: str) -> str | None:
    """Return the file or folder that an import of a package loads."""
    loaded = sys.modules.get(name)
    if loaded is not None:
        return getattr(loaded, "__file__", None)
    spec = find_spec(name)
    if spec is None:
        return None
    # a folder without __init__.py, which hides a package of an editable installation
    return spec.origin or next(iter(spec.submodule_search_locations or ()), None)
