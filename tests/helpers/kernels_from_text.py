"""Kernels that tests write into a module of their own."""

import importlib
import sys

from controllers.compiled import Compiled


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
