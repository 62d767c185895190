import pytest

from controllers import compiled, delay_line, delayed, remember


def through(delay, values):
    line, found = delay_line(delay), []
    for value in values:
        found.append(delayed(line, delay))
        line = remember(line, value)
    return found


def both(line, delay, value):
    return delayed(line, delay), remember(line, value)


@pytest.mark.parametrize(
    ("delay", "expected"),
    [
        (0.0, [0.0, 1.0, 2.0, 4.0, 8.0]),
        (0.25, [0.0, 0.75, 1.75, 3.5, 7.0]),
        (1.0, [0.0, 0.0, 1.0, 2.0, 4.0]),
        (2.5, [0.0, 0.0, 0.0, 0.5, 1.5]),
    ],
)
def test_line_gives_the_mean_of_what_was_applied_over_the_period_that_ends(delay, expected):
    assert through(delay, [1.0, 2.0, 4.0, 8.0, 16.0]) == expected


@pytest.mark.parametrize("delay", [0.0, 0.5, 1.0, 3.0])
def test_line_is_long_enough_for_the_delay_and_compiled_it_is_the_same(delay):
    line = tuple(float(i) for i in range(1, 1 + len(delay_line(delay))))
    assert len(line) == {0.0: 1, 0.5: 3, 1.0: 3, 3.0: 11}[delay]
    assert compiled(both)(line, delay, 9.0) == (delayed(line, delay), remember(line, 9.0))
    assert len(remember(line, 9.0)) == len(line)
