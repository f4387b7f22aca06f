"""Grids, convolutions on them, and the stencils that precondition them."""

from tribo.numerics.convolution import Convolution as Convolution
from tribo.numerics.convolution import forget_buffers as forget_buffers
from tribo.numerics.convolution import padded_shape as padded_shape
from tribo.numerics.grid import Grid as Grid
from tribo.numerics.grid import largest as largest
from tribo.numerics.stencil import Neighbourhood as Neighbourhood
from tribo.numerics.stencil import Preconditioner as Preconditioner
