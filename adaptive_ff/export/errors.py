"""What is said of a kernel or a controller that cannot be exported, or compiled."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from adaptive_ff.errors import InputError
from controllers.kernels.compiler import FLAGS, NoCompiler, compile_files
from controllers.kernels.language import NotTranslatable


class NotExportable(InputError):
    """A controller, or a construct in one of its kernels, has no translation; one line says where and what to write."""


@contextmanager
def exporting() -> Iterator[None]:
    """Say of what has no translation that it cannot be exported."""
    try:
        yield
    except NotTranslatable as error:
        raise NotExportable(f"cannot be exported: {error}") from error


def compile_export(sources: Sequence[Path], library: Path, flags: Sequence[str] = ()) -> None:
    """Compile exported sources into a shared library."""
    try:
        compile_files(sources, library, [*FLAGS, "-shared", *flags])
    except NoCompiler as error:
        raise InputError(str(error)) from error
