"""What is said of a kernel that has no translation."""


class NotTranslatable(ValueError):
    """A kernel, or what stands in it, has no translation; one line says where it stands and what to write instead."""
