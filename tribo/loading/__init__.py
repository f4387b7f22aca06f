"""Load as a function of time: ramps, stages and records."""

from tribo.loading.ramp import LoadStep as LoadStep
from tribo.loading.ramp import Ramp as Ramp
from tribo.loading.record import MeasuredLoad as MeasuredLoad
from tribo.loading.stages import Stages as Stages
