"""Rough surfaces: made, measured and described."""

from tribo.surface.areal import ArealRoughness as ArealRoughness
from tribo.surface.areal import areal_roughness as areal_roughness
from tribo.surface.areal import remove_form as remove_form
from tribo.surface.autocorrelation import AutocorrelationLengths as AutocorrelationLengths
from tribo.surface.autocorrelation import autocorrelation_lengths as autocorrelation_lengths
from tribo.surface.roughness import MeasuredRoughness as MeasuredRoughness
from tribo.surface.roughness import SelfAffineRoughness as SelfAffineRoughness
from tribo.surface.roughness import Surface as Surface
from tribo.surface.roughness import UnknownHeights as UnknownHeights
from tribo.surface.roughness import heights_of as heights_of
from tribo.surface.topography import average_roughness as average_roughness
from tribo.surface.topography import block_average as block_average
from tribo.surface.topography import block_sample as block_sample
from tribo.surface.topography import rms_height as rms_height
from tribo.surface.topography import rms_slope as rms_slope
from tribo.surface.topography import self_affine as self_affine
