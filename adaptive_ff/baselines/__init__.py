"""Controllers that an adaptive one is compared with and that use or identify a model themselves."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
