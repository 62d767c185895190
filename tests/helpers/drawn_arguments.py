"""Functions and methods on arguments drawn by their annotations, and a digest of what they give or refuse."""

import collections.abc
import dataclasses
import hashlib
import importlib
import inspect
import math
import pkgutil
import re
import types
import typing
from functools import cache, partial

import numpy as np

FIRST, DRAWS = 16, 40  # how often a function is called, and how often further where one call was no error

LEFT_OUT = """.kernels. .native. .state .estimates. .feed. adaptive.step. .learn. .observe. .loop. .experiment.
    ._interval_end. ._gap. .split_over_paths. ._kalman_filter. .PIDesign. .loop_systems. .fastest_bandwidth."""
"""What calls addresses, searches, or takes arrays that are sorted or belong together; runs reach it."""

SIGNS = (1.0, 1.0, 1.0, -1.0)
SPECIAL = 20 * (0.0,) + 15 * (1.0,) + 7 * (-1.0, 0.5) + 5 * (math.nan,)
"""Numbers at which branches turn; others are drawn of all sizes from 0.01 to 100."""

SERIES = 24  # length of a series

NAMES = ("inertia", "coulomb", "viscous", "offset", "gravity_sin", "ripple_cos_2", "regressor_1", "friction_lag")

ANYTHING = (float, float, str, bool, int, np.ndarray, list[float], dict[str, float], type(None))

MAPPINGS = (dict, collections.abc.Mapping)
SEQUENCES = (list, collections.abc.Sequence, collections.abc.Iterable)


class Draws:
    """Draws of numpy's generator of a seed, from its words: a call of the generator itself takes microseconds."""

    def __init__(self, seed):
        self._source = np.random.default_rng(seed).bit_generator  # whose state goes with it
        words = self._source.ctypes
        self.random = partial(words.next_double, words.state)
        self._word = partial(words.next_uint32, words.state)

    def below(self, limit):
        return self._word() * limit >> 32 if limit > 1 else 0

    def one_of(self, values):
        return values[self.below(len(values))]


def number(draws):
    if draws.random() < 0.35:
        return draws.one_of(SPECIAL)
    return draws.one_of(SIGNS) * 10.0 ** (4.0 * draws.random() - 2.0)


@cache
def fields_of(record):
    """Return the annotations of a record's fields by name, or None for what is none."""
    if isinstance(record, type) and (issubclass(record, tuple) or dataclasses.is_dataclass(record)):
        names = getattr(record, "_fields", None) or [f.name for f in dataclasses.fields(record) if f.init]
        hints = typing.get_type_hints(record)
        return {name: hints[name] for name in names}
    return None


def drawn(annotation, draws):
    """Return a value of an annotation."""
    if annotation is float:
        return number(draws)
    if annotation is bool:
        return draws.random() < 0.5
    if annotation is int:
        return draws.below(6 if draws.random() < 0.8 else 300)
    if annotation is str:
        return draws.one_of(NAMES)
    if annotation is typing.Any:
        return drawn(draws.one_of(ANYTHING), draws)
    origin, inner = typing.get_origin(annotation), typing.get_args(annotation)
    if origin in MAPPINGS:
        return {name: drawn(inner[1], draws) for name in NAMES[: draws.below(len(NAMES))]}
    if origin in SEQUENCES:
        return [drawn(inner[0], draws) for _ in range(1 + draws.below(4))]
    if origin is typing.Literal:
        return draws.one_of(inner)
    if any(name in str(annotation) for name in ("ndarray", "NDArray", "ArrayLike")):
        series = np.array([number(draws) for _ in range(SERIES)])
        return series if draws.random() < 0.1 else np.nan_to_num(series)  # a hole is mostly refused
    if origin is tuple:
        kinds = [inner[0]] * 4 if inner[-1] is ... else inner
        return tuple(drawn(kind, draws) for kind in kinds)
    if origin in (typing.Union, types.UnionType):
        return drawn(draws.one_of(inner), draws)
    if annotation is type(None):
        return None
    annotation = getattr(annotation, "Parameters", annotation)  # for which a controller stands
    fields = fields_of(annotation)
    if not fields:
        raise TypeError(f"there is no rule for {annotation}")
    return annotation(**{name: drawn(kind, draws) for name, kind in fields.items()})


def functions_of(room):
    """Yield the functions of a package by name, and the methods of its records."""
    package = importlib.import_module(room)
    for found in pkgutil.walk_packages(package.__path__, f"{room}."):
        module = importlib.import_module(found.name)
        for name, function in list(vars(module).items()):
            left_out = any(part in f".{found.name}.{name}." for part in LEFT_OUT.split())
            if left_out or getattr(function, "__module__", "") != module.__name__:
                continue
            if inspect.isfunction(function) and function.__name__ == name:
                yield f"{found.name.removeprefix(room)[1:]}.{name}", function, {}
            for method, member in vars(function).items() if inspect.isclass(function) else ():
                member = getattr(member, "fget", member)
                if inspect.isfunction(member) and member.__code__.co_filename == module.__file__:
                    yield f"{found.name.removeprefix(room)[1:]}.{name}.{method}", member, {"self": function}


def plain(value):
    """Return the words of a result: numbers to six digits, and names."""
    if isinstance(value, float | int | np.number) and not isinstance(value, bool):
        return [f"{float(value):.6g}" if abs(value) > 1e-9 or value != value else "0"]
    if isinstance(value, np.ndarray):
        value = value.ravel().tolist()
    elif isinstance(value, dict):
        value = value.items()
    elif dataclasses.is_dataclass(value):
        value = [getattr(value, one.name) for one in dataclasses.fields(value)]
    elif isinstance(value, bool | np.bool_ | str | type(None)):
        return [str(value)]
    elif not isinstance(value, tuple | list):
        return [type(value).__name__]
    return [word for one in value for word in plain(one)]


def digest(words):
    return hashlib.sha256("\n".join(words).encode()).hexdigest()[:8]


def outcome(function, kinds, draws):
    """Return the words of a call, of what is given back, refused and made of its arguments; none of an error."""
    arguments = {name: drawn(kind, draws) for name, kind in kinds.items()}
    try:
        return [*plain(function(**arguments)), *plain(list(arguments.values()))]
    except Exception as error:
        said = re.sub(r"\d+\.\d+", lambda one: f"{float(one[0]):.5g}", str(error))
        return [type(error).__name__, said] if "is not allowed" in said else []


def digests(room):
    """Return a digest of each function of a package for which there are arguments, by name."""
    found = {}
    for name, function, owner in functions_of(room):
        try:
            kinds = owner | typing.get_type_hints(function)
            del kinds["return"]
            draws = Draws(101)
            with np.errstate(all="ignore"):
                calls = [outcome(function, kinds, draws) for _ in range(FIRST)]
                calls += [outcome(function, kinds, draws) for _ in range(DRAWS) if any(calls)]
        except (NameError, KeyError, TypeError):  # of a type that only a checker knows, or without one
            continue
        if any(calls):
            found[name] = digest([word for words in calls for word in words])
    return found
