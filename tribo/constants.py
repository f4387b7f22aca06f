"""Constants that change an answer: how a point is divided, and from where on it is doubted.

`make promises` judges them together, with the presets: it compares rises of random scenes with
those of `reference`. It sees no error that `reference` has, too, and does not judge the limits of
the model, `FEWEST_TURNS` and `WIDEST`. Where a measurement chose a constant, it stands beside it.
"""

# Elements of the contact

# Elements across a smooth contact. With 12 under a ball its rise was up to 2 % low, with 8 up to
# 3 %, with 4 up to 5 %, with 3 up to 15 %; with 6 rows under a cylinder up to 4 %, with 4 up to
# 8 %, with 2 up to 28 %.
FEWEST_ACROSS, FEWEST_ROWS = 12, 6
FULL_SHARE = 2.0  # area by Eq. (1) over the nominal area, from which on summits do not stand apart
MANY_TOUCHING = 2000  # touching elements from which on contacts have the tolerance of the fidelity
TIGHTEST_TOLERANCE = 1e-3  # least tolerance of a contact, for few elements
CONTACT_OVER_HEAT = 24.0  # tolerance of a contact over that of its heat partition
TIGHTEST_HEAT = 1e-12  # least tolerance of the heat partition
# Factor on the size of elements where the rise is a mean over positions. With 2.0 rises under balls
# were up to 2.9 % too high, with 1.4 they err as little as with 1.0, by 0.7 %.
LARGER_ON_POSITIONS = 1.4
SUMMIT_QUANTILE = 0.9  # quantile of the heights from which on pixels belong to summits
ELEMENTS_PER_SUMMIT = 1.7  # least width of the surface's summits, in elements
SUMMITS_PER_ELEMENT = 3  # summits that touch, over `fewest_elements`, for more than single pixels
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

HOLD_STEPS = 25  # least steps of a hold in which ln(impulse) grows by `HOLD_GROWTH`
STEPS_TIMES_IMPRINT = 48  # a step's largest imprint over the roughness, times the number of steps
# Parts of a step where contacts are dense: smooth bodies, contacts of `FULL_SHARE`, and surfaces
# whose highest pixel is less than `FLAT_TOP` standard deviations above `SUMMIT_QUANTILE`. Without
# them rises were up to 2.3 % too low, with them they err by at most 0.6 %.
DENSE_PARTS, FLAT_TOP = 3, 1.0

# Growth of ln(impulse) in a hold that takes as many steps as there are increments. Measured on 18
# holds of 4 to 300 s, of smooth surfaces and of rough ones on 60 rows of elements, at wear rates of
# 1e-16 to 1e-14 m²/N. With a growth of 4, the rise by preset `standard` was within 2.4 % of a rise
# computed with eight times as many steps on the pixels. With 10 the rise is within 0.3 % of that
# with 4.
HOLD_GROWTH = 10.0
LEAST_SHARE_OF_INCREMENTS = 0.25  # least share of the reference load's increments that a load takes

# Steps of stages. With 3 steps a later ramp and 2 a hold, onsets of four stages of 100 N and 60 s
# are within 0.6 % of those with many.
STEPS_OF_LATER_RAMP, STEPS_OF_HOLD = 3, 2

ROOM_BESIDE_WEAR = 1.25  # width of the window over that of the worn pin at the end of its stages

LOAD_NOISE = 0.02  # noise of a constant load, as a share of the reference load
EVEN_STEPS = 0.2  # steps are equal in time if shares of travel and of time differ by less
FITTED_SHARES = (0.1, 0.9)  # shares of the reference load between which the rise is fitted

# Largest step of the load, over the last step, for which contacts are extrapolated.
FARTHEST_STEP = 2.0

MOST_PARTS_OF_STEP = 4  # parts of a step
ENOUGH_STEPS = 25  # steps of a ramp that resolve the worn pin without parts

IMPLICIT_END = 1 / 6  # share of the step that is taken implicitly
# The end is repeated if elements that did not touch one step earlier carry more than the first
# share of the load. Their mean pressure over that of the contact must exceed the second number:
# below it they are the rim of a rough contact, where repeating moved the rise of 1 of 28 points by
# 1.5 %, of the others by at most 0.6 %.
NEW_LOAD, RIM_PRESSURE = 0.01, 0.75

LONGEST_STRETCH = 2.0  # largest factor on a step's distance to make up for its stages' low loads

# Positions of the disk

# Most parts of a step of wear. Measured in 25 steps, under balls and crowned pins of 2 to 40 mm,
# with wear of 9 to 64 times the roughness and correlation lengths of 8 to 30 µm: with 8 parts, the
# rise exceeded on 10 % of the contact is within 0.9 % of its value with 48 parts. With 2 parts it
# is up to 5.2 % too high.
MOST_PARTS_OF_WEAR = 8
DEEP_IMPRINT = 0.3  # imprint in a part beyond which a step has more parts
# Most positions of the disk over which a temperature is averaged, and most pixels in the Hertzian
# contacts at all these positions together. Between 50, 100, 200 and 400 steps, rises under five
# balls and crowned pins on 56 to 563 elements differed by 0.8 to 7.4 % at one position, and by 0.03
# to 0.9 % as a mean over positions. Under pins that wear heavily this mean differed by up to 2.6 %
# between 50 and 100 steps. Under a ball of 2 mm at 10 N that wears off 2.4 µm the mean changes by
# 0.5 % from 9 to 19 positions, and by 0.8 % from 19 to 38.
MOST_POSITIONS, PIXELS_OF_POSITIONS = 100, 1e5
# If there would be fewer positions than this, the unshifted disk is enough: between positions the
# rise under the shipped ball differs by 0.4 %.
FEWEST_POSITIONS = 5
# With at least the first number of positions, a step of wear has the second number of times as many
# parts. Without this, the mean rise under one of these balls, on 140 elements, differed by 3.0 %
# between the numbers of steps, instead of 0.5 %.
FEW_POSITIONS, MORE_PARTS = 20, 3
SHIFT = 4  # [pixels] shifts are multiples of this, so that larger elements allow the same shifts

# Warnings

# Fewest touching elements, where they are larger than pixels by the user's own choice. With fewer,
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
FEWEST_PIXELS = 2.0  # in a correlation length, to resolve the slopes of the roughness
FEWEST_TURNS = 10  # turns of a rolling pin over which its wear is even around it to about a tenth
WIDEST = 0.3  # half-width in radii up to which a pin is about a parabola and a half-space
TOO_WARM = 0.01  # relative error of the rise above which heat model "elapsed" gets a warning
LEAST_SUMMIT = 0.7  # elements across a summit, below which the rise was up to 16 % too low
SLOWEST = 0.3
"""Least exponent of the rise as a power of velocity at which presets keep their stated accuracy."""
