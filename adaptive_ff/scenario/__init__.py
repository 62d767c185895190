"""Scenarios: the tables of a scenario file, references, the true model of a joint."""
