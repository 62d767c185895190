"""Hinges and arms in MuJoCo, whose physics is not this package's: ``python -m benchmarks.robot``."""
