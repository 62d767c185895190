"""Compiled kernels: those that came with the package, and others, compiled when they are first asked for and kept.

So is the extension that calls them faster than ctypes. Each file is named after what it was made of.
"""

import atexit
import ctypes
import hashlib
import os
import pickle
import shutil
import stat
import sys
import sysconfig
import tempfile
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Hashable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from typing import Any, NamedTuple

from controllers.kernels.compiler import FLAGS, SUFFIX, NoCompiler, compile_files, compiler
from controllers.kernels.entry import file_text, library_unit
from controllers.kernels.record import Translation, translation
from controllers.kernels.types import Type

KEPT_DAYS = 30
"""Days for which code is kept that nobody has asked for."""


@cache
def translator_key() -> str:
    """Return a hash of the translation itself: what another one made is not used."""
    digest = hashlib.sha256(sys.platform.encode())
    for path in sorted(Path(__file__).parent.glob("*.[cp]*")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


BUILT = Path(__file__).parent / f"built-{translator_key()}"
"""Where the compiled kernels are that came with the package, if any did."""


@cache
def cache_directory() -> Path:
    """Return the directory of this translation, which is made where there is none."""
    directory = _writable_root() / f"kernels-{translator_key()}"
    directory.mkdir(parents=True, exist_ok=True)
    os.utime(directory)
    return directory


def clear_old() -> None:
    """Remove what nobody has used for :data:`KEPT_DAYS`."""
    oldest = time.time() - KEPT_DAYS * 86400
    for path in cache_directory().parent.glob("*"):
        if path.stat().st_mtime < oldest:
            shutil.rmtree(path, ignore_errors=True)
    for path in cache_directory().iterdir():
        with suppress(OSError):
            if path.is_file() and path.stat().st_mtime < oldest:
                path.unlink()


def _writable_root() -> Path:
    for root in _possible_roots():
        try:
            root.mkdir(parents=True, exist_ok=True, mode=0o700)
            with tempfile.TemporaryFile(dir=root):
                return root
        except OSError:
            continue
    made = tempfile.mkdtemp(prefix="adaptive-ff-")
    atexit.register(shutil.rmtree, made, ignore_errors=True)  # nobody would find it again
    return Path(made)


def _possible_roots() -> Iterator[Path]:
    """Yield where the cache may be, the best place first; a container has no home, or none that it can write."""
    base = os.environ.get("ADAPTIVE_FF_CACHE") or os.environ.get("XDG_CACHE_HOME")
    if base:
        yield Path(base) / "adaptive-ff"
    with suppress(RuntimeError):  # neither HOME nor an entry of the user
        yield Path.home() / ".cache" / "adaptive-ff"
    # one for all processes of a user; compiled code is run, so it must not be another user's
    user = os.getuid() if hasattr(os, "getuid") else 0
    shared = Path(tempfile.gettempdir()) / f"adaptive-ff-{user}"
    with suppress(OSError):
        shared.mkdir(mode=0o700, exist_ok=True)
        found = shared.lstat()
        if stat.S_ISDIR(found.st_mode) and found.st_uid == user and not found.st_mode & 0o022:
            yield shared


STEPPER = Path(__file__).with_name("_stepper.c")
EXTENSION_FLAGS = ["-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden"]
EXTENSION_FLAGS += ["-undefined", "dynamic_lookup"] if sys.platform == "darwin" else []

Writer = Callable[[Any], tuple[str, Type | None]]
"""Writes entry points for a unit, and says what the kernel gives."""


class Loaded(NamedTuple):
    """A library in this process, and what a kernel in it gives."""

    library: Any
    result: Type | None

    def address(self, symbol: str) -> int:
        """Return where a function lies; zero where there is none of that name."""
        function = getattr(self.library, symbol, None)
        return 0 if function is None else int(ctypes.cast(function, ctypes.c_void_p).value or 0)


_LOADED: dict[Hashable, Loaded] = {}
_LOCKS: defaultdict[Hashable, threading.Lock] = defaultdict(threading.Lock)
"""Threads compile different kernels at once, and each of them once."""


_WANTED: list[dict[str, Writer]] = []
"""Where what is asked for is collected; empty where it is compiled."""


@contextmanager
def collected() -> Iterator[dict[str, Writer]]:
    """Collect the kernels that are asked for, by symbol, in place of compiling them: all runs as plain Python."""
    _WANTED.append({})
    try:
        yield _WANTED[-1]
    finally:
        _WANTED.pop()


def loaded(key: Hashable, symbol: str, write: Writer) -> Loaded:
    """Return a library that holds a symbol."""
    if _WANTED:
        _WANTED[-1][symbol] = write
        raise NoCompiler(f"{symbol} is to be compiled together with others")
    if key not in _LOADED:
        with _LOCKS[key]:
            if key not in _LOADED:
                _LOADED[key] = _kept(symbol) or _compiled(symbol, write)
    return _LOADED[key]


def is_kept(name: str = "*") -> bool:
    """Tell whether a kernel (of a name) has been compiled for any arguments, by this process or an earlier one."""
    return any(any(folder.glob(f"{name.strip('_')}_*.record")) for folder in folders())


def folders() -> list[Path]:
    """Return where compiled kernels may be: those that came with the package, and those compiled on this machine."""
    return [*([BUILT] if BUILT.is_dir() else []), cache_directory()]


@cache
def _opened(path: Path) -> Any:
    return ctypes.CDLL(str(path))


def _kept(symbol: str) -> Loaded | None:
    """Return a library that holds a symbol, made of what is there now; none where there is none."""
    for folder in folders():
        for record in sorted(folder.glob(f"{symbol}-*.record"), key=_age):
            with suppress(OSError):  # another process may have removed it
                found = _read(record.read_bytes())
                if found is not None and (folder / found.library).exists() and found.holds():
                    _keep(record, folder / found.library)
                    return Loaded(_opened(folder / found.library), found.result)
    return None


def _age(path: Path) -> float:
    with suppress(OSError):
        return -path.stat().st_mtime
    return 0.0


def _read(content: bytes) -> Translation | None:
    """Return what was written of a translation; none where it is cut off, or its classes are no longer there."""
    with suppress(AttributeError, ImportError, EOFError, TypeError, ValueError, pickle.UnpicklingError):
        found: Translation = pickle.loads(content)
        return found
    return None


def _keep(*paths: Path) -> None:
    for path in paths:
        with suppress(OSError):
            os.utime(path)


def _compiled(symbol: str, write: Writer) -> Loaded:
    if BUILT.is_dir():
        print(f"kernels are new or have changed: compiling {symbol.rpartition('_')[0]}", file=sys.stderr)
    clear_old()
    library, (made,) = compile_kernels({symbol: write})
    return Loaded(_opened(library), made.result)


def compile_kernels(writers: Mapping[str, Writer]) -> tuple[Path, list[Translation]]:
    """Compile kernels to one library, in which they share what they call; keep it and what each was made of."""
    folder, unit = cache_directory(), library_unit()
    texts, made = [], []
    for write in writers.values():
        unit.files, unit.meanings = set(), {}
        text, result = write(unit)
        texts.append(text)
        made.append(translation(unit, result))
    whole = file_text(unit, texts)
    key = hashlib.sha256(f"{compiler()} {FLAGS} {whole}".encode()).hexdigest()[:16]
    library = folder / f"{next(iter(writers))}-{key}{SUFFIX}"
    if not library.exists():
        with tempfile.TemporaryDirectory(dir=folder) as place:
            source = Path(place, "kernels.c")
            source.write_text(whole, encoding="ascii")
            compile_files([source], library, [*FLAGS, "-shared"])
    for symbol, each in zip(writers, made, strict=True):
        content = pickle.dumps(each._replace(library=library.name))
        record = folder / f"{symbol}-{hashlib.sha256(content).hexdigest()[:16]}.record"
        part = record.with_name(f"{record.name}.{os.getpid()}.part")
        part.write_bytes(content)
        os.replace(part, record)
    return library, made


@cache
def stepper() -> Any:
    """Return the extension; None where it cannot be had, and ctypes does the same more slowly."""
    name = f"_stepper-{hashlib.sha256(STEPPER.read_bytes()).hexdigest()[:16]}.so"
    library = next((folder / name for folder in folders() if (folder / name).exists()), cache_directory() / name)
    try:
        if not library.exists():
            include = sysconfig.get_path("include")
            if not Path(include, "Python.h").exists():
                return None
            compile_files([STEPPER], library, [*EXTENSION_FLAGS, f"-I{include}"])
        loader = ExtensionFileLoader("_stepper", str(library))
        spec = spec_from_loader("_stepper", loader)
        assert spec is not None
        module = module_from_spec(spec)
        loader.exec_module(module)
    except (ImportError, NoCompiler, OSError):
        return None
    return module
