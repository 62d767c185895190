"""Pages show what stored results hold, and nothing else with a decimal point."""

import tomllib

import pytest

from adaptive_ff.errors import InputError
from benchmarks.compare import geometric_mean
from benchmarks.pages import BASELINE, ROOT, TABLE, filled_numbers, number_of, pages, rendered, typed_numbers
from benchmarks.quantities import missed, quantity, shown
from benchmarks.results import LARGEST, RESULTS, Result, Row
from benchmarks.suite import Suite

ALLOWED = tomllib.loads((ROOT / "benchmarks" / "typed.toml").read_text(encoding="utf-8"))
"""Numbers that pages may show although no result holds them, by page."""

LARGEST_SHARE = 0.03
"""Of all numbers in the pages, how many may be typed by hand."""

RESULT = Result("made", "", "", 0.0, "", {}, {"one": Row([1, 2, 3], {"own": {"settled": [2.0, 8.0, 0.5]}})})


PAGES = {page.relative_to(ROOT).as_posix(): page.read_text(encoding="utf-8") for page in pages()}


def test_pages_are_as_they_are_filled():
    assert [name for name, text in PAGES.items() if rendered(text) != text] == []


def test_few_numbers_are_typed_by_hand_and_lists_hold_those_that_pages_show():
    typed = {name: typed_numbers(text) for name, text in PAGES.items()}
    unlisted = {name: set(numbers) - set(ALLOWED.get(name, [])) for name, numbers in typed.items()}
    assert {name: numbers for name, numbers in unlisted.items() if numbers} == {}
    assert all(set(numbers) <= set(typed[name]) for name, numbers in ALLOWED.items())
    count = sum(map(len, typed.values()))
    assert count <= LARGEST_SHARE * (count + sum(map(filled_numbers, PAGES.values())))


def test_few_words_are_written_by_hand():
    """A reader has an hour; what is more belongs into a docstring, which the reference shows."""
    words = {name: len(TABLE.sub("", text).split()) for name, text in PAGES.items()}
    longest = max((count, name) for name, count in words.items() if name.startswith("docs/"))
    assert sum(words.values()) <= 15_000
    assert sum(count for name, count in words.items() if name.startswith("benchmarks/")) <= 2_500
    assert words["README.md"] <= 900
    assert len(PAGES["README.md"].splitlines()) <= 150
    assert longest <= (900, longest[1])


def test_typed_numbers_are_found_beside_what_is_filled_and_what_is_code():
    text = "at 1.5 or `2.5`, <!--= a/b/c.d median -->3.5<!--/-->, [4.5](5.5.md), version 1.2.3, 7 of 10"
    assert typed_numbers(text) == ["1.5", "4.5"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("own.settled median", 2.0),
        ("own.settled least", 0.5),
        ("own.settled most*1000", 8000.0),
        ("own.settled count", 3),
        ("own.settled below:0.95", 1),
        ("own.settled above:1.2", 2),
        ("own.settled geometric", geometric_mean([2.0, 8.0, 0.5])),
        ("other.settled median", None),
    ],
)
def test_quantities(text, expected):
    assert quantity(RESULT, "one", text) == pytest.approx(expected)


def test_quantities_that_are_none_are_refused():
    with pytest.raises(InputError, match="no stored result holds it"):
        number_of("matrix/no such row/adaptive.settled median")
    with pytest.raises(InputError, match=r"write 'controller\.figure statistic'"):
        quantity(RESULT, "one", "settled")
    with pytest.raises(InputError, match="statistic = 'middle' is not known"):
        quantity(RESULT, "one", "own.settled middle")


def test_what_misses_its_target_is_said_of_rows_inside_the_contract():
    targets = {"*": {"own.settled least": 0.95}, "o*": {"own.settled median": 1.5}}
    assert missed(Suite("made", "", [], targets=targets), RESULT, "one") == ["settled 0.5 < 0.95"]
    assert missed(Suite("made", "", [], targets=targets, outside=["one"]), RESULT, "one") == []


def test_numbers_are_shown_with_three_digits():
    numbers = (0.12345, 1234.5, 12.0, None, float("inf"))
    assert [shown(value) for value in numbers] == ["0.123", "1230", "12", "-", "failed"]


def test_stored_results_are_small():
    files = [*RESULTS.glob("*.json"), *BASELINE.glob("*.json")]
    assert files
    assert max(file.stat().st_size for file in files) <= LARGEST
