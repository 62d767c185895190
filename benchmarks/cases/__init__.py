"""Generators of cases, a module a family: functions that return a list of :class:`benchmarks.suite.Case`."""
