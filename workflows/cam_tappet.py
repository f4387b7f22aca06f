"""Print the rows of `cam_tappet.toml`: a cam on a flat tappet that does not turn, by its angle.

    python cam_tappet.py > cam_tappet.csv

Change the numbers at the top to those of your valve train. `lift` is a polynomial here; a table of
the cam's grinder does as well, with its second derivative.
"""

import math

RADIUS, WIDTH = 18e-3, 12e-3  # of the base circle, and across sliding [m]
LIFT, HALF_ANGLE = 8e-3, math.radians(70)  # highest lift [m]; half the cam angle of the lift
SPEED = 1000 * 2 * math.pi / 60  # of the camshaft [rad/s]
PRELOAD, STIFFNESS, MASS = 300.0, 75e3, 0.12  # valve spring [N], [N/m], moving parts [kg]
ANGLES = (-60, -54, -50, -30, 0)  # cam angles from the nose [°]
POWERS = (2, 10, 20, 30)  # of the polynomial, whose lift ends smoothly at the half angle


def lift(angle: float) -> tuple[float, float]:
    """Lift s, and its second derivative by the cam angle, both in m."""
    x, s, curvature = angle / HALF_ANGLE, 1.0, 0.0
    for n in POWERS:
        other_powers = [m for m in POWERS if m != n]
        factor = -math.prod(other_powers) / math.prod(m - n for m in other_powers)
        s += factor * x**n
        curvature += factor * n * (n - 1) * x ** (n - 2)
    return LIFT * s, LIFT * curvature / HALF_ANGLE**2


print("place,load [N],velocity [m/s],pin.radius [mm],motion.slide_roll_ratio,"
      "motion.pin_track_length [mm],motion.disk_track_length [mm]")  # fmt: skip
for degrees in ANGLES:
    s, bend = lift(math.radians(degrees))
    radius = RADIUS + s + bend  # of the cam's curvature at the contact
    load = PRELOAD + STIFFNESS * s + MASS * SPEED**2 * bend
    cam, tappet = SPEED * radius, SPEED * bend  # velocities of both surfaces past the contact
    sliding = cam - tappet  # = SPEED (RADIUS + s)
    ratio = sliding / ((cam + tappet) / 2)
    # Length that passes the contact in a revolution of the camshaft, at the velocity of the body.
    tracks = [2e3 * math.pi * abs(curvature) for curvature in (bend, radius)]
    row_name = f"nose {degrees}°" if degrees else "nose"
    print(f"{row_name},{load:.1f},{abs(sliding):.4f},{1e3 * radius:.3f},{ratio:.4f},"
          f"{tracks[0]:.1f},{tracks[1]:.1f}")  # fmt: skip
