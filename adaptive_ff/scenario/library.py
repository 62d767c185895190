"""Scenarios of the package, by name."""

from pathlib import Path

SCENARIOS = Path(__file__).resolve().parent / "scenarios"
"""Their files; a recorded reference lies beside its scenario."""


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
