"""Survivors among figures and tests that take long in plain Python: compiled, in a copy of the tree with the fault."""

import os
import re
import resource
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

from benchmarks.mutation.operators import Mutant

ROOT = Path(__file__).resolve().parent.parent.parent

FIGURES, PATIENCE, NO_END = "tests/test_figures.py", 150, "figures out of time"
"""Figures of short runs, which meet every survivor first; the processor time, s, some four times that of a tree without
a fault, after which one hangs, and what is then said to have noticed it. Other tests get as much, and prove nothing by
taking longer."""

OPTIONS = ("-x", "-q", "-n", "0", "-p", "no:cacheprovider", "--assert=plain", "--tb=no", "-rfE")


class Copy:
    """A copy of the tree in a folder, in which one mutant at a time is tried."""

    def __init__(self, folder: Path) -> None:
        self._root, self._sound = folder / "tree", {NO_END: True}
        shutil.copytree(ROOT, self._root, ignore=shutil.ignore_patterns(".*", "results", "__pycache__", "built-*"))
        if (shared := ROOT.parent / "shared").is_dir():
            (folder / "shared").symlink_to(shared)
        kept = {"XDG_CACHE_HOME": str(folder / "cache"), "PYTHONPATH": str(self._root)}
        plain = {"ADAPTIVE_FF_COMPILE": "", "ADAPTIVE_FF_CFLAGS": "-O0"}
        self._environment = os.environ | kept | plain

    def noticed_by(self, mutant: Mutant, tests: list[str]) -> str | None:
        """Return the test that fails with a mutant and passes without it, or None."""
        place = Path(mutant.function.__code__.co_filename).relative_to(ROOT)
        file, room = self._root / place, f"tests/{place.parent}"
        text = file.read_text(encoding="utf-8")
        others = [*sorted(tests, key=lambda name: not name.startswith(room)), *self._of_room(room, mutant)]
        try:
            for chosen in ([FIGURES], [name for name in others if not name.startswith(FIGURES)]):
                while chosen:
                    file.write_text(mutant.written(), encoding="utf-8")
                    failed = self._failed(chosen)
                    file.write_text(text, encoding="utf-8")
                    if failed is not None and self._passes(failed):
                        return failed
                    # what fails without the fault as well is left out
                    chosen = [] if failed is None else [name for name in chosen if not failed.startswith(name)]
        finally:
            file.write_text(text, encoding="utf-8")
        return None

    def _of_room(self, room: str, mutant: Mutant) -> list[str]:
        """Return the files of the tests of its room, those that import its module first."""
        module, files = mutant.function.__module__, sorted((self._root / room).glob("test_*.py"))
        files.sort(key=lambda file: module not in file.read_text("utf-8"))
        return [str(file.relative_to(self._root)) for file in files]

    def _failed(self, tests: list[str]) -> str | None:
        command = [sys.executable, "-m", "pytest", *OPTIONS, *tests]
        within = partial(resource.setrlimit, resource.RLIMIT_CPU, (PATIENCE, PATIENCE))
        where = {"cwd": self._root, "env": self._environment, "preexec_fn": within}
        done = subprocess.run(command, capture_output=True, text=True, check=False, **where)
        if done.returncode < 0:
            return NO_END if tests == [FIGURES] else None
        found = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", done.stdout, re.M)
        return found[1] if found else None if done.returncode in (0, 5) else tests[0]

    def _passes(self, test: str) -> bool:
        if test not in self._sound:
            self._sound[test] = self._failed([test]) is None
        return self._sound[test]
