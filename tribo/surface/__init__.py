"""Rough surfaces: random and measured."""

from tribo.surface.roughness import MeasuredRoughness as MeasuredRoughness
from tribo.surface.roughness import SelfAffineRoughness as SelfAffineRoughness
from tribo.surface.roughness import Surface as Surface
from tribo.surface.roughness import UnknownHeights as UnknownHeights
from tribo.surface.roughness import array_digest as array_digest
from tribo.surface.roughness import surface_heights as surface_heights
from tribo.surface.topography import average_roughness as average_roughness
from tribo.surface.topography import block_average as block_average
from tribo.surface.topography import block_sample as block_sample
from tribo.surface.topography import correlation_lengths as correlation_lengths
from tribo.surface.topography import rms_slope as rms_slope
from tribo.surface.topography import self_affine as self_affine
from tribo.surface.topography import self_affine_amplitude as self_affine_amplitude
