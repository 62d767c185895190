"""Where compiled kernels are kept, each file named after what it was made of."""

import atexit
import hashlib
import os
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path

KEPT_DAYS = 30
"""Days for which code is kept that nobody has asked for."""


@cache
def translator_key() -> str:
    """Return a hash of the translation itself: what another one made is not used."""
    digest = hashlib.sha256(sys.platform.encode())
    for path in sorted(Path(__file__).parent.glob("*.[cp]*")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


BUILT = Path(__file__).parent / f"built-{translator_key()}"
"""Where the compiled kernels are that came with the package, if any did."""


@cache
def cache_directory() -> Path:
    """Return the directory of this translation, which is made where there is none."""
    directory = _writable_root() / f"kernels-{translator_key()}"
    directory.mkdir(parents=True, exist_ok=True)
    os.utime(directory)
    return directory


def clear_old() -> None:
    """Remove what nobody has used for :data:`KEPT_DAYS`."""
    oldest = time.time() - KEPT_DAYS * 86400
    for path in cache_directory().parent.glob("*"):
        if path.stat().st_mtime < oldest:
            shutil.rmtree(path, ignore_errors=True)
    for path in cache_directory().iterdir():
        with suppress(OSError):
            if path.is_file() and path.stat().st_mtime < oldest:
                path.unlink()


def _writable_root() -> Path:
    for root in _possible_roots():
        try:
            root.mkdir(parents=True, exist_ok=True, mode=0o700)
            with tempfile.TemporaryFile(dir=root):
                return root
        except OSError:
            continue
    made = tempfile.mkdtemp(prefix="adaptive-ff-")
    atexit.register(shutil.rmtree, made, ignore_errors=True)  # nobody would find it again
    return Path(made)


def _possible_roots() -> Iterator[Path]:
    """Yield where the cache may be, the best place first; a container has no home, or none that it can write."""
    base = os.environ.get("ADAPTIVE_FF_CACHE") or os.environ.get("XDG_CACHE_HOME")
    if base:
        yield Path(base) / "adaptive-ff"
    with suppress(RuntimeError):  # neither HOME nor an entry of the user
        yield Path.home() / ".cache" / "adaptive-ff"
    # one for all processes of a user; compiled code is run, so it must not be another user's
    user = os.getuid() if hasattr(os, "getuid") else 0
    shared = Path(tempfile.gettempdir()) / f"adaptive-ff-{user}"
    with suppress(OSError):
        shared.mkdir(mode=0o700, exist_ok=True)
        found = shared.lstat()
        if stat.S_ISDIR(found.st_mode) and found.st_uid == user and not found.st_mode & 0o022:
            yield shared
