"""Tables in text files: separators, headers, decimal commas, comments and times as people write them."""

import codecs
import csv
import math
import re
import warnings
from array import array
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime, timedelta
from itertools import islice
from pathlib import Path
from typing import NamedTuple, TextIO

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.errors import InputError, counted

MINUS = "\N{MINUS SIGN}"  # of spreadsheets and tables for print, in the place of a hyphen
COMMENT = "#"  # what follows it is a comment; the last one before the numbers may be the header
DAY = timedelta(days=1)
LOOKED_AT = 3  # lines, without comments, that tell how a table is written
UNKNOWN = ("", "nan", "-nan", "+nan")  # cells, in small letters, that say that there is no value
FORTRAN = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+))[dD]([-+]?\d+)")  # a number of double precision: 1.0D+02


class Layout(NamedTuple):
    """How a table is written."""

    names: list[str]  # of its columns
    separator: str  # empty for blanks
    comma: bool  # whether decimals have a comma
    skipped: int  # lines before the first row; none where there is no header
    units: dict[str, str]  # by column, of a row below the header


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Make an ``InputError`` of one line of whatever goes wrong while a file is read."""
    try:
        yield
    except InputError:
        raise
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: cannot be read: it is no text in UTF-8; save it as such") from error
    except Exception as error:  # each format has its own kinds of damage
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise InputError(f"{path}: cannot be read: {reason or type(error).__name__}") from error


def read_table(
    path: Path, wanted: Collection[str], *, complete: bool = False
) -> tuple[Layout, dict[str, NDArray[np.float64]]]:
    """Return how a text file is written, and those of the wanted columns that there are.

    Cells are separated by commas, semicolons, tabs or blanks. Cells without a number become NaN, the first that holds
    words with a warning; ISO times become seconds from the first one. A table that must be complete has a header, and
    a finite number in each cell.

    Raises
    ------
    InputError
        The file cannot be read, a name is there twice, a row of numbers has more cells than the header has names, a
        quote is not closed, or a cell of a complete table is not a finite number.
    """
    with reading(path):
        layout = _layout(path, has_header=complete)
        return layout, _columns(path, layout, [name for name in wanted if name in layout.names], complete=complete)


def _opened(path: Path) -> TextIO:
    """Open a text file: UTF-16 where it begins with the mark of that, else UTF-8."""
    with path.open("rb") as stream:
        is_wide = stream.read(2) in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
    return path.open(newline="", encoding="utf-16" if is_wide else "utf-8-sig")


def _layout(path: Path, *, has_header: bool) -> Layout:
    """Look at the first lines of a file; where it need not have a header, a first line of numbers is none."""
    lines: list[str] = []
    comment, ends = "", []  # of each line that is looked at, the lines of the file until its end
    with _opened(path) as stream:
        for number, line in enumerate(stream, 1):
            if len(lines) == 1 and lines[0].count('"') % 2 == 1:  # a quoted name goes on
                lines, ends = [lines[0] + line], [number]
            elif not line.strip() or line.lstrip().startswith(COMMENT):
                comment = comment if lines else line.strip().lstrip(COMMENT).strip() or comment
            elif len(lines) < LOOKED_AT:
                lines, ends = [*lines, line], [*ends, number]
            else:
                break
    separator = _separator(lines[0]) if lines else ""
    first, *rows = [_cells(line, separator) for line in lines] or [[]]
    if not any(first):
        raise InputError(f"{path}: the file is empty; it must have a header line and rows of numbers")
    if max(map(len, first)) > csv.field_size_limit():
        raise InputError(f"{path}: cannot be read: a name of {max(map(len, first))} characters is none of a column")
    comma = separator != "," and any(_is_decimal(cell) for row in rows for cell in row)
    if has_header or not all(_is_number(cell, comma) for cell in first):
        known = [[_is_number(cell, comma) for cell in row if cell.lower() not in UNKNOWN] for row in rows]
        has_units = not has_header and len(rows) == 2 and known[0] != [] and not any(known[0]) and any(known[1])
        units = {name: unit for name, unit in zip(first, rows[0], strict=False) if unit} if has_units else {}
        return Layout(first, separator, comma, ends[has_units], units)
    names = _cells(comment, _separator(comment))
    names = names if len(names) == len(first) else list(map(str, range(len(first))))
    return Layout(names, separator, comma, 0, {})


def _separator(line: str) -> str:
    """Return what is between the cells of a line: of numbers with decimal commas, no comma."""
    for separator in filter(line.__contains__, (";", "\t", "")):
        cells = _cells(line, separator)
        whole = all(cell == "" or (cell[0] != "," != cell[-1] and _is_number(cell, True)) for cell in cells)
        if len(cells) > 1 and whole and any(map(_is_decimal, cells)):
            return separator
    best = max(",;\t", key=line.count)
    return best if best in line else ""


def _cells(line: str, separator: str) -> list[str]:
    cells = next(csv.reader(line.splitlines(keepends=True), delimiter=separator), []) if separator else line.split()
    return [cell.strip() for cell in cells]


def _is_number(cell: str, comma: bool) -> bool:
    return math.isfinite(_number(cell, comma, Clock()))


def _is_decimal(cell: str) -> bool:
    """Tell whether a cell is a number with a decimal comma."""
    return cell.count(",") == 1 and "." not in cell and _is_number(cell, True)


def _columns(path: Path, layout: Layout, wanted: list[str], *, complete: bool) -> dict[str, NDArray[np.float64]]:
    """Read some columns cell by cell; where the table must be complete, refuse a cell without a finite number."""
    for name in wanted:
        if layout.names.count(name) > 1:
            raise InputError(f"{path}: there are {layout.names.count(name)} columns {name}; there must be one")
    places = {name: layout.names.index(name) for name in wanted}
    values, clock = array("d"), Clock()  # a list of numbers would take eight times the memory
    words, first = 0, ""
    with _opened(path) as stream:
        rows = _rows(islice(stream, layout.skipped, None), layout.separator) if wanted else iter(())
        for number, row in enumerate(rows, 1):
            if "\n" in "".join(row):
                line = number + layout.skipped
                raise InputError(f"{path}: a quote that begins in or after line {line} is not closed in that line")
            beyond = layout.skipped and any(map(str.strip, row[len(layout.names) :]))
            if beyond and any(_is_number(cell, layout.comma) for cell in row):  # else a last line of words
                width = max(place for place, cell in enumerate(row, 1) if cell.strip())
                raise InputError(
                    f"{path}: the header has {counted(len(layout.names), 'name')}, but row {number} has {width} cells: "
                    "a column has no name (of numbers of rows, say), or commas stand for decimal points and between "
                    "columns as well"
                )
            if complete and not any(cell.strip() for cell in row):
                continue
            for name, place in places.items():
                cell = row[place] if place < len(row) else ""
                value = _number(cell, layout.comma, clock)
                values.append(value)
                if value - value == 0.0:  # a finite number
                    continue
                said = f"{name} = {cell[:40]!r} in row {number}"
                if complete:
                    raise InputError(f"{path}: {said} is not allowed: it must be a finite number")
                if value != value and cell.strip().lower() not in UNKNOWN:
                    words += 1
                    first = first or said
    if words:
        others = f" (and so {counted(words - 1, 'other cell')})" if words > 1 else ""
        warnings.warn(f"{path}: {first} is no number{others}; such samples are left out", stacklevel=2)
    table = np.frombuffer(values, dtype=np.float64).reshape(-1, max(1, len(places))).copy()
    return {name: table[:, column] for column, name in enumerate(places)}


def _rows(stream: Iterator[str], separator: str) -> Iterator[list[str]]:
    bare = (line.partition(COMMENT)[0] if COMMENT in line else line for line in stream)
    lines = (line for line in bare if not line.isspace() and line)
    return csv.reader(lines, delimiter=separator) if separator else (line.split() for line in lines)


def _number(cell: str, comma: bool, clock: "Clock") -> float:
    """Return a cell as a number, an ISO time, with its day or without, as seconds of a clock, and all else as NaN."""
    try:
        return math.nan if "_" in cell else float(cell)
    except ValueError:
        text = cell.strip().replace(MINUS, "-")
    text = FORTRAN.sub(r"\1e\2", text.replace(",", ".") if comma else text)
    for read, one in ((float, text), (clock.seconds, cell.strip())):
        with suppress(ValueError):
            return read(one)
    return math.nan


class Clock:
    """Counts seconds from the first time that it is given.

    Seconds since 1970 would be known to 0.2 us only, which at 500 Hz is enough to change what is identified.
    """

    last: datetime | None = None
    since = timedelta()

    def seconds(self, text: str) -> float:
        """Return an ISO time as seconds; one without a zone is taken for UTC, one without a day goes on past midnight.

        Raises
        ------
        ValueError
            The text is no time.
        """
        is_of_day = ":" in text[:3]
        moment = datetime.fromisoformat(f"1970-01-01T{text}" if is_of_day else text)
        moment = moment.replace(tzinfo=moment.tzinfo or UTC)
        step, self.last = moment - (self.last or moment), moment
        self.since += (step + 0.5 * DAY) % DAY - 0.5 * DAY if is_of_day else step
        return self.since.total_seconds()
