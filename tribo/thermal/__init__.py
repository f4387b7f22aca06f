"""Flash temperature, heat partition, and the temperature over the contact."""

from tribo.thermal.conduction import ConductingHalfSpace as ConductingHalfSpace
from tribo.thermal.conduction import HeatedLength as HeatedLength
from tribo.thermal.conduction import settling_time as settling_time
from tribo.thermal.partition import HeatPartition as HeatPartition
from tribo.thermal.partition import partition_heat as partition_heat
from tribo.thermal.quantiles import QUANTILES as QUANTILES
from tribo.thermal.quantiles import JackknifeQuality as JackknifeQuality
from tribo.thermal.quantiles import contact_quantiles as contact_quantiles
from tribo.thermal.quantiles import failed_share as failed_share
from tribo.thermal.quantiles import jackknife_error as jackknife_error
from tribo.thermal.quantiles import require_share as require_share
from tribo.thermal.quantiles import rise_exceeded as rise_exceeded
from tribo.thermal.quantiles import rises_without_groups as rises_without_groups
from tribo.thermal.track import Disc as Disc
from tribo.thermal.track import circuit_rise as circuit_rise
from tribo.thermal.track import track_warming as track_warming
