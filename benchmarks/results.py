"""Results of suites as they are stored: figures by row and controller, and what they were computed with."""

import json
import math
import os
import platform
import re
import subprocess
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

from adaptive_ff.errors import InputError

RESULTS = Path(__file__).resolve().parent / "results"
"""Where the present results are; those of a frozen commit are in a folder of its name beside them."""

DIGITS = (5, 4, 3)  # digits to which figures are kept: as many as the size of the file allows
LARGEST = 100_000  # size that a file may have, bytes

PACKAGES = ("numpy", "scipy")
NUMBERS = re.compile(r"\[[^][{}\"]*\]")  # a column in JSON, which is one line of a file

Columns = dict[str, list[float]]  # figures by name, a value a case (or a joint of a case)


@dataclass
class Row:
    """Figures of the cases of one name."""

    seeds: list[int] = field(default_factory=list)  # seeds of the cases, ascending
    figures: dict[str, Columns] = field(default_factory=dict)  # figures by controller and name


@dataclass
class Result:
    """What a suite found."""

    # suite, commit, fingerprint: name of the suite, commit of the checkout, and digest of the code that ran
    suite: str
    commit: str
    fingerprint: str
    seconds: float  # time that the runs took; of runs that were kept from an earlier call, nothing
    machine: str  # machine, versions: kind of machine, and versions of what computes
    versions: dict[str, str]
    rows: dict[str, Row]  # rows by name
    refused: dict[str, str] = field(default_factory=dict)  # cases that could not be run, and why

    def write(self, folder: Path) -> Path:
        """Write the result into a folder and return its file."""
        for digits in DIGITS:
            text = self._text(digits)
            if len(text) <= LARGEST:
                break
        else:
            size = f"{len(text)} bytes are not allowed: at most {LARGEST}"
            raise InputError(f"{self.suite}: {size}; runs are kept, so that a call with fewer --seeds takes no time")
        folder.mkdir(parents=True, exist_ok=True)
        file = folder / f"{self.suite}.json"
        file.write_text(text, encoding="utf-8")
        return file

    def _text(self, digits: int) -> str:
        """Return JSON text with a line for each field and each column, so that a change shows in few lines."""
        rows = {
            name: [
                row.seeds,
                {
                    controller: {figure: [_short(value, digits) for value in column] for figure, column in one.items()}
                    for controller, one in row.figures.items()
                },
            ]
            for name, row in self.rows.items()
        }
        text = json.dumps(vars(self) | {"rows": rows}, indent=1, separators=(",", ":"), allow_nan=False)
        return NUMBERS.sub(lambda match: "".join(match[0].split()), text) + "\n"


def read_result(folder: Path, suite: str) -> Result | None:
    """Return the result of a suite in a folder; None where there is none."""
    file = folder / f"{suite}.json"
    if not file.is_file():
        return None
    content = json.loads(file.read_text(encoding="utf-8"))
    rows = {name: Row(*row) for name, row in content.pop("rows").items()}
    for columns in (columns for row in rows.values() for columns in row.figures.values()):
        columns |= {name: [math.inf if one is None else one for one in column] for name, column in columns.items()}
    return Result(**content, rows=rows)


def circumstances() -> dict[str, Any]:
    """Return commit, machine and versions of a run that begins now."""
    git = ["git", "-C", str(RESULTS.parent), "rev-parse", "--short=7", "HEAD"]
    found = subprocess.run(git, capture_output=True, text=True, check=False)
    versions = {"python": platform.python_version(), **{name: version(name) for name in PACKAGES}}
    machine = f"{platform.machine()}, {os.cpu_count()} cores"
    return {"commit": found.stdout.strip() or "unknown", "machine": machine, "versions": versions}


def _short(value: float, digits: int) -> float | int | None:
    """Return a number with few digits as JSON holds it: null for what is infinite."""
    if not math.isfinite(value):
        return None
    short = float(f"{value:.{digits}g}")
    return int(short) if short.is_integer() and abs(short) < 10**digits else short
