"""Scenarios of the package, by name and by group."""

import tomllib
from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path

from adaptive_ff.errors import InputError

SCENARIOS = Path(__file__).resolve().parent / "scenarios"  # their files; a recorded reference lies beside its scenario
GROUPS: dict[str, list[str]] = tomllib.loads(SCENARIOS.with_name("groups.toml").read_text(encoding="utf-8"))
"""Names of scenarios by group, both in the order of the tables."""

OTHERS = "Further scenarios"  # group of those that are in no other


def grouped(names: Iterable[str]) -> dict[str, list[str]]:
    """Return names of scenarios by group, in the order of the tables; groups without any are left out."""
    left, placed = list(names), {name for members in GROUPS.values() for name in members}
    found = {group: [name for name in members if name in left] for group, members in GROUPS.items()}
    found[OTHERS] = [name for name in left if name not in placed]
    return {group: members for group, members in found.items() if members}


def scenario_names() -> list[str]:
    """Return the names of all scenarios."""
    return sorted(file.stem for file in SCENARIOS.glob("*.toml"))


def scenario_title(name: str) -> str:
    """Return what a scenario is, the first sentence of its file."""
    lines = []
    for line in (SCENARIOS / f"{name}.toml").read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.removeprefix("#").strip())
    sentence, _, _ = " ".join(lines).partition(". ")
    return sentence.rstrip(".")


def scenario_file(path: Path) -> Path:
    """Return the file of a scenario that is given by a path, or by its name where no file is there."""
    near = get_close_matches(str(path), scenario_names(), 1)
    if not near or path.is_file():
        return path
    if near[0] != str(path):
        raise InputError(f"{path}: there is no such file or scenario; did you mean {near[0]}?")
    return SCENARIOS / f"{path}.toml"
