"""The adaptive controller: one Kalman filter along the reference, behind the response of the loop."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
