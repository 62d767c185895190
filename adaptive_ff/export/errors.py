"""What is said of a kernel or a controller that cannot be exported, or compiled."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

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


@contextmanager
def compiled(texts: Mapping[str, str], flags: Sequence[str] = ()) -> Iterator[Path]:
    """Write exported files, compile those that are sources, and yield the shared library, which is there meanwhile."""
    with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        files = [Path(folder, name) for name in texts]
        for file, text in zip(files, texts.values(), strict=True):
            file.write_text(text, encoding="ascii")
        library = Path(folder, "library.so")
        try:
            compile_files([file for file in files if file.suffix == ".c"], library, [*FLAGS, "-shared", *flags])
        except NoCompiler as error:
            raise InputError(str(error)) from error
        yield library
