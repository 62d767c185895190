"""Text files of an export from their templates, ``templates/*.jinja``, in which they can be read as they are."""

from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader("adaptive_ff.export"),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def rendered(name: str, **values: Any) -> str:
    """Return a file of an export by the name of its template, with the values that stand in it."""
    return _environment().get_template(f"{name}.jinja").render(values)
