"""Tables in text files: separators, headers, decimal commas, comments and times as people write them."""

import csv
import math
import warnings
from array import array
from collections.abc import Collection, Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple, TextIO

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.errors import InputError

SEPARATORS = ",;\t"

COMMENT = "#"
"""Lines that begin with it are comments; the last one before the numbers may be the header."""


class Layout(NamedTuple):
    """How a table is written.

    Attributes
    ----------
    names : list of str
        Columns; their numbers, from zero, where there is no header.
    separator : str
        Between cells; empty for blanks.
    comma : bool
        Whether decimals are written with a comma.
    skipped : int
        Lines before the first row of numbers.
    """

    names: list[str]
    separator: str
    comma: bool
    skipped: int


def read_table(path: Path, wanted: Collection[str]) -> tuple[list[str], dict[str, NDArray[np.float64]]]:
    """Read columns of a text file; cells without a number become NaN, ISO times become seconds.

    Parameters
    ----------
    path : Path
        The file: cells separated by commas, semicolons, tabs or blanks; a header, or none; lines of comments.
    wanted : collection of str
        Columns that are read.

    Returns
    -------
    names : list of str
        All columns.
    columns : dict of ndarray
        The wanted ones among them.
    """
    layout = _layout(path)
    names = [name for name in wanted if name in layout.names]
    for name in names:
        if layout.names.count(name) > 1:
            raise InputError(f"{path}: there are {layout.names.count(name)} columns {name}; there must be one")
    places = [layout.names.index(name) for name in names]
    if not places:
        return layout.names, {}
    table = _read_quickly(path, layout, places)
    if table is None:
        table = _read_cells(path, layout, places)
    return layout.names, {name: table[:, place] for place, name in enumerate(names)}


def _layout(path: Path) -> Layout:
    """Look at the first lines of a file."""
    last_comment, skipped, lines = "", 0, []
    with path.open(newline="", encoding="utf-8-sig") as stream:
        for line in stream:
            if line.strip() and not line.lstrip().startswith(COMMENT):
                lines.append(line)
                if len(lines) == 2:
                    break
            elif not lines:
                skipped += 1
                last_comment = line.strip().lstrip(COMMENT).strip() or last_comment
    if not lines or not any(cell.strip() for cell in _cells(lines[0], _separator(lines[0]))):
        raise InputError(f"{path}: the file is empty; it must have a header line and rows of numbers")
    separator = _separator(lines[0])
    first = [cell.strip() for cell in _cells(lines[0], separator)]
    comma = separator != "," and any(_is_comma_number(cell) for cell in _cells(lines[-1], separator))
    if not all(math.isfinite(_number(cell, comma)) for cell in first):
        return Layout(first, separator, comma, skipped + 1)
    from_comment = [cell.strip() for cell in _cells(last_comment, _separator(last_comment))]
    names = from_comment if len(from_comment) == len(first) else [str(place) for place in range(len(first))]
    return Layout(names, separator, comma, skipped)


def _separator(line: str) -> str:
    best = max(SEPARATORS, key=line.count)
    return best if best in line else ""


def _cells(line: str, separator: str) -> list[str]:
    return next(csv.reader([line], delimiter=separator), []) if separator else line.split()


def _is_comma_number(cell: str) -> bool:
    return cell.count(",") == 1 and "." not in cell and math.isfinite(_number(cell, True))


def _read_quickly(path: Path, layout: Layout, places: list[int]) -> NDArray[np.float64] | None:
    """Read a table that holds nothing but numbers; None where it does not."""
    if layout.comma:
        return None
    with path.open(newline="", encoding="utf-8-sig") as stream:
        try:
            with warnings.catch_warnings(action="ignore"):  # a file without rows is refused later
                return np.loadtxt(
                    stream,
                    comments=COMMENT,
                    delimiter=layout.separator or None,
                    usecols=places,
                    ndmin=2,
                    skiprows=layout.skipped,
                )
        except ValueError:
            return None


def _read_cells(path: Path, layout: Layout, places: list[int]) -> NDArray[np.float64]:
    values = array("d")  # a list of numbers would take eight times the memory
    with path.open(newline="", encoding="utf-8-sig") as stream:
        for _ in range(layout.skipped):
            next(stream)
        for number, row in enumerate(_rows(stream, layout.separator), layout.skipped + 1):
            if any("\n" in cell for cell in row):
                raise InputError(f"{path}: a quote that begins in or after line {number} is not closed in that line")
            values.extend(_number(row[place] if place < len(row) else "", layout.comma) for place in places)
    return np.frombuffer(values, dtype=np.float64).reshape(-1, len(places)).copy()


def _rows(stream: TextIO, separator: str) -> Iterator[list[str]]:
    lines = (line for line in stream if line.strip() and not line.lstrip().startswith(COMMENT))
    return csv.reader(lines, delimiter=separator) if separator else (line.split() for line in lines)


def _number(cell: str, comma: bool) -> float:
    """Return a cell as a number, an ISO time as seconds since 1970, and anything else as NaN."""
    text = cell.replace(",", ".") if comma else cell
    try:
        return math.nan if "_" in text else float(text)
    except ValueError:
        pass
    try:
        moment = datetime.fromisoformat(cell.strip())
    except ValueError:
        return math.nan
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
