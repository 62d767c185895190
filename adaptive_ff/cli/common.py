"""Options that every command has: ``--quiet`` and ``--tables``; and what they are set to while a command runs."""

import functools
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Any

import typer


class TableForm(StrEnum):
    """How tables are printed."""

    TEXT = "text"
    MARKDOWN = "markdown"
    CSV = "csv"


@dataclass
class Settings:
    """What the options of the running command are.

    Attributes
    ----------
    quiet : bool
        Whether nothing but warnings and errors is printed.
    tables : TableForm
        How tables are printed.
    """

    quiet: bool = False
    tables: TableForm = TableForm.TEXT


SETTINGS = Settings()
"""Of the command that runs; a process runs one at a time."""

Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but warnings and errors.")]
Tables = Annotated[TableForm, typer.Option(help="How tables are printed.")]


def with_common_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Return a command with the common options at the end of its own."""

    @functools.wraps(command)
    def wrapped(*arguments: Any, quiet: bool = False, tables: TableForm = TableForm.TEXT, **options: Any) -> Any:
        SETTINGS.quiet, SETTINGS.tables = quiet, tables
        try:
            return command(*arguments, **options)
        finally:
            SETTINGS.quiet, SETTINGS.tables = False, TableForm.TEXT

    own = inspect.signature(command)
    keyword = inspect.Parameter.KEYWORD_ONLY
    added = [
        inspect.Parameter("quiet", keyword, default=False, annotation=Quiet),
        inspect.Parameter("tables", keyword, default=TableForm.TEXT, annotation=Tables),
    ]
    wrapped.__signature__ = own.replace(parameters=[*own.parameters.values(), *added])  # type: ignore[attr-defined]
    wrapped.__annotations__ = {**command.__annotations__, "quiet": Quiet, "tables": Tables}
    return wrapped
