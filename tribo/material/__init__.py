"""Solids and oils."""

from tribo.material.oil import BOUNDARY as BOUNDARY
from tribo.material.oil import FULL_FILM as FULL_FILM
from tribo.material.oil import Oil as Oil
from tribo.material.oil import lubrication_regime as lubrication_regime
from tribo.material.oil import minimum_line_film as minimum_line_film
from tribo.material.oil import minimum_point_film as minimum_point_film
from tribo.material.solid import Material as Material
from tribo.material.solid import contact_modulus as contact_modulus
