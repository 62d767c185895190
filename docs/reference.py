"""API reference as HTML pages, made from the docstrings by pdoc: ``python -m docs.reference`` (extra ``docs``).

Roles such as ``:class:`` become links between the pages. The command ends with status 1 where one names what there is
not, a page warns, or a link leads nowhere.
"""

import argparse
import importlib
import inspect
import pkgutil
import re
import sys
import warnings
from collections.abc import Iterable, Mapping
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pdoc
from pdoc import extract, render

PACKAGES = ("adaptive_ff", "controllers", "plant")
ROLE = re.compile(r":(?:func|class|meth|mod|data|attr):`~?([\w.]+)`")
PAGES = Path(__file__).with_name("pages")


def module_names(packages: Iterable[str] = PACKAGES) -> list[str]:
    """Return all modules of some packages, and the packages."""
    found = []
    for package in packages:
        path = importlib.import_module(package).__path__
        modules = (one.name for one in pkgutil.walk_packages(path, f"{package}."))
        found += [package, *(name for name in modules if not name.rpartition(".")[2].startswith("_"))]
    return found


def resolved(name: str, module: str, owner: str = "") -> str | None:
    """Return the full name of what a docstring links to, seen from its module and class; None where there is none."""
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


def build(names: Iterable[str], out: Path) -> list[str]:
    """Write a page for each module, and return what is wrong with them."""
    convert = render.env.filters["to_markdown"]

    def with_links(context: Any, docstring: str) -> Any:
        module = context["module"].modulename
        return convert(context, ROLE.sub(lambda link: f"`{resolved(link[1], module) or link[1]}`", docstring))

    with_links.jinja_pass_arg = convert.jinja_pass_arg  # type: ignore[attr-defined]
    known: dict[str, None] = {}
    for name in names:
        if name not in known:
            known |= dict.fromkeys(extract.walk_specs([name]))
    render.configure(docformat="numpy", show_source=False)
    render.env.filters["to_markdown"] = with_links
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            pdoc.pdoc(*known, output_directory=out)
    finally:
        render.env.filters["to_markdown"] = convert
    said = [str(one.message) for one in caught if not str(one.message).startswith("The module specification")]
    return said + dead_links(out)


class _Links(HTMLParser):
    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: set[str] = set()
        self.links: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given: Mapping[str, str | None] = dict(attrs)
        self.ids.add(given.get("id") or "")
        if tag == "a" and given.get("href"):
            self.links.append(given["href"] or "")


def dead_links(folder: Path) -> list[str]:
    """Return the links between the pages of a folder that lead nowhere."""
    pages = {path.resolve(): _Links(path.read_text(encoding="utf-8")) for path in folder.rglob("*.html")}
    dead = []
    for path, page in pages.items():
        for link in page.links:
            file, _, place = unquote(link).partition("#")
            target = (path.parent / file).resolve() if file else path
            outside = link.startswith(("http:", "https:"))
            if not outside and (target not in pages or place not in pages[target].ids | {""}):
                dead.append(f"{path.relative_to(folder.resolve())}: {link} leads nowhere")
    return dead


def main() -> int:
    """Write the pages."""
    parser = argparse.ArgumentParser(description="Write the API reference as HTML pages.")
    parser.add_argument("--out", type=Path, default=PAGES, help="folder of the pages; docs/pages by default")
    out = parser.parse_args().out
    names = module_names()
    wrong = dead_roles(names) + build(names, out)
    print(*wrong, f"The first page is {out / 'index.html'}", sep="\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
