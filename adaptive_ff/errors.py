"""The error that a user's input causes, as one sentence, and the text of files that may cause it."""

import importlib
import math
import os
import reprlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any


class InputError(ValueError):
    """A scenario, a file or an option is wrong; the message is one line that names what and what is allowed."""


def check_kind(name: str, value: Any, kinds: type | tuple[type, ...], rule: str) -> None:
    """Raise a TypeError for an argument that is of no such kind; the rule says what it must be."""
    if not isinstance(value, kinds):
        raise TypeError(f"{name} = {reprlib.repr(value)} is not allowed: it must be {rule}")


def check_among(name: str, value: Any, there: Iterable[str], where: str = "known") -> None:
    """Raise an InputError for a value, called by a name, that is not among those that there are, which it lists."""
    if value not in there:
        raise InputError(f"{name}{value!r} is not {where}; there are {', '.join(there)}")


def check_positive(**values: float) -> None:
    """Raise an InputError for the first value that is not positive and finite, a TypeError for no number.

    Of several values of one argument, ``NAME[0]``, the argument is named.
    """
    from controllers.checks import check_numbers  # with numpy, which help does without

    for name, value in values.items():
        argument = name.partition("[")[0]
        check_numbers(**{argument: value})
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{argument} = {value:g} is not allowed: it must be positive and finite")


def checked_path(name: str, value: Any) -> Path:
    """Return a path; raise a TypeError for what is none."""
    check_kind(name, value, (str, os.PathLike), "a path")
    return Path(value)


def library(name: str, task: str = "") -> Any:
    """Return a module of a library that need not be there.

    Raises
    ------
    InputError
        It is not installed; the message says for which task it is needed, and how to install it.
    """
    try:
        return importlib.import_module(name)
    except ImportError as error:
        package = name.partition(".")[0].replace("mcap_ros2", "mcap-ros2-support")
        needed = f"{task} takes {package}, which" if task else package
        raise InputError(f"{needed} is not installed: pip install {package}") from error


def sentence(words: str) -> str:
    """Return words that begin small and have no full stop, as those of an error, as a sentence."""
    return f"{words[0].upper()}{words[1:]}."


def counted(number: int, noun: str) -> str:
    """Return a number with a noun: ``1 sample``, ``2 samples``."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def read_text(path: Path, wrong: str, encoding: str = "utf-8") -> str:
    """Return the text of a file.

    Parameters
    ----------
    path : Path
        The file.
    wrong : str
        What is said of a file that is no text, before what is wrong and in which line.
    encoding : str, optional
        UTF-8, or that with a mark at the beginning.

    Raises
    ------
    InputError
        The file cannot be read, or is no text.
    """
    try:
        return path.read_text(encoding=encoding)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        byte, line = error.object[error.start], error.object.count(b"\n", 0, error.start) + 1
        raise InputError(f"{path}: {wrong}: byte 0x{byte:02x} in line {line} is no text in UTF-8") from error
    except ValueError as error:  # no file can have that name
        raise InputError(f"{path}: {wrong}: {error}") from error
