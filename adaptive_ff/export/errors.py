"""What is said of a kernel or a controller that cannot be exported."""

from adaptive_ff.errors import InputError


class NotExportable(InputError):
    """A controller, or a construct in one of its kernels, has no translation; one line says where and what to write."""
