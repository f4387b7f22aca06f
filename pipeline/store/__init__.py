"""The store of a sweep; nothing else in the package knows Zarr.

The names that other rooms use stand in ``__init__.pyi``, and are loaded when first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
