"""Builds the package by setuptools: with compiled kernels in a wheel that is for others, without where it is installed.

A machine with a C compiler compiles kernels when they are first asked for, in seconds, so installing from source
compiles nothing. With ``ADAPTIVE_FF_AHEAD=1``, or where no compiler works, the wheel holds them, compiled by ``CC``,
the compiler that is found, or that of the package ``ziglang``, which is asked for there alone.
"""

import importlib.util
import os
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

from setuptools import build_meta
from setuptools.build_meta import *  # noqa: F403
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_py import build_py

ROOT = Path(__file__).resolve().parent
ZIG = "ziglang>=0.13"
NEEDED = ("numpy", "scipy", "pydantic", "lazy-loader")
"""What the modules load that hold kernels, or make what these are called with."""
LEAN = "-g0 -nostdlib" if sys.platform == "linux" and sys.maxsize > 2**32 else "-g0"
"""Flags of zig, which spends half of its time on what kernels do not use: debug information, a run-time library."""


def _compiler() -> tuple[str, ...] | None:
    """Return a C compiler that works on this machine, beside zig."""
    spec = importlib.util.spec_from_file_location("compiler", ROOT / "controllers/kernels/compiler.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    found = module.compiler()
    return None if found is None or "ziglang" in found else found


def _compiles_ahead() -> bool:
    return os.environ.get("ADAPTIVE_FF_AHEAD", "") == "1" or _compiler() is None


def get_requires_for_build_wheel(config_settings: Any = None) -> list[str]:
    """Return what building a wheel needs: to compile ahead what kernels need, and zig where nothing compiles."""
    needed: list[str] = build_meta.get_requires_for_build_wheel(config_settings)
    if _compiles_ahead():
        project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
        needed += [each for each in project["dependencies"] if each.startswith(NEEDED)]
        needed += [ZIG] if _compiler() is None else []
    return needed


class Build(build_py):
    """Copies the sources, and compiles ahead where that is wanted."""

    def run(self) -> None:
        """Build."""
        super().run()
        if not self.editable_mode and _compiles_ahead():
            target = Path(self.build_lib).resolve() / "controllers" / "kernels"
            places = [str(target.parents[1]), *sys.path, str(ROOT)]  # where metadata is, which has the version
            environment = {**os.environ, "PYTHONPATH": os.pathsep.join(places)}
            if _compiler() is None:
                environment["ADAPTIVE_FF_CFLAGS"] = f"{LEAN} {os.environ.get('ADAPTIVE_FF_CFLAGS', '')}"
            command = [sys.executable, "-m", "adaptive_ff.cli.ahead", str(target)]
            subprocess.run(command, env=environment, cwd=self.build_lib, check=True)


class Wheel(bdist_wheel):
    """Names a wheel with compiled kernels by its platform; its extension serves all versions of Python from 3.11 on."""

    def finalize_options(self) -> None:
        """Take the options."""
        ahead = _compiles_ahead()
        self.distribution.has_ext_modules = lambda: ahead  # else libraries would stand beside what any platform takes
        super().finalize_options()
        self.root_is_pure = not ahead

    def get_tag(self) -> tuple[str, str, str]:
        """Return versions of Python, interface and platform."""
        tag = super().get_tag()
        return tag if self.root_is_pure else ("cp311", "abi3", tag[2])
