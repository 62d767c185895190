"""The scenario matrix: every controller on every scenario of ``benchmarks/scenarios``."""
