"""The online estimator run over a recorded log."""
