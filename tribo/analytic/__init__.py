"""Closed forms against which the solvers are tested; none of them calls a solver."""

from tribo.analytic.contact import (
    HertzEllipse,
    hertz_ellipse,
    hertz_line_half_width,
    hertz_line_peak_pressure,
    hertz_point_approach,
    hertz_point_peak_pressure,
    hertz_point_radius,
    hertz_pressure,
    westergaard_full_contact_pressure,
    westergaard_half_width,
    westergaard_mean_pressure,
    westergaard_pressure,
)
from tribo.analytic.heat import (
    MOVING_SQUARE_PEAK,
    ROLLING_SLIDING_PEAK,
    moving_band_rise,
    moving_ellipse_rise,
    ramped_flux_rise,
    resting_ellipse_rise,
    rolling_sliding_rise,
    square_source_rise,
    uniform_flux_rise,
)
from tribo.analytic.wear import (
    archard_wear_depth,
    worn_line_width,
    worn_point_width,
)

__all__ = [
    "MOVING_SQUARE_PEAK",
    "ROLLING_SLIDING_PEAK",
    "HertzEllipse",
    "archard_wear_depth",
    "hertz_ellipse",
    "hertz_line_half_width",
    "hertz_line_peak_pressure",
    "hertz_point_approach",
    "hertz_point_peak_pressure",
    "hertz_point_radius",
    "hertz_pressure",
    "moving_band_rise",
    "moving_ellipse_rise",
    "ramped_flux_rise",
    "resting_ellipse_rise",
    "rolling_sliding_rise",
    "square_source_rise",
    "uniform_flux_rise",
    "westergaard_full_contact_pressure",
    "westergaard_half_width",
    "westergaard_mean_pressure",
    "westergaard_pressure",
    "worn_line_width",
    "worn_point_width",
]
