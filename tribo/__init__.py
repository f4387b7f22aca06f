"""Simulation of one point of the transition diagram: contact, wear and heat of rough bodies.

The public names stand in ``__init__.pyi``. Each is loaded when it is first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
