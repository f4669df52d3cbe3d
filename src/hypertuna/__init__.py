"""Open digital twin and control stack for soft robotic fish."""

import lazy_loader

# Public names, listed in __init__.pyi, load on first use.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
