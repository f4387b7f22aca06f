"""Constants that change an answer: errors, extrapolation, the search of a boundary, verdicts.

Each docstring ends with the command that found or judged the constant. `make measured` lists them.
The constants of a simulated point are in `tribo/constants.py`.
"""

from tribo import WarningKind

# Errors of a rise

PRESET_BOUNDS = {"standard": 0.011, "fine": 0.0055, "reference": 0.005}
"""Relative error of the critical velocity that each preset promises, see CHOOSING.md.

Of 985 places without a warning 99 % err by less than 1.00 and 0.53 %.

Judged by `python -m tests.promises.front`.
"""
BOUNDS_OF_HIGHEST = {"standard": 0.05}
"""Error bounds of presets where the highest temperature governs, if larger than usual.

Critical velocities then err by 3.6 % at 99 % of 811 points, where a tenth decides by 1.3 %.

Judged by `python -m tests.promises.errors`.
"""
HIGHEST_SHARE = 0.05
"""Failing share below which the governing temperature counts as the highest.

Judged by `python -m tests.promises.errors`.
"""
BOUNDS_OF_MOST = {"standard": 0.03}
"""Error bounds of presets where the temperature of most of the contact governs, if larger.

Critical velocities then err by 2.4 % at 99 % of 811 points, where a tenth decides by 1.3 %.

Judged by `python -m tests.promises.errors`.
"""
MOST_SHARE = 0.3
"""Failing share from which on the governing temperature counts as that of most of the contact.

Judged by `python -m tests.promises.errors`.
"""
RISE_SHARE = 0.65
"""Relative error of a rise over that of the critical velocity: rises grow as velocity^0.5 to 0.7.

Found by `make promises`.
"""
BEYOND = 0.12
"""Error of the exponent of an extrapolated power law, for each unit of ln(velocity).

The distance in ln(velocity) counts from the second outermost point.

Found by `python -m tests.promises.errors`.
"""
LEAST_BENT, UNSEEN_BENT = 0.1, 0.25
"""Least curvature d²y/d ln(velocity)² that bounds an interpolation, of three points and of two.

Judged by `python -m tests.promises.errors`.
"""
ROUGH_GAP = 0.008
"""Part of an interpolation error between velocities by roughness, over ln of their ratio.

On 24 scenes the bound, with this part, holds at 96 % of velocities between those of `fine`, on 20
others at 96 %.
Found by `python -m tests.promises.errors`.
"""
ALONE_IN_LOCAL_WEAR = 1, 2.0
"""Degrees of freedom of the spread estimated from one realization, and its factor, for local wear.

For other wear they are 7 and 1. Local wear makes the strips of one contact more alike than
realizations are, by factors of 0.9 to 12. Judged by `python -m tests.promises.realizations`.
"""
CORRELATION = 0.7
"""Assumed correlation of ln(rise) of realizations between two loads.

It is 0.6 from 200 to 750 N, and 0.9 between neighbours. Realizations of another load have this
weight, and the bound takes their spread as it is.
Judged by `python -m tests.promises.realizations`.
"""
OF_WARNED = {
    # The largest error seen with each of these three warnings; too few scenes of
    # `tests.promises.errors` have them for a quantile. Preset `fine` has the error of coarse pixels
    # too.
    WarningKind.FEW_STEPS: 0.10,
    WarningKind.FEW_TURNS: 0.10,
    WarningKind.COARSE_PIXELS: 0.70,
    # Seen with 15 to 38 elements in contact, each a single pixel; with some hundreds the error was
    # 0.6 %. Differences between surfaces, or from smaller pixels, are not included.
    WarningKind.FEW_NODES: 0.15,
    WarningKind.SLOW_RISE: 0.03,  # `standard` missed one of 33 points by 3.7 %
}
"""Relative error of the rise that a warning adds; for other warnings it is unknown.

Found by `python -m tests.promises.errors`.
"""
APART_FOR_EXPONENT = 1.1
"""Least ratio of two velocities that give an exponent of the rise.

Judged by `python -m tests.promises.errors`.
"""

# Lines of ln(rise/limit)

FARTHEST = 3.0
"""Factor beyond the computed velocities up to which a line is extrapolated.

Judged by `python -m tests.promises.errors`.
"""
LEAST_SLOPE = 0.05
"""Least slope of ln(rise) over ln(velocity or load) for extrapolation beyond the ends of a line.

Judged by `python -m tests.promises.errors`.
"""
PARTS = 16
"""Parts of an interval of velocities at which a line between loads is interpolated.

Judged by `python -m pytest tests/pipeline/answers`.
"""
RISE_SLOPES = 0.25, 1.2
"""Usual bounds of d ln(rise)/d ln(velocity) at constant friction; by theory it is 0.5 to 1.

Smooth, heavily worn contacts have less than 0.25. That moves a search of the boundary to other
points, but hides no crossing if friction is constant.
Judged by `python -m pytest tests/pipeline/run/test_search.py`.
"""

# Search of the boundary

STEEPEST, FLATTEST = 3.0, 0.1
"""Slopes of y outside which a computed slope is ignored, as a rise may begin at 0 or turn down.

Judged by `python -m pytest tests/pipeline/run/test_search.py`.
"""
CURVATURE = 0.3
"""Bound of d²(y − ln µ)/d ln(velocity)².

Judged by `python -m pytest tests/pipeline/run/test_search.py`.
"""
ROUGH_LINE = 0.003
"""Deviation of the rise of a rough contact from a smooth curve, from velocity to velocity.

It is 0.2 %. Judged by `python -m pytest tests/pipeline/run/test_search.py`.
"""
OF_POINTS, OF_LOADS = 1 / 3, 0.65
"""Shares of a goal less the preset's error: for interpolation along velocity, and along load.

Above the latter a load gets its own points, which costs less than more realizations around it.

Judged by `python -m pytest tests/pipeline/run/test_search.py`.
"""

OF_GAP = 1 / 2
"""Share of a goal less the preset's error, above which a gap of velocities gets one more point.

With half of it a gap takes a third more realizations.
Judged by `python -m pytest tests/pipeline/run/test_search.py`.
"""

# Verdicts and tests

DECIDED = (0.05, 0.5, 0.95)
"""Probabilities of severe wear: up to the first the verdict is mild, from the last on severe.

They are chosen. What they promise is measured.
Judged by `python -m pytest tests/pipeline/answers/test_answers.py`.
"""
LEAST_STATED = 0.01
"""Least probability that is stated as a number: the tails are not known better.

Judged by `python -m pytest tests/pipeline/answers/test_answers.py`.
"""
WORTH = 4
"""Degrees of freedom of the bias, and results that the prior of the scatter is worth.

Judged by `python -m pytest tests/pipeline/answers/test_answers.py`.
"""
UNLIKELY = 0.01
"""Leave-one-out probability below which a test is listed as an outlier.

Judged by `python -m pytest tests/pipeline/answers/test_tested.py`.
"""
