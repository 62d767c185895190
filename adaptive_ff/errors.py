"""The error that a user's input causes, as one sentence."""


def no_text(error: UnicodeDecodeError) -> str:
    """Return what is wrong with a file, read as a whole, that is no text, and in which line."""
    line = error.object.count(b"\n", 0, error.start) + 1
    return f"byte 0x{error.object[error.start]:02x} in line {line} is no text in UTF-8"


class InputError(ValueError):
    """A scenario, a file or an option is wrong; the message is one line that names what and what is allowed."""
