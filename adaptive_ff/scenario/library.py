"""Scenarios of the package, by name and by group."""

import tomllib
from collections.abc import Iterable
from pathlib import Path

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
    named = SCENARIOS / f"{path}.toml"
    return named if str(path) in scenario_names() and not path.is_file() else path
