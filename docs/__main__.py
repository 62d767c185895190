"""Build the site: ``python -m docs [--out FOLDER] [--without-running]`` (extra ``docs``)."""

import argparse
import os
import sys
from pathlib import Path

from sphinx.cmd.build import build_main

HERE = Path(__file__).resolve().parent


def main() -> int:
    """Write the site as HTML, all of it anew; a warning is an error."""
    parser = argparse.ArgumentParser(description="Build the site as HTML.")
    parser.add_argument("--out", type=Path, default=HERE / "_build" / "html", help="folder of the pages")
    parser.add_argument("--without-running", action="store_true", help="run neither notebooks nor examples")
    given = parser.parse_args()
    without = ["-D", "nb_execution_mode=off", "-D", "plot_gallery=0"] if given.without_running else []
    os.environ["PATH"] = str(Path(sys.executable).parent) + os.pathsep + os.environ["PATH"]  # for commands in notebooks
    status = build_main(
        [
            "-E",
            "-W",
            "--keep-going",
            "-q",
            "-d",
            str(given.out.parent / "doctrees"),
            *without,
            str(HERE),
            str(given.out),
        ]
    )
    print(f"The first page is {given.out / 'index.html'}")
    return status


if __name__ == "__main__":
    sys.exit(main())
