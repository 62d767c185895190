"""Results that are kept from one call to the next: what they depend on, as a mark that is stored beside them."""

import hashlib
from functools import lru_cache
from pathlib import Path

from adaptive_ff.comparison.own import Own

ROOT = Path(__file__).resolve().parent.parent.parent
"""Folder that the packages lie in."""

ROOMS = ("model", "estimation", "regression", "adaptive", "baselines", "scenario", "simulation", "comparison")
SOURCES = (*(f"adaptive_ff/{room}/**/*.py" for room in ROOMS), "plant/**/*.py", "controllers/**/*.py")
"""Sources that results depend on."""


@lru_cache(maxsize=1)
def source_digest() -> bytes:
    """Return a digest of all sources that results depend on."""
    digest = hashlib.sha256()
    for pattern in SOURCES:
        for path in sorted(ROOT.glob(pattern)):
            digest.update(str(path.relative_to(ROOT)).encode())
            digest.update(path.read_bytes())
    return digest.digest()


def mark_of(*parts: bytes) -> str:
    """Return a short text that changes with any of the parts."""
    return hashlib.sha256(b"\0".join(parts)).hexdigest()[:16]


def own_mark(own: Own) -> str | None:
    """Return what identifies an own controller from one call to the next: its file; None for a living object."""
    if not isinstance(own, str):
        return None
    return own + hashlib.sha256(Path(own.rpartition(":")[0]).read_bytes()).hexdigest()
