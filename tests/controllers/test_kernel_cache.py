import importlib.util
import sys

import numba
import pytest
from numba.core.caching import IndexDataCacheFile

from controllers import is_cached
from controllers.kernel_cache import EntryCache, _FilesBySignature

SOURCE = "def twice(value):\n    return 2 * value\n"


@pytest.fixture
def load(tmp_path, monkeypatch):
    """Load a user's file as a process that starts anew would, with its function cached in a folder."""

    def loaded(source=SOURCE):
        path = tmp_path / "own_kernel.py"
        path.write_text(source)
        spec = importlib.util.spec_from_file_location("own_kernel", path)
        module = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, "own_kernel", module)
        spec.loader.exec_module(module)
        entry = numba.njit(module.twice)
        entry._cache = EntryCache(entry.py_func, tmp_path / "cache")
        return entry

    return loaded


def hits(entry):
    return sum(entry.stats.cache_hits.values())


def test_second_process_loads_each_signature(load):
    first = load()
    assert (first(2), first(2.5)) == (4, 5.0)
    assert hits(first) == 0
    again = load()
    assert (again(2), again(2.5)) == (4, 5.0)
    assert hits(again) == 2


def test_edited_function_of_a_user_is_compiled_anew(load):
    assert load()(2) == 4
    edited = load("def twice(value):\n    return 20 * value // 10\n")
    assert edited(2) == 4
    assert hits(edited) == 0


def test_it_is_told_whether_anything_is_compiled(load):
    assert not is_cached(load())
    load()(2)
    assert is_cached(load())


def test_flushed_function_is_compiled_anew(load):
    first = load()
    first(2)
    first._cache.flush()
    assert not is_cached(load())
    again = load()
    again(2)
    assert hits(again) == 0


def test_processes_that_save_different_signatures_at_once_do_not_exchange_them(tmp_path, monkeypatch):
    """Each reads the index before the other writes: in one index both would take its first free number."""
    with monkeypatch.context() as racing:
        racing.setattr(IndexDataCacheFile, "_load_index", lambda _: {})
        for key in ("float", "int"):
            _FilesBySignature(str(tmp_path), "twice-1", "stamp").save(key, f"code for {key}")
    reader = _FilesBySignature(str(tmp_path), "twice-1", "stamp")
    assert [reader.load(key) for key in ("float", "int", "bool")] == ["code for float", "code for int", None]
