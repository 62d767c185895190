"""The extension that calls kernels faster than ctypes; compiled on demand where it did not come with the package."""

import hashlib
import sys
import sysconfig
from functools import cache
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from typing import Any

from controllers.kernels.cache_directory import cache_directory
from controllers.kernels.compiler import NoCompiler, compile_files
from controllers.kernels.library import folders

SOURCE = Path(__file__).with_name("_stepper.c")
EXTENSION_FLAGS = ["-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden"]
EXTENSION_FLAGS += ["-undefined", "dynamic_lookup"] if sys.platform == "darwin" else []


@cache
def stepper() -> Any:
    """Return the extension; None where it cannot be had, and ctypes does the same more slowly."""
    name = f"_stepper-{hashlib.sha256(SOURCE.read_bytes()).hexdigest()[:16]}.so"
    library = next((folder / name for folder in folders() if (folder / name).exists()), cache_directory() / name)
    include = sysconfig.get_path("include")
    try:
        if not library.exists():
            if not Path(include, "Python.h").exists():
                return None
            compile_files([SOURCE], library, [*EXTENSION_FLAGS, f"-I{include}"])
        loader = ExtensionFileLoader("_stepper", str(library))
        spec = spec_from_loader("_stepper", loader)
        assert spec is not None
        module = module_from_spec(spec)
        loader.exec_module(module)
    except (ImportError, NoCompiler, OSError):
        return None
    return module
