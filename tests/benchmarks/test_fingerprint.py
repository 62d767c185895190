"""Fingerprints follow the code that runs, and nothing else; small faults that are called equivalent are ones made."""

import pkgutil

import pytest

from benchmarks import fingerprint as module
from benchmarks.fingerprint import fingerprint, import_closure
from benchmarks.mutation.operators import EQUIVALENT, mutants

FILES = {
    "plant/__init__.py": "",
    "plant/joint.py": '"""A joint."""\ndef step(velocity):\n    """Return it."""\n    return velocity  # as it is\n',
    "controllers/__init__.pyi": "from .pi import PI as PI\n",
    "controllers/pi.py": "import plant.joint\n\nPI = plant.joint.step\n",
    "controllers/other.py": "X = 1\n",
    "adaptive_ff/run.py": "def run():\n    from controllers import PI\n\n    return PI\n",
}


@pytest.fixture
def tree(tmp_path, monkeypatch):
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(module, "ROOT", tmp_path)
    return tmp_path


def digest():
    for cached in (module._imports, module._stub, module._tree_digest):
        cached.cache_clear()
    return fingerprint(["adaptive_ff.run"])


def test_closure_goes_through_stubs_and_imports_inside_functions(tree):
    assert import_closure(["adaptive_ff.run"]) == {"adaptive_ff.run", "controllers.pi", "plant.joint"}


@pytest.mark.parametrize(
    ("name", "old", "new", "changes"),
    [
        ("plant/joint.py", "A joint.", "Another text.", False),
        ("plant/joint.py", "  # as it is", "", False),
        ("plant/joint.py", "return velocity", "return -velocity", True),
        ("controllers/other.py", "X = 1", "X = 2", False),
        ("adaptive_ff/run.py", "return PI", "return None", True),
    ],
)
def test_it_changes_with_the_code_that_runs_alone(tree, name, old, new, changes):
    before = digest()
    file = tree / name
    file.write_text(file.read_text().replace(old, new))
    assert (digest() != before) is changes


def test_further_files_count_to_the_byte(tmp_path):
    scenario = tmp_path / "one.toml"
    scenario.write_text("seed = 1\n")
    before = fingerprint(["plant"], [scenario])
    scenario.write_text("seed = 1 \n")
    assert fingerprint(["plant"], [scenario]) != before


@pytest.mark.parametrize("name", sorted({name for name, _, _ in EQUIVALENT}))
def test_every_equivalent_mutant_is_one_of_those_that_are_made(name):
    made = {mutant.key for mutant in mutants(name, pkgutil.resolve_name(name))}
    assert {key for key in EQUIVALENT if key[0] == name} <= made
