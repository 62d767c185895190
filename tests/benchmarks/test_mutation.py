"""Small faults in kernels: those that are called equivalent are ones that are made."""

from benchmarks.mutation.__main__ import kernels
from benchmarks.mutation.equivalent import EQUIVALENT
from benchmarks.mutation.operators import mutants


def test_every_equivalent_mutant_is_one_of_those_that_are_made():
    made = {mutant.key for function in kernels().values() for mutant in mutants(function)}
    assert len(made) > 1000
    assert EQUIVALENT.keys() - made == set()
