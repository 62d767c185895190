"""Mutants of the kernels: small faults put in one at a time, to see whether the tests notice."""
