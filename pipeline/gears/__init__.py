"""Gears: from the drawing of a pair to the contact at each place of mesh, and to a scene.

The simulated contact is in boundary lubrication, while gears run in mixed lubrication: the load
carried by the oil film is printed but not counted. The model was compared with no scuffing tests of
gears, only with FZG's own rule.

The public names, each loaded when it is first used:

- pairs: `read_pair`, `shipped_pairs`, `Pair`, `Duty`, `Involutes`
- contact: `mesh`, `Mesh`, `MeshPlace`, `load_share`, `flash_rise`, `draw_mesh`, `scene_toml`
- simulation: `judge`, `critical_temperature`, `predict_stages`, `judge_spectrum`
- the rule of the standard: `STAGES`, `stage_torque`, `stage_bulk`, `scuffing_integral`,
  `friction_coefficient`, `integral_temperature`
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
