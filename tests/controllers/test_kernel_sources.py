import importlib
import inspect
import pkgutil
import shutil
from pathlib import Path
from types import FunctionType, ModuleType

import pytest

import adaptive_ff
import controllers
import plant
from controllers.kernel_sources import KERNEL_PACKAGES, kernel_sources, package_root, source_key

ROOT = package_root()
KERNELS = sorted(
    str(path.relative_to(ROOT))
    for package in KERNEL_PACKAGES
    for path in (ROOT / package).rglob("*.py")
    if "@register_jitable" in path.read_text()
)


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    """A copy of the packages to edit."""
    root = tmp_path_factory.mktemp("sources")
    for package in KERNEL_PACKAGES:
        shutil.copytree(ROOT / package, root / package, ignore=shutil.ignore_patterns("__pycache__"))
    return root


def key_after_edit(root, name):
    path = root / name
    before = path.read_text()
    path.write_text(before + "\n# edited\n")
    try:
        return source_key(root)
    finally:
        path.write_text(before)


def test_key_is_that_of_the_content_and_not_of_the_place(sources):
    assert source_key(sources) == source_key()


def test_editing_any_kernel_file_changes_the_key(sources):
    """The key is of the whole content of every one of them; that it changes is shown for a share."""
    assert len(KERNELS) > 30
    content = {str(path): text for path, text in kernel_sources(sources).items()}
    assert [name for name in KERNELS if content.get(name) != (sources / name).read_bytes()] == []
    before = source_key(sources)
    assert [name for name in KERNELS[::12] if key_after_edit(sources, name) == before] == []


@pytest.mark.parametrize(
    "name", ["adaptive_ff/cli/main.py", "adaptive_ff/report/comparison_plots.py", "adaptive_ff/logs/formats.py"]
)
def test_editing_what_no_kernel_sees_does_not(sources, name):
    assert key_after_edit(sources, name) == source_key(sources)


def test_two_files_that_exchange_their_ends_change_the_key(tmp_path):
    package = tmp_path / "plant"
    package.mkdir()
    keys = set()
    for first, second in (("a = 1\nb = 2\n", ""), ("a = 1\n", "b = 2\n")):
        (package / "one.py").write_text("from numba.extending import register_jitable\n" + first)
        (package / "two.py").write_text("from numba.extending import register_jitable\n" + second)
        keys.add(source_key(tmp_path))
    assert len(keys) == 2


@pytest.mark.parametrize(
    "line",
    [
        "import plant.constants",
        "import math, plant.constants as known",
        "from plant import constants",
        "from plant import LIMIT",
        "from plant.constants import LIMIT  # N m",
        "from plant.constants import (\n    OTHER,  # none\n    LIMIT,\n)",
        "from .constants import LIMIT",
        "from . import constants",
    ],
)
def test_every_way_to_import_is_followed(tmp_path, line):
    package = tmp_path / "plant"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "__init__.pyi").write_text("from .constants import LIMIT as LIMIT\nfrom .other import O as O\n")
    (package / "constants.py").write_text("OTHER = LIMIT = 1.0\n")
    (package / "other.py").write_text("O = 1.0\n")
    (package / "kernel.py").write_text(f"from numba.extending import register_jitable\n{line}\n")
    assert {path.name for path in kernel_sources(tmp_path)} == {"__init__.py", "constants.py", "kernel.py"}


def modules():
    for package in (plant, controllers, adaptive_ff):
        for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not found.name.endswith("__main__"):
                yield importlib.import_module(found.name)


def seen_by(function):
    """Return what a function reads of its module: the module where each function or class stands."""
    for name in (*function.__code__.co_names, *function.__annotations__):
        value = function.__globals__.get(name)
        if isinstance(value, ModuleType):
            yield value
        elif isinstance(value, FunctionType | type):
            yield inspect.getmodule(value)


def test_no_module_that_a_kernel_reads_is_left_out():
    """Found from the loaded functions, not from the text of imports."""
    known = set(kernel_sources())
    kernel_modules = [module for module in modules() if "register_jitable" in vars(module)]
    assert len(kernel_modules) > 30
    read = set()
    for module in kernel_modules:
        for value in vars(module).values():
            if isinstance(value, FunctionType) and value.__module__ == module.__name__:
                read.update(seen_by(value))
    paths = {Path(module.__file__) for module in read if getattr(module, "__file__", None)}
    ours = {path.relative_to(ROOT) for path in paths if path.is_relative_to(ROOT) and ".venv" not in path.parts}
    assert len(ours) > 20
    assert ours <= known
