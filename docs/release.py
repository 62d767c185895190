"""Make a release: ``python -m docs.release [VERSION]`` writes version and date, builds and checks wheel and sdist.

With a VERSION, the heading *unreleased* of the changelog becomes that version with its date; without one, what is in
the tree is built. The files are left in ``dist``; nothing is published or tagged.
"""

import argparse
import datetime
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import venv
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SOURCES = ("adaptive_ff", "controllers", "plant")
FILES = ("pyproject.toml", "build_backend.py", "README.md", "LICENSE", "CITATION.cff")
PLACES = {
    "pyproject.toml": r'(?m)^version = "(.*)"$',
    "CITATION.cff": r"(?m)^version: (.*)$",
    "docs/changelog.md": r"(?m)^## (\S+)",
    "README.md": r"control, version (\S+), ",
}
"""Where a version stands, the newest first."""


def versions(root: Path = ROOT) -> dict[str, str]:
    """Return the version that each file names."""
    found = {name: re.search(pattern, (root / name).read_text(encoding="utf-8")) for name, pattern in PLACES.items()}
    return {name: match[1] if match else "none" for name, match in found.items()}


def set_version(version: str, date: datetime.date, root: Path = ROOT) -> None:
    """Write a version wherever one stands, with the date in the changelog.

    Raises
    ------
    ValueError
        It is no version, or the changelog has nothing that is unreleased.
    """
    if not re.fullmatch(r"\d+\.\d+\.\d+((a|b|rc)\d+)?", version):
        raise ValueError(f"version = {version!r} is not allowed: it must be such as 1.2.0 or 1.2.0rc1")
    changelog = root / "docs/changelog.md"
    text, count = re.subn(
        r"(?m)^## \S+ \(unreleased\)$", f"## {version} ({date})", changelog.read_text("utf-8"), count=1
    )
    if not count:
        raise ValueError("docs/changelog.md has no heading '## VERSION (unreleased)': say what is new")
    changelog.write_text(text, encoding="utf-8")
    for name, pattern in PLACES.items():
        old = (root / name).read_text(encoding="utf-8")
        match = re.search(pattern, old)
        if match is not None:
            (root / name).write_text(old[: match.start(1)] + version + old[match.end(1) :], encoding="utf-8")


def build(out: Path) -> tuple[Path, Path]:
    """Build the wheel and the sdist from a copy of the sources, in which no old build folder is; return their files."""
    with tempfile.TemporaryDirectory() as copy:
        for name in SOURCES:
            shutil.copytree(ROOT / name, Path(copy) / name, ignore=shutil.ignore_patterns("__pycache__"))
        for name in FILES:
            shutil.copy(ROOT / name, copy)
        for kind in ("sdist", "wheel"):
            code = f"import build_backend, sys; build_backend.build_{kind}(sys.argv[1])"
            command = [sys.executable, "-c", code, str(out.resolve())]
            done = subprocess.run(command, cwd=copy, capture_output=True, text=True, check=False)
            if done.returncode:
                raise RuntimeError(done.stdout + done.stderr)
    (wheel,), (sdist,) = out.glob("*.whl"), out.glob("*.tar.gz")
    return wheel, sdist


def missing(wheel: Path, sdist: Path) -> list[str]:
    """Return what of the sources is not in the wheel or in the sdist."""
    needed = {path.relative_to(ROOT).as_posix() for name in SOURCES for path in (ROOT / name).rglob("*.py")}
    needed |= {path.relative_to(ROOT).as_posix() for path in (ROOT / "adaptive_ff/scenario").rglob("*.toml")}
    in_wheel = set(zipfile.ZipFile(wheel).namelist())
    with tarfile.open(sdist) as archive:
        in_sdist = {name.partition("/")[2] for name in archive.getnames()}
    return sorted([f"wheel: {name}" for name in needed - in_wheel] + [f"sdist: {name}" for name in needed - in_sdist])


def installed_runs(wheel: Path) -> str:
    """Install the wheel beside the packages of this environment, elsewhere, and return what a comparison prints."""
    with tempfile.TemporaryDirectory() as work:
        venv.create(Path(work) / "venv", with_pip=True)
        python = Path(work) / "venv" / ("Scripts" if os.name == "nt" else "bin") / "python"
        subprocess.run([python, "-m", "pip", "install", "--quiet", "--no-deps", wheel], check=True)
        elsewhere = os.pathsep.join(path for path in sys.path if path and not (Path(path) / "pyproject.toml").is_file())
        command = [python, "-m", "adaptive_ff", "compare", "servo", "--out", "results"]
        environment = {**os.environ, "PYTHONPATH": elsewhere}
        done = subprocess.run(command, cwd=work, env=environment, capture_output=True, text=True, check=True)
        return done.stdout


def main() -> int:
    """Make the release."""
    parser = argparse.ArgumentParser(description="Build and check wheel and sdist, on demand with a new version.")
    parser.add_argument("version", nargs="?", help="new version, such as 1.2.0; by default that of the tree")
    given = parser.parse_args()
    try:
        if given.version:
            set_version(given.version, datetime.datetime.now(tz=datetime.UTC).date())
        found = versions()
        if len(set(found.values())) > 1:
            raise ValueError(f"versions differ: {', '.join(f'{name} {version}' for name, version in found.items())}")
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    shutil.rmtree(ROOT / "dist", ignore_errors=True)
    (ROOT / "dist").mkdir()
    wheel, sdist = build(ROOT / "dist")
    lost = missing(wheel, sdist)
    print(*lost, installed_runs(wheel).rstrip(), f"{wheel.name} and {sdist.name} are in dist", sep="\n")
    return 1 if lost else 0


if __name__ == "__main__":
    sys.exit(main())
