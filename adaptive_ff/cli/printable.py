"""Text from files on its way to a terminal."""


def printable(text: str) -> str:
    """Return a text with what a terminal would obey written out: names of columns come from files."""
    return "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)
