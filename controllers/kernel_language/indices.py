"""Indices that cannot be negative."""


def natural(index: int) -> int:
    """Return an index that is not negative: compiled code then need not test whether it counts from the end."""
    return index
