"""How tests run: in several processes where that pays, hypothesis without a clock, fixtures that many files share.

Nothing heavy is imported before a fixture needs it: the process that hands out the tests loads this file as well.
"""

import gc
import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from unittest.mock import patch

import pytest
from hypothesis import HealthCheck, settings

pytest_plugins = ["pytester"]

settings.register_profile("without clock", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("without clock")

TESTS = Path(__file__).resolve().parent

for library in ("OPENBLAS", "OMP", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")  # processes of tests with threads each wait for each other
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # hundreds of files would be compiled anew in every process


LONGEST = ("test_project.py", "test_commissioning.py")
"""What takes longest comes first: last, it would run alone, or be split between processes that make its fixtures."""


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Look for garbage seldom, and in what tests leave: not again and again in all that was imported before."""
    gc.disable()
    collected = yield
    gc.freeze()
    gc.set_threshold(20_000)
    gc.enable()
    return collected


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    """Compile the tests in a second process from the end on, until it meets what the first one has compiled."""
    report = yield
    if isinstance(collector, pytest.Dir) and os.environ.get("PYTEST_XDIST_WORKER") == "gw1":
        report.result.reverse()
    return report


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: (item.path.name not in LONGEST, item.path))


def pytest_xdist_auto_num_workers(config):
    """Run the whole suite in one process a core; a selection of it, whose start would cost more, in this one."""
    whole = all(Path(argument).resolve() in (TESTS, TESTS.parent) for argument in config.args)
    return os.cpu_count() or 1 if whole else 0


@pytest.fixture(scope="module")
def compiled():
    """Compile controllers, so that no test of the command line meets the message of a first run, here or later."""
    from adaptive_ff import load_scenario, simulate

    for name in load_scenario().controllers:
        simulate(load_scenario().modified(duration=0.1), name)


@pytest.fixture(scope="session")
def one_thread():
    """An executor in this process, in which what a test replaced is replaced as well."""
    with ThreadPoolExecutor(1) as executor:
        yield executor


@pytest.fixture
def scenario(tmp_path):
    """A short scenario as a file."""
    from scenario_files import short, write_scenario

    return write_scenario(tmp_path, short())


@pytest.fixture
def without_pictures():
    """Comparisons, and what is made of logs, draw nothing."""
    from adaptive_ff.reported import Reported

    with patch.object(Reported, "plot", lambda result, folder: {}):
        yield


@pytest.fixture(scope="module")
def compiled_quickly():
    """Exports are compiled for use here without optimisation; the tests of the exported folder compile with -O2."""
    from adaptive_ff.export import errors

    with patch.object(errors, "FLAGS", tuple("-O0" if flag == "-O2" else flag for flag in errors.FLAGS)):
        yield


@pytest.fixture(scope="module", autouse=True)
def blank(request):
    """Pictures are written with nothing on them, as drawing takes most of the time of a command.

    Those of a module that is marked with ``usefixtures("drawn")`` and of tests that ask for it are as for users.
    """
    from matplotlib.figure import Figure

    from adaptive_ff.report import style

    write = style.write_figure
    if any(mark.name == "usefixtures" and "drawn" in mark.args for mark in request.node.iter_markers()):
        yield write
        return
    with patch.object(style, "write_figure", lambda _, path: write(Figure((1.0, 1.0), layout="tight"), path)):
        yield write


@pytest.fixture
def drawn(blank):
    """Pictures as they are for users."""
    from adaptive_ff.report import style

    with patch.object(style, "write_figure", blank):
        yield
