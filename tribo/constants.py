"""Numerical constants that affect results: discretization of a point, and limits of its warnings.

`make promises` tests them together with the presets: it compares rises of random scenes with those
of `reference`. It detects no error that `reference` shares, and does not test the limits of the
model, `FEWEST_TURNS` and `WIDEST`. If a constant rests on a measurement, its comment reports it.
"""

# Elements of the contact

# Elements across a smooth contact. With 12 under a ball its rise was up to 2 % low, with 8 up to
# 3 %, with 4 up to 5 %, with 3 up to 15 %; with 6 rows under a cylinder up to 4 %, with 4 up to
# 8 %, with 2 up to 28 %.
FEWEST_ACROSS, FEWEST_ROWS = 12, 6
FULL_SHARE = 2.0  # area by Eq. (1) over the nominal area, from which on summits merge
FULL_TOLERANCE_ELEMENTS = 2000  # touching elements from which on the fidelity's tolerance applies
TIGHTEST_TOLERANCE = 1e-3  # smallest tolerance of a contact, for few elements
CONTACT_OVER_HEAT = 24.0  # tolerance of a contact over that of its heat partition
TIGHTEST_HEAT = 1e-12  # smallest tolerance of the heat partition
# Factor on the size of elements if the rise is a mean over positions. With 2.0 rises under balls
# were up to 2.9 % too high; with 1.4 they err by 0.7 %, as with 1.0.
POSITION_SIZE_FACTOR = 1.4
SUMMIT_QUANTILE = 0.9  # quantile of the heights above which pixels belong to summits
ELEMENTS_PER_SUMMIT = 1.7  # smallest width of the surface's summits, in elements
SUMMITS_PER_ELEMENT = 3  # touching summits over `fewest_elements`, for elements of several pixels
# Largest factor on the sides of elements before the last step, and how many of these elements
# touch, over `fewest_elements`. With as many as in the last step, rises were up to 2.4 % too high.
HISTORY_COARSENING, ELEMENTS_OF_HISTORY = 4, 2

# Fewest elements along x that resolve the shape of the wear.
FEWEST_ELEMENTS = 24
# Largest tolerance of contacts under local wear, where the error of each contact stays in the worn
# shape. On 25 random scenes, rises in 4 steps were up to 3.5 % off with a tolerance of 0.1, and up
# to 0.4 % with this one.
LOCAL_TOLERANCE = 0.03

# Steps of the load and of wear

HOLD_STEPS = 25  # smallest number of steps of a hold in which ln(impulse) grows by `HOLD_GROWTH`
STEPS_TIMES_IMPRINT = 48  # largest imprint of a step over the roughness, times the number of steps
# Parts of a step for dense contacts: smooth bodies, contacts of `FULL_SHARE`, and surfaces whose
# highest pixel is less than `FLAT_TOP` standard deviations above `SUMMIT_QUANTILE`. Without parts
# rises were up to 2.3 % too low; with them they err by at most 0.6 %.
DENSE_PARTS, FLAT_TOP = 3, 1.0

# Growth of ln(impulse) in a hold that takes as many steps as there are increments. Measured on 18
# holds of 4 to 300 s, of smooth surfaces and of rough ones on 60 rows of elements, at wear rates of
# 1e-16 to 1e-14 m²/N. With a growth of 4, the rise by preset `standard` was within 2.4 % of a rise
# computed with eight times as many steps on the pixels. With 10 the rise is within 0.3 % of that
# with 4.
HOLD_GROWTH = 10.0
LEAST_SHARE_OF_INCREMENTS = 0.25  # smallest number of a load's increments, over the reference's

# Least steps of a later ramp and of a hold of stages; and their steps over the increments of the
# first ramp. With 3 and 2 steps, rises of pins that wear locally were up to 0.7 % too high; with
# these numbers they are within 0.1 % of those with 24 and 16.
STEPS_OF_LATER_RAMP, STEPS_OF_HOLD = 6, 4
LATER_RAMP_SHARE, HOLD_SHARE = 1 / 4, 1 / 6

WINDOW_OVER_WORN_WIDTH = 1.25  # width of the window over that of the worn contact after its stages

LOAD_NOISE = 0.02  # noise of a constant load, as a share of the reference load
EQUAL_TIME_LIMIT = 0.2  # steps take equal times if shares of travel and of time differ by less
FITTED_SHARES = (0.1, 0.9)  # shares of the reference load between which the rise is fitted

# Largest step of the load, over the last step, for which contacts are extrapolated.
MAX_EXTRAPOLATION = 2.0

GUESSED_CONTACT = 1.5  # elements that touch in a guess for other roughness, over those that touched

MOST_PARTS_OF_STEP = 4  # parts of a step
RESOLVING_STEPS = 25  # number of steps of a ramp from which parts are not needed

# The last step of a hold under strips of the disk is halved until the imprint of the rest over the
# roughness is at most the first number. The rest has the second number of times as many parts as
# the fidelity. After a ramp to 200 N and 30 s, by `standard`, other positions of the strips change
# the rise by 0.2 to 0.6 % (standard deviation); with an undivided step by 0.4 to 1.3 %. The third
# number limits the halvings to 20.
END_IMPRINT, END_PARTS, MAX_END_RATIO = 1.0, 2, 2.0**20

IMPLICIT_END = 1 / 6  # share of the step that is taken implicitly
# The end is repeated if elements that did not touch one step earlier carry more than the first
# share of the load, at a mean pressure over that of the contact above the second number. Below it
# they are the rim of a rough contact, where repeating changed the rise of 1 of 28 points by 1.5 %,
# and of the others by at most 0.6 %.
NEW_LOAD_SHARE, RIM_PRESSURE = 0.01, 0.75

MAX_DISTANCE_FACTOR = 2.0  # on a step's distance, to compensate low loads in its stages

# Positions of the disk

# Largest number of parts of a step of wear. Measured in 25 steps, under balls and crowned pins of 2
# to 40 mm, with wear of 9 to 64 times the roughness and correlation lengths of 8 to 30 µm: with 8
# parts, the rise exceeded on 10 % of the contact is within 0.9 % of its value with 48 parts. With 2
# parts it is up to 5.2 % too high.
MOST_PARTS_OF_WEAR = 8
MAX_PART_IMPRINT = 0.3  # largest imprint in a part, up to `MOST_PARTS_OF_WEAR` parts
# Number of strips into which the disk is cut while a pin at rest wears. With a window that stands
# still, the rises of grooves across sliding were up to 24 % too low. Other positions of the strips
# change a rise at random. Its standard deviation at 200 N on 96 rows of pixels, by `standard`, is
# 0.4 % with 16 strips, 0.24 % with 32 and 0.36 % with 48 without a lay, and 0.9, 0.5 and 0.4 % with
# grooves of 40 µm across sliding. The parts of a step in `Fidelity` lower it further.
STRIPS = 32
# Patches of the surface in the contacts at all positions together, over which the temperature under
# such a pin is averaged.
PATCHES = 5e3
# Most positions of the disk over which a temperature is averaged, and most pixels in the Hertzian
# contacts at all these positions together. Between 50, 100, 200 and 400 steps, rises under five
# balls and crowned pins on 56 to 563 elements differed by 0.8 to 7.4 % at one position, and by 0.03
# to 0.9 % as a mean over positions. Under pins that wear heavily this mean differed by up to 2.6 %
# between 50 and 100 steps. Under a ball of 2 mm at 10 N that wears off 2.4 µm the mean changes by
# 0.5 % from 9 to 19 positions, and by 0.8 % from 19 to 38.
MOST_POSITIONS, PIXELS_OF_POSITIONS = 100, 1e5
# Smallest number of positions; below it only the unshifted disk is used. Between positions the rise
# under the shipped ball differs by 0.4 %.
FEWEST_POSITIONS = 5
# With at least the first number of positions, a step of wear has the second number of times as many
# parts. Without this, the mean rise under one of these balls, on 140 elements, differed by 3.0 %
# between the numbers of steps, instead of 0.5 %.
FEW_POSITIONS, FEW_POSITIONS_PART_FACTOR = 20, 3
SHIFT = 4  # [pixels] divisor of all shifts, so that larger elements allow the same shifts

# Warnings

# Fewest touching elements if the user has chosen elements larger than pixels. With fewer,
# the coarse grid before the last step misses summits that wear, and boundaries err by up to 80 %.
FEW_ELEMENTS = 400
# Fewest touching pixels. With 211 to 400 of them, presets err by at most 0.6 of their bounds, which
# is no more than with over 400; fewer were not tested. Measured on the even-numbered scenes of
# `tests.promises.front`.
FEW_PIXELS = 200
# Fewest elements under a ball or crowned pin that rough parts of the disk pass. With fewer, the
# rise differs by up to 0.9 % with the number of steps, and by more with the surface, although it is
# a mean over positions of the disk.
FEW_SWEPT = 1000
# Fewest elements, large or small, under heavy wear. Under balls worn by 9 to 64 times the
# roughness, the rises with 25 and with 100 steps differed by up to 2.5 % on 1123 to 2172 elements,
# and by up to 1.7 % on 2536 to 3076.
FEW_WORN = 3000
HEAVY_WEAR = 9.0  # depth of heavy wear, over Ra of the elements
FEWEST_PIXELS = 2.0  # per correlation length, to resolve the slopes of the roughness
FEWEST_TURNS = 10  # turns of a rolling pin after which wear is even around it to about 10 %
WIDEST = 0.3  # half-width in radii up to which parabola and half-space approximate a pin
# Longest end of a pin [m], and the excess of its rise over that of the whole pin from which a point
# warns. Surfaces change the rise of so short a part by 1.3 % (standard deviation).
END_LENGTH, HOT_END = 0.4e-3, 0.04
# Largest relative error of the rise by present heat that gives no warning.
MAX_ELAPSED_HEAT_ERROR = 0.01
LEAST_SUMMIT = 0.7  # elements across a summit, below which the rise was up to 16 % too low
SLOWEST = 0.3
"""Least exponent of the rise as a power of velocity at which presets keep their stated accuracy."""

# Sampling of the surface

LAY_RATIO = 2.0  # ratio of correlation lengths along x and y from which a surface has a lay
HOT_SPOT_POWER = 4.0
"""Power of the autocorrelation of heights that is the correlation of hot spots.

Found on sixteen surfaces at two loads each, with and without a lay; judged on fourteen others, and
by `python -m tests.promises.realizations`.
"""
MAX_GROUP_FACTOR = 6.0
"""Largest standard deviation of realizations over their jackknife estimate; above, it is unknown.

Judged by `python -m tests.promises.realizations`.
"""
FREEDOM_OF_CELLS = 3.0
"""Degrees of freedom of the jackknife of cells under a ball, at most.

The cells in the middle have most of the heat. On fourteen surfaces and loads the squares of the
estimates of 30 to 40 realizations scatter like those of 1.7 to 6.4 degrees, in the median of 3.3.
"""
FREEDOM_OF_LOCAL_WEAR, LOCAL_WEAR_FACTOR = 1.0, 2.0
"""Degrees of freedom and factor of the jackknife under local wear.

There the groups of one contact differ less than realizations do, by factors of 0.6 to 12.
Judged by `python -m tests.promises.realizations`.
"""
