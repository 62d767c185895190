"""The scenario matrix: every controller on every scenario, over seeds."""
