"""Numba's cache on disk, with places that depend on the content of the sources and files that processes can share."""

import glob
import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from numba.core import config
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile, _CacheLocator

from controllers.kernel_sources import KERNEL_PACKAGES, package_root


class EntryCache(FunctionCache):
    """The compiled versions of one function, one for each signature.

    Parameters
    ----------
    function : callable
        The plain function.
    directory : Path
        Where to keep them; for a function of the packages it must be named after the content of their sources.
    """

    _impl_class = CompileResultCacheImpl

    def __init__(self, function: Any, directory: Path) -> None:
        previous = config.CACHE_DIR  # type: ignore[attr-defined]
        config.CACHE_DIR = str(directory)  # type: ignore[attr-defined]
        try:
            super().__init__(function)  # type: ignore[no-untyped-call]
        finally:
            config.CACHE_DIR = previous  # type: ignore[attr-defined]
        if _is_ours(function):
            # Numba's locator goes by the place and the time of the file; here the directory stands for its content.
            self._impl._locator = _ByContent(function, directory)
            self._cache_path = self._impl.locator.get_cache_path()
        self._by_signature = _FilesBySignature(
            self._cache_path, self._impl.filename_base, self._impl.locator.get_source_stamp()
        )
        self._cache_file = self._by_signature

    def is_filled(self) -> bool:
        """Tell whether there is machine code on disk, for any signature."""
        return self._by_signature.is_filled()


def _is_ours(function: Any) -> bool:
    path = Path(function.__code__.co_filename).resolve()
    return any(path.is_relative_to(package_root() / package) for package in KERNEL_PACKAGES)


class _ByContent(_CacheLocator):
    """Place of the code of a function of the packages, wherever they are installed."""

    def __init__(self, function: Any, directory: Path) -> None:
        self._py_file = function.__code__.co_filename
        self._path = str(directory / function.__module__)
        self._line = str(function.__code__.co_firstlineno)

    def get_cache_path(self) -> str:
        return self._path

    def get_source_stamp(self) -> str:
        return "content"

    def get_disambiguator(self) -> str:
        return self._line


class _FilesBySignature(IndexDataCacheFile):
    """Files of one function, a pair for each signature.

    Numba keeps one index for all signatures. Two processes that compile different ones at the same time can then
    choose the same name for their data, and a third would load the code of one under the signature of the other.
    """

    def __init__(self, folder: str, base: str, stamp: Any) -> None:
        super().__init__(folder, base, stamp)  # type: ignore[no-untyped-call]
        self._folder, self._base, self._stamp = folder, base, stamp

    def _of(self, key: Any) -> Any:
        name = hashlib.sha256(repr(key).encode()).hexdigest()[:16]
        return IndexDataCacheFile(self._folder, f"{self._base}-{name}", self._stamp)  # type: ignore[no-untyped-call]

    def save(self, key: Any, data: Any) -> None:
        self._of(key).save(key, data)

    def load(self, key: Any) -> Any:
        return self._of(key).load(key)

    def flush(self) -> None:
        for path in self._files():
            path.unlink(missing_ok=True)

    def is_filled(self) -> bool:
        return any(self._files())

    def _files(self) -> Iterator[Path]:
        return Path(self._folder).glob(f"{glob.escape(self._base)}-*")
