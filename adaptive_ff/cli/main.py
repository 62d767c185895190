"""Command line: ``adaptive-ff``.

Every command imports what it needs inside itself, so that ``--help`` answers before numpy or matplotlib are loaded.
"""

import sys
import traceback
import warnings
from io import TextIOWrapper
from typing import Annotated, TextIO

import typer

from adaptive_ff.cli.commission import commission_command
from adaptive_ff.cli.common import with_common_options
from adaptive_ff.cli.compare import compare_command
from adaptive_ff.cli.excite import excite_command
from adaptive_ff.cli.export import export_command
from adaptive_ff.cli.identify import identify_command
from adaptive_ff.cli.matrix import matrix_command
from adaptive_ff.cli.new import new_command
from adaptive_ff.cli.printable import printable
from adaptive_ff.cli.replay import replay_command
from adaptive_ff.cli.scenarios import scenarios_command
from adaptive_ff.cli.score import score_command
from adaptive_ff.cli.sweep import sweep_command
from adaptive_ff.cli.termination import ending_in_order
from adaptive_ff.cli.tune import tune_command
from adaptive_ff.errors import InputError

BAD_INPUT = 2
INTERRUPTED = 130

app = typer.Typer(
    help="Adaptive friction-compensating velocity control of robot and machine joints.",
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
    from adaptive_ff import __version__

    typer.echo(__version__)


app.command("new")(new_command)
app.command("scenarios")(scenarios_command)
for _name, _command in (
    ("compare", compare_command),
    ("matrix", matrix_command),
    ("sweep", sweep_command),
    ("tune", tune_command),
    ("excite", excite_command),
    ("commission", commission_command),
    ("identify", identify_command),
    ("replay", replay_command),
    ("export", export_command),
    ("score", score_command),
):
    app.command(_name)(with_common_options(_command))


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
            status = _refuse(str(error) or type(error).__name__)
        except Exception as error:
            explained = _explained(error)
            if explained is None:
                raise
            status = _refuse(explained) if explained else BAD_INPUT
    sys.exit(status)


def _explained(error: Exception) -> str | None:
    """Return one line about an error that is no defect of the program; None for a defect.

    It is one of usage (empty after help), an own controller that fails, or numbers with which no equations are solved.
    """
    message = getattr(error, "format_message", None)
    if message is not None:
        wrong_value = _wrong_value(error)
        if wrong_value is not None:
            return wrong_value
        context = getattr(error, "ctx", None)
        hint = "" if context is None else f"; {context.command_path} --help shows what is allowed"
        return message().rstrip(".") + hint if message() else ""
    from adaptive_ff.comparison.own import MODULE

    for frame, line in reversed(list(traceback.walk_tb(error.__traceback__))):
        if frame.f_globals.get("__name__", "").startswith(MODULE):
            place = f"{frame.f_code.co_filename}, line {line}, in {frame.f_code.co_name}"
            return f"{place}: {type(error).__name__}: {error}"
    if type(error).__name__ == "LinAlgError":
        return f"numbers are too large, too small or too much alike to compute with ({error})"
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


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    del category, filename, lineno, file, line
    print(f"adaptive-ff: warning: {printable(' '.join(str(message).split()))}", file=sys.stderr)
