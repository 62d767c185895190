"""The scenario matrix: every controller on every scenario of ``adaptive-ff matrix``."""
