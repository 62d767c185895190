"""Functions of numbers, records and series on arguments drawn by their annotations, and a digest of what they give."""

import dataclasses
import hashlib
import importlib
import inspect
import math
import pkgutil
import types
import typing
from functools import cache

import numpy as np

DRAWS = 24

LEFT_OUT = ".design. .kernels. .native. .state .estimates. .feed. adaptive.step. .learn. .observe."
"""Modules whose functions call addresses, search, or take records of arrays that belong together; runs reach them."""

SPECIAL = (0.0, 1.0, -1.0, 0.5, math.nan)
"""Numbers at which branches turn; others are drawn of all sizes from 0.01 to 100."""

SERIES = 24  # length of a series


class Undrawable(Exception):
    """There is no rule for an annotation."""


def number(generator):
    if generator.random() < 0.25:
        return float(generator.choice(SPECIAL, p=(0.4, 0.3, 0.14, 0.14, 0.02)))
    return float(generator.choice((1.0, 1.0, 1.0, -1.0)) * 10.0 ** generator.uniform(-2.0, 2.0))


@cache
def fields_of(record):
    """Return the annotations of a record's fields by name, or None for what is none."""
    if isinstance(record, type) and (issubclass(record, tuple) or dataclasses.is_dataclass(record)):
        names = getattr(record, "_fields", None) or [f.name for f in dataclasses.fields(record) if f.init]
        hints = typing.get_type_hints(record)
        return {name: hints[name] for name in names}
    return None


def drawn(annotation, generator):
    """Return a value of an annotation."""
    origin, inner = typing.get_origin(annotation), typing.get_args(annotation)
    if annotation is float:
        return number(generator)
    if annotation is bool:
        return bool(generator.random() < 0.5)
    if annotation is int:
        return int(generator.integers(0, 6))
    if origin is typing.Literal:
        return inner[generator.integers(len(inner))]
    if "ndarray" in str(annotation) or "NDArray" in str(annotation):
        return np.array([number(generator) for _ in range(SERIES)])
    if origin is tuple:
        kinds = [inner[0]] * 4 if inner[-1] is ... else inner
        return tuple(drawn(kind, generator) for kind in kinds)
    if origin in (typing.Union, types.UnionType):
        return drawn(inner[generator.integers(len(inner))], generator)
    if annotation is type(None):
        return None
    fields = fields_of(annotation)
    if not fields:
        raise Undrawable(annotation)
    return annotation(**{name: drawn(kind, generator) for name, kind in fields.items()})


def functions_of(room):
    """Yield the functions of a package by name, those of its classes apart."""
    package = importlib.import_module(room)
    for found in pkgutil.walk_packages(package.__path__, f"{room}."):
        if any(name in f".{found.name}." for name in LEFT_OUT.split()):
            continue
        module = importlib.import_module(found.name)
        for name, function in list(vars(module).items()):
            if inspect.isfunction(function) and function.__module__ == module.__name__ and function.__name__ == name:
                yield f"{found.name.removeprefix(room)[1:]}.{name}", function


def plain(value):
    """Yield the words of a result: numbers to six digits, and names."""
    if isinstance(value, bool | np.bool_ | str | type(None)):
        yield str(value)
    elif isinstance(value, int | float | np.number):
        yield f"{float(value):.6g}" if abs(value) > 1e-9 or value != value else "0"
    elif isinstance(value, np.ndarray):
        for one in value.ravel():
            yield from plain(one)
    elif isinstance(value, dict):
        yield from plain(list(value.items()))
    elif isinstance(value, tuple | list):
        for one in value:
            yield from plain(one)
    elif dataclasses.is_dataclass(value):
        yield from plain([getattr(value, one.name) for one in dataclasses.fields(value)])
    else:
        yield type(value).__name__


def digest(words):
    return hashlib.sha256("\n".join(words).encode()).hexdigest()[:8]


def outcome(function, kinds, generator):
    """Yield the words of a call: of what is given back, of the error, and of the series that are changed."""
    arguments = {name: drawn(kind, generator) for name, kind in kinds.items()}
    try:
        yield from plain(function(**arguments))
    except Exception as error:
        yield type(error).__name__
    yield from plain([value for value in arguments.values() if isinstance(value, np.ndarray)])


def digests(room):
    """Return a digest of each function of a package for which there are arguments, by name."""
    found = {}
    for name, function in functions_of(room):
        try:
            kinds = typing.get_type_hints(function)
            del kinds["return"]
            generator = np.random.default_rng(101)
            with np.errstate(all="ignore"):
                words = [word for _ in range(DRAWS) for word in outcome(function, kinds, generator)]
        except (NameError, KeyError, TypeError, Undrawable):  # of a type that only a checker knows, or without one
            continue
        if kinds:
            found[name] = digest(words)
    return found
