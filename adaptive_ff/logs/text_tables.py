"""Tables in text files: separators, headers, decimal commas, comments and times as people write them."""

import codecs
import csv
import math
import re
import warnings
from array import array
from collections.abc import Collection, Iterator
from datetime import UTC, date, datetime, time, timedelta
from itertools import islice
from pathlib import Path
from typing import NamedTuple, TextIO

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.errors import InputError, counted

SEPARATORS = ",;\t"

MINUS = "\N{MINUS SIGN}"
"""Sign that spreadsheets and tables for print have before numbers in the place of a hyphen."""

COMMENT = "#"
"""Lines that begin with it are comments; the last one before the numbers may be the header."""

NO_DAY = date(1970, 1, 1)
"""Day of a time that is given without one."""

UNKNOWN = ("", "nan", "-nan", "+nan")
"""Cells, in small letters, that say that there is no value."""

FORTRAN = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+))[dD]([-+]?\d+)")
"""A number as Fortran writes one of double precision: 1.0D+02."""

NO_TEXT = "cannot be read: it is no text in UTF-8; save it as such"
"""What is said of a table that is no text."""


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
    units : tuple of str
        Words in a row of units below the header; empty without one.
    is_headed : bool
        Whether the names are those of a header, beyond which there must be no cell.
    """

    names: list[str]
    separator: str
    comma: bool
    skipped: int
    units: tuple[str, ...] = ()
    is_headed: bool = False


def encoding_of(path: Path) -> str:
    """Return how a text file is written: UTF-16 where it begins with the mark of that, else UTF-8."""
    with path.open("rb") as stream:
        return "utf-16" if stream.read(2) in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE) else "utf-8-sig"


def read_table(path: Path, wanted: Collection[str]) -> tuple[list[str], dict[str, NDArray[np.float64]]]:
    """Read columns of a text file; cells without a number become NaN, ISO times become seconds from the first one.

    The first cell that holds words, where one does, is told with a warning.

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

    Raises
    ------
    InputError
        A name is there twice, a row of numbers has more cells than the header has names, or a quote is not closed.
    """
    layout = _layout(path)
    names = [name for name in wanted if name in layout.names]
    for name in names:
        _check_unique(path, layout.names, name)
    places = [layout.names.index(name) for name in names]
    if not places:
        return layout.names, {}
    table = _read_quickly(path, layout, places)
    if table is None:
        table = _read_cells(path, layout, places)
    return layout.names, {name: table[:, place] for place, name in enumerate(names)}


def table_units(path: Path) -> dict[str, str]:
    """Return the units that a row below the header of a text file gives, by column; none without such a row."""
    layout = _layout(path)
    return {name: unit for name, unit in zip(layout.names, layout.units, strict=False) if unit}


def read_complete_table(path: Path, required: list[str], one_of: list[str]) -> dict[str, NDArray[np.float64]]:
    """Read columns of a text file with a header, in which every cell must be a finite number.

    Parameters
    ----------
    path : Path
        The file, written as :func:`read_table` takes it.
    required : list of str
        Columns that must be there.
    one_of : list of str
        Columns of which at least one must be there.

    Returns
    -------
    dict of ndarray
        The columns found, of equal length.

    Raises
    ------
    InputError
        The file cannot be read, a column is missing, or a value is not a finite number.
    """
    try:
        layout = _layout(path, has_header=True)
        with path.open(newline="", encoding=encoding_of(path)) as stream:
            for _ in range(layout.skipped):
                next(stream)
            rows = [row for row in _rows(stream, layout.separator) if any(cell.strip() for cell in row)]
    except InputError:
        raise
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: {NO_TEXT}") from error
    except (OSError, csv.Error, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise InputError(f"{path}: cannot be read: {reason}") from error
    names = layout.names
    if any(name not in names for name in required) or not any(name in names for name in one_of):
        need = f"{', '.join(required)} and {' or '.join(one_of)}"
        shown = " ".join(", ".join(names).split())
        raise InputError(f"{path}: the columns are {shown[:80]}; there must be {need}")
    for number, row in enumerate(rows, start=1):
        if any(cell.strip() for cell in row[len(names) :]):
            raise InputError(f"{path}: row {number} has {len(row)} cells; the header has {len(names)}")
    wanted = [name for name in required + one_of if name in names]
    for name in wanted:
        _check_unique(path, names, name)
    return {name: _finite_column(path, name, rows, layout) for name in wanted}


def _check_unique(path: Path, names: list[str], name: str) -> None:
    if names.count(name) > 1:
        raise InputError(f"{path}: there are {names.count(name)} columns {name}; there must be one")


def _finite_column(path: Path, name: str, rows: list[list[str]], layout: Layout) -> NDArray[np.float64]:
    place, values = layout.names.index(name), np.empty(len(rows))
    for number, row in enumerate(rows):
        cell = row[place] if place < len(row) else ""
        values[number] = _number(cell, layout.comma)
        if not math.isfinite(values[number]):
            raise InputError(
                f"{path}: {name} = {cell[:40]!r} in row {number + 1} is not allowed: it must be a finite number"
            )
    return values


def _layout(path: Path, *, has_header: bool = False) -> Layout:
    """Look at the first lines of a file; where it need not have a header, a first line of numbers is none."""
    last_comment, skipped, is_open = "", 0, False
    header: list[str] = []
    lines: list[str] = []
    ends: list[int] = []  # lines of the file until the end of each
    with path.open(newline="", encoding=encoding_of(path)) as stream:
        for number, line in enumerate(stream, 1):
            if is_open or (line.strip() and not line.lstrip().startswith(COMMENT)):
                if len(lines) == 3:
                    break
                header.append(line)
                is_open = not lines and is_open != line.count('"') % 2  # a quoted name goes on in the next line
                if not is_open:
                    lines.append("".join(header))
                    ends.append(number)
                    header = []
            elif not lines:
                skipped += 1
                last_comment = line.strip().lstrip(COMMENT).strip() or last_comment
    if header:
        lines.append("".join(header))
        ends.append(skipped + len(header))
    if not lines or not any(cell.strip() for cell in _cells(lines[0], _separator(lines[0]))):
        raise InputError(f"{path}: the file is empty; it must have a header line and rows of numbers")
    separator = _separator(lines[0])
    first = [cell.strip() for cell in _cells(lines[0], separator)]
    longest = max(map(len, first))
    if longest > csv.field_size_limit():
        raise InputError(f"{path}: cannot be read: a name of {longest} characters is none of a column")
    rows = [[cell.strip() for cell in _cells(line, separator)] for line in lines[1:]]
    comma = separator != "," and any(_is_comma_number(cell) for row in rows for cell in row)
    if has_header or not all(math.isfinite(_number(cell, comma)) for cell in first):
        units = tuple(rows[0]) if not has_header and _are_units(rows, comma) else ()
        return Layout(first, separator, comma, ends[1] if units else ends[0], units, is_headed=True)
    from_comment = [cell.strip() for cell in _cells(last_comment, _separator(last_comment))]
    names = from_comment if len(from_comment) == len(first) else [str(place) for place in range(len(first))]
    return Layout(names, separator, comma, skipped)


def _are_units(rows: list[list[str]], comma: bool) -> bool:
    """Tell whether the first of two rows below a header holds words alone, and the second one a number."""
    if len(rows) < 2:
        return False
    words, numbers = ([cell for cell in row if cell.lower() not in UNKNOWN] for row in rows)
    return (
        bool(words and numbers)
        and not any(math.isfinite(_number(cell, comma)) for cell in words)
        and any(math.isfinite(_number(cell, comma)) for cell in numbers)
    )


def _separator(line: str) -> str:
    """Return what is between the cells of a line: of numbers with decimal commas, no comma."""
    for separator in (";", "\t", ""):
        cells = [cell.strip() for cell in _cells(line, separator)] if separator in line else []
        if len(cells) > 1 and any(map(_is_comma_number, cells)) and all(map(_is_number_with_comma, cells)):
            return separator
    best = max(SEPARATORS, key=line.count)
    return best if best in line else ""


def _cells(line: str, separator: str) -> list[str]:
    return next(csv.reader(line.splitlines(keepends=True), delimiter=separator), []) if separator else line.split()


def _is_comma_number(cell: str) -> bool:
    return cell.count(",") == 1 and "." not in cell and math.isfinite(_number(cell, True))


def _is_number_with_comma(cell: str) -> bool:
    """Tell whether a cell is a number, or none, where decimals are written with a comma: 1,5 or 2, but not 1, or ,5."""
    return cell == "" or (cell[0] != "," != cell[-1] and math.isfinite(_number(cell, True)))


def _read_quickly(path: Path, layout: Layout, places: list[int]) -> NDArray[np.float64] | None:
    """Read a table that holds nothing but numbers; None where it does not."""
    if layout.comma:
        return None
    with path.open(newline="", encoding=encoding_of(path)) as stream:
        try:
            with warnings.catch_warnings(action="ignore"):  # a file without rows is refused later
                return np.loadtxt(
                    _checked_lines(path, stream, layout),
                    comments=COMMENT,
                    delimiter=layout.separator or None,
                    usecols=places,
                    ndmin=2,
                )
        except InputError:
            raise
        except ValueError:
            return None


def _checked_lines(path: Path, stream: TextIO, layout: Layout) -> Iterator[str]:
    """Return the lines below the header, of which none has more cells than the header."""
    for _ in range(layout.skipped):
        next(stream)
    separator, most = layout.separator, len(layout.names) - 1
    for place, line in enumerate(stream):
        if (line.count(separator) if separator else len(line.split(None, most + 1)) - 1) > most:
            row = _cells(line.partition(COMMENT)[0], separator)
            if _is_too_wide(layout, row):
                raise InputError(f"{path}: {_too_wide(layout, _row_number(path, layout, place), row)}")
        yield line


def _row_number(path: Path, layout: Layout, place: int) -> int:
    """Return the number, from one, of the row in a line so many lines below the header."""
    with path.open(newline="", encoding=encoding_of(path)) as stream:
        lines = islice(stream, layout.skipped, layout.skipped + place + 1)
        return sum(not (line.isspace() or line.lstrip().startswith(COMMENT)) for line in lines)


def _is_too_wide(layout: Layout, row: list[str]) -> bool:
    """Tell whether a row has a cell beyond those of the header, and a number: a last line of words is none."""
    if not layout.is_headed or not any(cell.strip() for cell in row[len(layout.names) :]):
        return False
    return any(math.isfinite(_number(cell, layout.comma)) for cell in row)


def _too_wide(layout: Layout, number: int, row: list[str]) -> str:
    width = max(place for place, cell in enumerate(row, 1) if cell.strip())
    return (
        f"the header has {counted(len(layout.names), 'name')}, but row {number} has {width} cells: a column has no "
        "name (of numbers of rows, say), or commas stand for decimal points and between columns as well"
    )


def _read_cells(path: Path, layout: Layout, places: list[int]) -> NDArray[np.float64]:
    values, clock = array("d"), Clock()  # a list of numbers would take eight times the memory
    words, first = 0, ""
    with path.open(newline="", encoding=encoding_of(path)) as stream:
        for _ in range(layout.skipped):
            next(stream)
        for number, row in enumerate(_rows(stream, layout.separator), 1):
            if any("\n" in cell for cell in row):
                line = number + layout.skipped
                raise InputError(f"{path}: a quote that begins in or after line {line} is not closed in that line")
            if _is_too_wide(layout, row):
                raise InputError(f"{path}: {_too_wide(layout, number, row)}")
            for place in places:
                cell = row[place] if place < len(row) else ""
                values.append(_number(cell, layout.comma, clock))
                if math.isnan(values[-1]) and cell.strip().lower() not in UNKNOWN:
                    words += 1
                    first = first or f"{layout.names[place]} = {cell[:40]!r} in row {number}"
    if words:
        others = f" (and so {counted(words - 1, 'other cell')})" if words > 1 else ""
        warnings.warn(f"{path}: {first} is no number{others}; such samples are left out", stacklevel=2)
    return np.frombuffer(values, dtype=np.float64).reshape(-1, len(places)).copy()


def _rows(stream: TextIO, separator: str) -> Iterator[list[str]]:
    lines = (line for line in stream if line.strip() and not line.lstrip().startswith(COMMENT))
    return csv.reader(lines, delimiter=separator) if separator else (line.split() for line in lines)


def _number(cell: str, comma: bool, clock: "Clock | None" = None) -> float:
    """Return a cell as a number, an ISO time, with its day or without, as seconds of a clock, and all else as NaN."""
    text = cell.replace(MINUS, "-")
    text = text.replace(",", ".") if comma else text
    try:
        return math.nan if "_" in text else float(text)
    except ValueError:
        pass
    if fortran := FORTRAN.fullmatch(text.strip()):
        return float("e".join(fortran.groups()))
    try:
        moment = _moment(cell.strip())
    except ValueError:
        return math.nan
    return (clock or Clock()).seconds(moment)


def _moment(text: str) -> datetime:
    """Return an ISO time; one without a day is of the first of 1970."""
    if ":" in text[:3]:
        return datetime.combine(NO_DAY, time.fromisoformat(text))
    return datetime.fromisoformat(text)


class Clock:
    """Counts seconds from the first time that it is told.

    Seconds since 1970 would be known to 0.2 us only, which at 500 Hz is enough to change what is identified.
    """

    def __init__(self) -> None:
        self._begin: datetime | None = None
        self._last: datetime | None = None
        self._days = timedelta()

    def seconds(self, moment: datetime) -> float:
        """Return a time as seconds; one without a zone is taken for UTC."""
        known = moment if moment.tzinfo else moment.replace(tzinfo=UTC)
        if known.date() == NO_DAY:  # past midnight they begin anew
            if self._last is not None and known + self._days < self._last - timedelta(hours=12):
                self._days += timedelta(days=1)
            self._last = known = known + self._days
        self._begin = self._begin or known
        return (known - self._begin).total_seconds()
