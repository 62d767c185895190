"""Command line: ``adaptive-ff``.

Every command imports what it needs inside itself, so that ``--help`` answers before numpy or matplotlib are loaded.
"""

import multiprocessing
import signal
import sys
import threading
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from io import TextIOWrapper
from types import FrameType
from typing import Annotated, Any

import typer

import adaptive_ff
from adaptive_ff.cli.commission import commission_command, excite_command
from adaptive_ff.cli.compare import compare_command
from adaptive_ff.cli.export import export_command, new_command, playground_command
from adaptive_ff.cli.identify import identify_command, replay_command, score_command
from adaptive_ff.cli.options import command
from adaptive_ff.cli.output import printable
from adaptive_ff.cli.studies import matrix_command, scenarios_command, sweep_command, tune_command
from adaptive_ff.errors import InputError

BAD_INPUT, INTERRUPTED, TERMINATED = 2, 130, 128 + signal.SIGTERM
"""Exit statuses, the last of a command that was asked to end."""

app = typer.Typer(
    help="Adaptive friction-compensating velocity control of robot and machine joints.",
    epilog="Terms, such as settled, over pi, oracle: the glossary of the documentation (docs/glossary.md).",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(asked: bool) -> None:
    if asked:
        version_command()
        raise typer.Exit


@app.callback()
def _application(
    version: Annotated[
        bool, typer.Option("--version", "-V", help="Print the version.", callback=_print_version, is_eager=True)
    ] = False,
) -> None:
    """Adaptive friction-compensating velocity control of robot and machine joints."""


@app.command("version")
def version_command() -> None:
    """Print the version."""
    typer.echo(adaptive_ff.__version__)


for _command in (
    *(new_command, scenarios_command, compare_command, matrix_command, sweep_command, tune_command),
    *(excite_command, commission_command, identify_command, replay_command, export_command, score_command),
    playground_command,
):
    app.command(_command.__name__.removesuffix("_command"))(command(_command))


def main() -> None:
    """Run the command line; bad input ends it with status 2 and one line."""
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # a terminal may not know all characters
    with warnings.catch_warnings(), ending_in_order():
        warnings.showwarning = _show_warning
        try:
            status = app(standalone_mode=False)
        except KeyboardInterrupt:
            status = INTERRUPTED
        except (InputError, ArithmeticError, MemoryError, OSError) as error:
            cause = error.__cause__ if isinstance(error.__cause__, ArithmeticError) else error
            status = _refuse(_own_failure(cause) or str(error) or type(error).__name__)
        except Exception as error:
            explained = _explained(error)
            if explained is None:
                raise
            status = _refuse(explained) if explained else BAD_INPUT
    sys.exit(status)


@contextmanager
def ending_in_order() -> Iterator[None]:
    """Let a signal that asks to end do so by ``SystemExit``, so that half-written files are removed.

    A second one ends the process at once. Where somebody else handles the signal, or ignores it, it is left to them.
    """
    default = signal.SIG_DFL
    if threading.current_thread() is not threading.main_thread() or signal.getsignal(signal.SIGTERM) != default:
        yield
        return
    signal.signal(signal.SIGTERM, _end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, default)


def _end(number: int, frame: FrameType | None) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    for worker in multiprocessing.active_children():  # Ctrl-C reaches them, this does not; nobody waits for results
        worker.terminate()
    raise SystemExit(TERMINATED)


def _explained(error: Exception) -> str | None:
    """Return one line about an error that is no defect of the program; None for a defect.

    It is one of usage (empty after help), an own controller that fails, or numbers with which no equations are solved.
    """
    message = getattr(error, "format_message", None)
    if message is not None:
        if wrong_value := _wrong_value(error):
            return wrong_value
        context = getattr(error, "ctx", None)
        hint = "" if context is None else f"; {context.command_path} --help shows what is allowed"
        return message().rstrip(".") + hint if message() else ""
    if failure := _own_failure(error):
        return failure
    if type(error).__name__ == "LinAlgError":
        return f"numbers are too large, too small or too much alike to compute with ({error})"
    if type(error).__name__ == "BrokenProcessPool":
        return "a worker process ended: it was stopped, or there is too little memory for as many (--workers)"
    return None


def _own_failure(error: BaseException) -> str | None:
    """Return one line about an error in the code of an own controller, with its place; None for one elsewhere."""
    from adaptive_ff.comparison.own import MODULE

    for frame, line in reversed(list(traceback.walk_tb(error.__traceback__))):
        if frame.f_globals.get("__name__", "").startswith(MODULE):
            place = f"{frame.f_code.co_filename}, line {line}, in {frame.f_code.co_name}"
            return f"{place}: {type(error).__name__}: {error}"
    return None


def _wrong_value(error: Exception) -> str | None:
    """Return one line about the value of an option that pydantic refused, with the value; None for another error.

    Where typer leaves its values to click, click's own message names them.
    """
    from pydantic import ValidationError

    parameter = getattr(error, "param", None)
    if parameter is None or not isinstance(error.__cause__, ValidationError):
        return None
    from adaptive_ff.scenario.validation import explain_option

    return explain_option(max(parameter.opts, key=len), error.__cause__)


def _refuse(message: str) -> int:
    print(f"adaptive-ff: {printable(' '.join(message.split()))}", file=sys.stderr)
    return BAD_INPUT


def _show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    print(f"adaptive-ff: warning: {printable(' '.join(str(message).split()))}", file=sys.stderr)
