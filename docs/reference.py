"""The generated pages of the reference, from the code: Python, command line, scenario file, log formats, warnings.

Nothing of it is stored; ``docs/conf.py`` writes them before Sphinx reads its pages.
"""

import importlib
import inspect
import pkgutil
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

import click
import typer
from pydantic import BaseModel
from pydantic_core import PydanticUndefined

from adaptive_ff.adaptive.diagnosis import WARNINGS
from adaptive_ff.cli.main import app
from adaptive_ff.comparison.registry import CONTROLLERS, FIXED, make_controller
from adaptive_ff.logs.formats import READERS
from adaptive_ff.report.diagnosis import SENTENCES
from adaptive_ff.report.log_words import SAYS
from adaptive_ff.report.verdicts import LIMITS
from adaptive_ff.scenario.scenario import Scenario, load_scenario

PACKAGES = ("adaptive_ff", "controllers", "plant")
FACES = {
    "adaptive_ff": "compare, simulate, identify, export; the adaptive controller.",
    "controllers": "What closes the loop without identifying anything, its design, and what yours are made of.",
    "plant": "What is simulated.",
}
"""Packages whose names are public, each with what it offers."""

ROLE = re.compile(r":(?:func|class|meth|mod|data|attr):`~?([\w.]+)`")
GENERATED = "_generated"
EXTRAS = {"_read_hdf5": "hdf5", "_read_parquet": "parquet", "_read_mcap": "mcap", "_read_bag": "rosbags"}
"""Extra that a reader of logs needs."""


def write_reference(folder: Path) -> None:
    """Write the generated pages into a folder."""
    folder.mkdir(exist_ok=True)
    for stub in (folder / "api").glob("*.rst"):  # of a name that is there no longer
        module, _, name = stub.stem.rpartition(".")
        if not hasattr(importlib.import_module(module), name):
            stub.unlink()
    pages = {
        "api": api(),
        "command_line": command_line(),
        "controllers": controllers(),
        "scenario": scenario_fields(),
        "log_formats": log_formats(),
        "warnings": warning_codes(),
    }
    for name, text in pages.items():
        file = folder / f"{name}.md"
        if not file.is_file() or file.read_text(encoding="utf-8") != text:  # Sphinx reads again what is newer
            file.write_text(text, encoding="utf-8")


def write_examples(source: Path, folder: Path) -> None:
    """Copy the scripts of a folder with a title on each, as the gallery wants it."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "GALLERY_HEADER.rst").write_text("Scripts\n=======\n", encoding="utf-8")
    for file in source.glob("*.py"):
        title = file.stem.replace("_", " ").capitalize()
        text = file.read_text(encoding="utf-8").replace('"""', f'"""\n{title}\n{"=" * len(title)}\n\n', 1)
        (folder / file.name).write_text(text, encoding="utf-8")


def api() -> str:
    """Return a table of the public names of each package, with a page for each function and class."""
    text = "# Python\n\nWhat the packages offer by name. Everything else is internal and may change.\n"
    for package, offer in FACES.items():
        face = importlib.import_module(package)
        names = [name for name in face.__all__ if callable(getattr(face, name)) and not _is_alias(getattr(face, name))]
        listed = "\n".join(f"   ~{package}.{name}" for name in sorted(names))
        text += f"\n## {package}\n\n{offer}\n\n```{{eval-rst}}\n.. autosummary::\n   :toctree: api\n\n{listed}\n```\n"
    return text


def _is_alias(value: Any) -> bool:
    """Tell whether a name stands for a type that has no page of its own."""
    return get_origin(value) is not None or not getattr(value, "__module__", "").startswith(PACKAGES)


def command_line() -> str:
    """Return the arguments and options of each command, as typer knows them."""
    group = typer.main.get_command(app)
    context = click.Context(group, info_name="adaptive-ff")
    text = ""
    for name in group.list_commands(context):  # type: ignore[attr-defined]
        command = group.get_command(context, name)  # type: ignore[attr-defined]
        rows = [_option(parameter) for parameter in command.params if _is_listed(parameter)]
        text += f"## {name}\n\n{command.help}\n\n" + (_table(("option", "default", "meaning"), rows) if rows else "")
    return text


def controllers() -> str:
    """Return the controllers of a comparison by name, those with a fixed model apart, with their control laws."""
    scenario = load_scenario()
    laws = {one: inspect.getdoc(type(make_controller(scenario, one))) or "" for one in CONTROLLERS if one not in FIXED}
    rows = [(f"`{name}`", law.splitlines()[0].replace("``", "`")) for name, law in laws.items()]
    return _table(("name", "control law"), rows)


def _is_listed(parameter: Any) -> bool:
    return parameter.name != "help" and not getattr(parameter, "hidden", False)


def _option(parameter: Any) -> tuple[str, str, str]:
    written = ", ".join(parameter.opts) if parameter.param_type_name == "option" else parameter.name.upper()
    plain = parameter.default if isinstance(parameter.default, str | int | float | Path) else None
    default = "" if plain is False or plain in (None, "") else f"`{plain}`"
    return f"`{written}`", default, getattr(parameter, "help", None) or ""


def scenario_fields() -> str:
    """Return the fields of each table of a scenario, with type, default and unit."""
    text = f"## Top level\n\n{_fields(Scenario, plain=True)}"
    for name, field in Scenario.model_fields.items():
        for table in _tables(field.annotation):
            kind = table.model_fields.get("kind")
            named = "" if kind is None else f', `kind = "{get_args(kind.annotation)[0]}"`'
            title = f"[[{name}]]" if "list" in str(field.annotation) else f"[{name}]"
            text += f"## {title}{named}\n\n{inspect.getdoc(table).splitlines()[0]}\n\n{_fields(table)}"
    return text


def _tables(annotation: Any) -> Iterator[type[BaseModel]]:
    if inspect.isclass(annotation) and issubclass(annotation, BaseModel):
        yield annotation
    elif get_origin(annotation) in (Annotated, Union, UnionType, list):
        for part in get_args(annotation):
            yield from _tables(part)


def _fields(table: type[BaseModel], plain: bool = False) -> str:
    said = described(table)
    rows = []
    for name, field in table.model_fields.items():
        if name == "kind" or (plain and any(_tables(field.annotation))):
            continue
        default = "needed" if field.default is PydanticUndefined else f"`{field.default}`".replace("`None`", "")
        rows.append((f"`{name}`", default, said.get(name, "")))
    return _table(("field", "default", "meaning"), rows)


def described(owner: type) -> dict[str, str]:
    """Return what the docstrings of a class and its bases say of each parameter."""
    found: dict[str, str] = {}
    for base in reversed(owner.__mro__):
        section = re.search(
            r"^(?:Parameters|Attributes)\n-+\n(.*?)(?=^\w[^\n]*\n-{3,}|\Z)", _doc(base), re.DOTALL | re.MULTILINE
        )
        for names, text in re.findall(
            r"^(\w[\w, ]*) : [^\n]*\n((?:    [^\n]*\n?|\n)+)", section[1] if section else "", re.MULTILINE
        ):
            found |= {name.strip(): " ".join(text.split()) for name in names.split(",")}
    return {name: ROLE.sub(r"`\1`", text).replace("``", "`") for name, text in found.items()}


def _doc(owner: type) -> str:
    return inspect.cleandoc(owner.__doc__ or "") + "\n"


def log_formats() -> str:
    """Return the formats of logs, and the extra that each needs."""
    endings: dict[str, list[str]] = {}
    for ending, reader in READERS.items():
        endings.setdefault(reader.__name__, []).append(f"`{ending}`")
    rows = [
        (", ".join(found), f'`pip install ".[{EXTRAS[reader]}]"`' if reader in EXTRAS else "nothing")
        for reader, found in endings.items()
    ]
    return _table(("ending", "needs"), rows)


def warning_codes() -> str:
    """Return the codes of a diagnosis, an identification and a verdict, with their sentences."""
    blank = re.compile(r"\{(\w+)[^}]*\}")
    diagnosis = [
        (f"`{code}`", "warning" if code in WARNINGS else "", blank.sub(r"*\1*", text))
        for code, text in SENTENCES.items()
    ]
    identified = [(f"`{code}`", text) for code, text in SAYS.items()]
    limits = [(f"`{code}`", what, step) for code, (what, step) in LIMITS.items()]
    return (
        f"## Of the adaptive controller\n\n{_table(('code', '', 'sentence'), diagnosis)}"
        f"## Of an identification: why a parameter is not identified\n\n{_table(('code', 'sentence'), identified)}"
        f"## Of a verdict: what most of the error is due to\n\n{_table(('code', 'limit', 'next'), limits)}"
    )


def _table(heads: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [
        heads,
        ("---",) * len(heads),
        *(tuple(cell.replace("|", "\\|").replace("\n", " ") for cell in row) for row in rows),
    ]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n\n"


def module_names(packages: Iterable[str] = PACKAGES) -> list[str]:
    """Return all modules of some packages, and the packages."""
    found = []
    for package in packages:
        path = importlib.import_module(package).__path__
        modules = (one.name for one in pkgutil.walk_packages(path, f"{package}."))
        found += [package, *(name for name in modules if not name.rpartition(".")[2].startswith("_"))]
    return found


def resolved(name: str, module: str, owner: str = "") -> str | None:
    """Return the full name of what a docstring links to, from its module and class; None where there is none."""
    package = module.partition(".")[0]
    for start in (f"{module}.{owner}" if owner else module, module, package, ""):
        full = f"{start}.{name}".strip(".")
        place = _place(full)
        if place is not None:
            return place
    return None


def _place(full: str) -> str | None:
    """Return where something is defined, as MODULE.NAME; None where it cannot be found."""
    parts = full.split(".")
    for count in range(len(parts), 0, -1):
        try:
            found: Any = importlib.import_module(".".join(parts[:count]))
        except ImportError:
            continue
        for part in parts[count:]:
            if part in getattr(found, "__annotations__", {}) and not hasattr(found, part):
                return full
            if not hasattr(found, part):
                return None
            found = getattr(found, part)
        defined = getattr(found, "__module__", None), getattr(found, "__qualname__", None)
        return ".".join(defined) if None not in defined and callable(found) else full
    return None


def dead_roles(names: Iterable[str]) -> list[str]:
    """Return the links in the docstrings of modules that lead nowhere, with their place."""
    dead = []
    for name in names:
        module = importlib.import_module(name)
        for owner, text in _docstrings(module):
            dead += [f"{name}: {link}" for link in ROLE.findall(text) if resolved(link, name, owner) is None]
    return dead


def _docstrings(module: Any) -> Iterable[tuple[str, str]]:
    yield "", module.__doc__ or ""
    for name, one in list(vars(module).items()):
        if getattr(one, "__module__", None) != module.__name__:
            continue
        yield name if inspect.isclass(one) else "", inspect.getdoc(one) or ""
        for member in list(vars(one).values()) if inspect.isclass(one) else ():
            yield name, getattr(member, "__doc__", None) or ""
