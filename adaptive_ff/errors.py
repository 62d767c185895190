"""The error that a user's input causes, as one sentence."""


class InputError(ValueError):
    """A scenario, a file or an option is wrong; the message is one line that names what and what is allowed."""
