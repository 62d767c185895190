"""Plug-in of pytest: the fixture ``tracking_baseline`` and the option ``--update-tracking-baseline``.

It is loaded by every run of pytest where the package is installed, so it imports nothing heavy before it is used.
"""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from adaptive_ff.comparison.comparison import Comparison
    from adaptive_ff.comparison.gate import Tolerance

OPTION = "--update-tracking-baseline"

FOLDER = "tracking_baselines"  # folder beside the test file in which baselines are stored

WRITTEN = pytest.StashKey[list[str]]()


class TrackingBaseline:
    """The stored baseline of one test: compared with, or on update stored, its path then added to those written."""

    def __init__(self, path: Path, config: pytest.Config) -> None:
        self.path, self._config = path, config

    def check(
        self, comparison: "Comparison", tolerance: "Tolerance | None" = None, *, name: str | None = None, **guarded: Any
    ) -> None:
        """Fail where tracking got worse than in the stored baseline; with the option, store it anew.

        Parameters
        ----------
        comparison : Comparison
            The result now.
        tolerance : float, str or mapping, optional
            See ``adaptive_ff.assert_no_regression``.
        name : str, optional
            Name of the baseline, where a test checks several.
        **guarded
            ``controllers``, ``metrics`` and ``across`` of ``adaptive_ff.assert_no_regression``.
        """
        __tracebackhide__ = True
        from adaptive_ff.comparison.gate import assert_no_regression
        from adaptive_ff.errors import InputError

        path = self.path if name is None else self.path.with_name(f"{self.path.stem}-{_file_name(name)}.json")
        failure = ""
        if self._config.getoption(OPTION):
            comparison.write(path)
            self._config.stash[WRITTEN].append(str(path))
        elif not path.exists():
            failure = f"there is no baseline {path}; run pytest once with {OPTION}, look at it and store it"
        else:
            try:
                assert_no_regression(comparison, path, tolerance, **guarded)
            except (AssertionError, InputError) as error:
                failure = str(error).replace("(--across gains)", '(across="gains")')
        if failure:  # outside, so that it is printed once
            pytest.fail(failure, pytrace=False)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option."""
    group = parser.getgroup("adaptive-ff")
    group.addoption(OPTION, action="store_true", help="store the results that tracking_baseline checks as baselines")


def pytest_configure(config: pytest.Config) -> None:
    """Prepare the list of stored files."""
    config.stash[WRITTEN] = []


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Say which baselines were stored."""
    for path in config.stash[WRITTEN]:
        terminalreporter.write_line(f"tracking baseline stored: {path}")


@pytest.fixture
def tracking_baseline(request: pytest.FixtureRequest) -> TrackingBaseline:
    """Return the stored tracking baseline of this test, to ``check`` a comparison against."""
    name = _file_name(f"{request.path.stem}-{request.node.name}")
    return TrackingBaseline(request.path.parent / FOLDER / f"{name}.json", request.config)


def _file_name(text: str) -> str:
    """Return a text with nothing in it that a file name cannot have."""
    return re.sub(r"[^\w.-]+", "_", text).strip("_")
