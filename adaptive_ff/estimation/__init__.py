"""Recursive and batch least squares, resetting, instruments, Kalman random walk: mathematics of estimation only."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
