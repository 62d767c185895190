"""Benchmarks: ``python -m benchmarks run SUITE``, ``compare``, ``stale``, ``pages``, ``list``."""

import fnmatch
import os
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from adaptive_ff.cli.cluster import workers as cluster
from adaptive_ff.cli.options import Scheduler
from adaptive_ff.cli.output import error_console, progress_bars
from adaptive_ff.errors import InputError
from benchmarks.compare import HEADINGS, MOVED_HEADINGS, compared_controllers, moved_lines, summary_lines
from benchmarks.pages import ROOT, filled_numbers, numbers_by_hand, pages, rendered, stored, typed_numbers
from benchmarks.results import RESULTS, read_result
from benchmarks.running import BASE, run_suite, suite_fingerprint
from benchmarks.suite import load_suite, suite_names

WIDTH = 190  # of the tables of a comparison where the output is no terminal, characters
TRIAL = RESULTS / "trial"  # where results of runs go that differ from what a suite says; not committed

app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False)
Suites = Annotated[list[str] | None, typer.Argument(help="Suites; all by default.", show_default=False)]
Stale = Annotated[bool, typer.Option("--stale", help="Of these only those without a result of the tree's code.")]


@app.command("list")
def list_command() -> None:
    """Print what each suite asks."""
    for name in suite_names():
        print(f"{name:20s} {load_suite(name).title}")


@app.command()
def run(
    suites: Suites = None,
    only_stale: Stale = False,
    seeds: Annotated[int | None, typer.Option(min=1, help="Number of references or draws of each kind.")] = None,
    first: Annotated[int | None, typer.Option(min=0, help="First seed; 101 and more while tuning.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="One case of each kind.")] = False,
    only: Annotated[str, typer.Option(help="Cases whose name matches, such as 'lugre*'.")] = "",
    controllers: Annotated[str, typer.Option(help="Controllers beside pi, separated by commas.")] = "",
    named: Annotated[str, typer.Option("--as", help="Name that a single controller gets in the result.")] = "",
    workers: Annotated[int, typer.Option(min=1, help="Processes.")] = os.cpu_count() or 1,
    out: Annotated[Path | None, typer.Option(help="Folder for the results.")] = None,
    scheduler: Scheduler = None,
) -> None:
    """Run suites, the quickest first, and write their results; an interrupted call goes on where it stopped."""
    altered = bool(seeds or first is not None or quick or only or controllers)
    folder, failed = out or (TRIAL if altered else RESULTS), False
    names = sorted(suites or suite_names(), key=lambda name: getattr(stored(name), "seconds", 0.0))
    if only_stale:
        names = [name for name in names if stale_since(name) is not None]
    with cluster(scheduler) as executor, progress_bars(error_console()) as bars:
        for place, name in enumerate(names, 1):
            task = bars.add_task(f"{name} ({place} of {len(names)})", total=1.0)
            try:
                suite = load_suite(name)
                cases = suite.generated(count=seeds, first=first, quick=quick)
                cases = [case for case in cases if not only or fnmatch.fnmatchcase(case.key, f"{only}*")]
                if not cases:
                    raise InputError(f"--only = {only!r} matches no case of {name}")
                chosen = [BASE, *(one for one in controllers.split(",") if one)] if controllers else suite.controllers
                options: dict[str, Any] = {"named": named or None, "workers": workers, "executor": executor}
                options["progress"] = lambda fraction, task=task: bars.update(task, completed=fraction)
                result = run_suite(suite, cases, list(dict.fromkeys(chosen)), **options)
                file = result.write(folder)
            except Exception as error:  # whatever it is, the other suites do not end for it
                if len(names) == 1:
                    raise
                print(f"benchmarks: {name}: {error}", file=sys.stderr)
                failed = True
            else:
                what = f"{name} ({place} of {len(names)}): {len(cases)} cases, {len(result.refused)} refused"
                print(f"{what}, {result.seconds:g} s, {file}", flush=True)
            bars.remove_task(task)
    raise typer.Exit(1 if failed else 0)


def stale_since(name: str) -> str | None:
    """Return the commit of a result that other code computed than the tree's, empty where there is none, or None."""
    result = stored(name)
    if result is None:
        return ""
    return None if result.fingerprint == suite_fingerprint(load_suite(name)) else result.commit


@app.command()
def compare(
    first: Annotated[Path, typer.Argument(help="Folder of results, such as benchmarks/results/9787daa.")],
    second: Annotated[Path, typer.Argument(help="Another one.")] = RESULTS,
    suites: Annotated[str, typer.Option(help="Suites, separated by commas; by default all that both have.")] = "",
    controllers: Annotated[str, typer.Option(help="Controllers, separated by commas; by default all.")] = "",
) -> None:
    """Print what became better and what worse from one folder of results to another."""
    table = Table(*HEADINGS, title=f"{first} -> {second}, PI's error over the controller's")
    moved = Table(*MOVED_HEADINGS, title="medians that moved by more than a tenth")
    there = (file.stem for file in sorted(first.glob("*.json")) if (second / file.name).is_file())
    for name in suites.split(",") if suites else there:
        before, after = read_result(first, name), read_result(second, name)
        if before is None or after is None:
            raise InputError(f"--suites: {name!r} has no result in {first if before is None else second}")
        suite = load_suite(name)
        chosen = controllers.split(",") if controllers else compared_controllers(before, after)
        for shown, lines in ((table, summary_lines), (moved, moved_lines)):
            for line in lines(suite, before, after, chosen):
                shown.add_row(*line)
    console = Console(width=None if sys.stdout.isatty() else WIDTH)
    console.print(table)
    if moved.row_count:
        console.print(moved)


@app.command()
def stale() -> None:
    """Name the suites whose stored result was computed by other code than that of the tree."""
    for name in suite_names():
        commit = stale_since(name)
        if commit is not None:
            print(f"{name}: computed at {commit}" if commit else f"{name}: has no result")


@app.command("pages")
def pages_command(
    check: Annotated[bool, typer.Option("--check", help="Change nothing; exit 1 where a page differs.")] = False,
) -> None:
    """Fill the tables and numbers of all pages from the stored results."""
    different = 0
    for page in pages():
        text = page.read_text(encoding="utf-8")
        filled = rendered(text)
        if filled != text:
            different += 1
            print(f"{page.relative_to(ROOT)}: {'is not as filled' if check else 'filled'}")
            if not check:
                page.write_text(filled, encoding="utf-8")
    texts = [page.read_text(encoding="utf-8") for page in pages()]
    hand, decimals = (sum(len(find(text)) for text in texts) for find in (numbers_by_hand, typed_numbers))
    count = sum(map(filled_numbers, texts))
    print(f"numbers by hand: {hand} ({decimals} of them decimals) of {hand + count}, {hand / (hand + count):.1%}")
    raise typer.Exit(1 if check and different else 0)


def main() -> None:
    """Run a command; bad input ends it with one line and status 2."""
    try:
        app()
    except InputError as error:
        print(f"benchmarks: {error}", file=sys.stderr)
        raise SystemExit(2) from error


if __name__ == "__main__":
    main()
