"""Small faults in kernels: those that are called equivalent are ones that are made."""

import pkgutil

import pytest

from benchmarks.mutation.operators import EQUIVALENT, mutants


@pytest.mark.parametrize("name", sorted({name for name, _, _ in EQUIVALENT}))
def test_every_equivalent_mutant_is_one_of_those_that_are_made(name):
    made = {mutant.key for mutant in mutants(name, pkgutil.resolve_name(name))}
    assert {key for key in EQUIVALENT if key[0] == name} <= made
