"""Closed forms against which the solvers are tested; none of them calls a solver."""

from tribo.analytic.contact import HertzContact as HertzContact
from tribo.analytic.contact import HertzEllipse as HertzEllipse
from tribo.analytic.contact import hertz_contact as hertz_contact
from tribo.analytic.contact import hertz_ellipse as hertz_ellipse
from tribo.analytic.contact import hertz_line_half_width as hertz_line_half_width
from tribo.analytic.contact import hertz_line_peak_pressure as hertz_line_peak_pressure
from tribo.analytic.contact import hertz_point_approach as hertz_point_approach
from tribo.analytic.contact import hertz_point_peak_pressure as hertz_point_peak_pressure
from tribo.analytic.contact import hertz_point_radius as hertz_point_radius
from tribo.analytic.contact import hertz_pressure as hertz_pressure
from tribo.analytic.contact import (
    westergaard_full_contact_pressure as westergaard_full_contact_pressure,
)
from tribo.analytic.contact import westergaard_half_width as westergaard_half_width
from tribo.analytic.contact import westergaard_mean_pressure as westergaard_mean_pressure
from tribo.analytic.contact import westergaard_pressure as westergaard_pressure
from tribo.analytic.heat import MOVING_SQUARE_PEAK as MOVING_SQUARE_PEAK
from tribo.analytic.heat import ROLLING_SLIDING_PEAK as ROLLING_SLIDING_PEAK
from tribo.analytic.heat import moving_band_rise as moving_band_rise
from tribo.analytic.heat import moving_ellipse_rise as moving_ellipse_rise
from tribo.analytic.heat import ramped_flux_rise as ramped_flux_rise
from tribo.analytic.heat import resting_ellipse_rise as resting_ellipse_rise
from tribo.analytic.heat import rolling_sliding_rise as rolling_sliding_rise
from tribo.analytic.heat import square_source_rise as square_source_rise
from tribo.analytic.heat import uniform_flux_rise as uniform_flux_rise
from tribo.analytic.wear import archard_wear_depth as archard_wear_depth
from tribo.analytic.wear import worn_line_width as worn_line_width
from tribo.analytic.wear import worn_point_width as worn_point_width
