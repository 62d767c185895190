"""Joint, drive and controllers as discrete-time systems of python-control, for ``control.interconnect``."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
