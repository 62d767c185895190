"""Kernels that tests write into a module of their own, and processes that compile some."""

import importlib
import os
import sys

from controllers.compiled import Compiled


def compiling(cache, **variables):
    """Environment of a process that finds the packages and keeps its compiled kernels in a folder."""
    return {**os.environ, "ADAPTIVE_FF_CACHE": str(cache), "PYTHONPATH": os.pathsep.join(sys.path), **variables}


def from_text(text, tmp_path, monkeypatch, name="kernel"):
    """Return a kernel, to be called as machine code, of a new module."""
    module = f"made_{abs(hash(text))}"
    (tmp_path / f"{module}.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    importlib.invalidate_caches()
    try:
        return Compiled(getattr(importlib.import_module(module), name))
    finally:
        sys.modules.pop(module)
