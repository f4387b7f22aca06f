"""Print the rows of `gear_mesh.toml`: places on the path of contact of a pair of spur gears.

    python gear_mesh.py > gear_mesh.csv

Change the numbers at the top to those of your gears. The load is shared by one third and two thirds
where two pairs of teeth are in contact. The pitch point has no sliding, and so no row.
"""

import math

TEETH, MODULE, PRESSURE_ANGLE = (16, 24), 4.5e-3, math.radians(20)  # pinion, wheel; [m]
CENTRES, TIPS = 91.5e-3, (88.77e-3, 112.5e-3)  # distance of the axes, tip diameters [m]
TORQUE, SPEED = 302.0, 2170 * 2 * math.pi / 60  # of the pinion [N m], [rad/s]

base = [z * MODULE / 2 * math.cos(PRESSURE_ANGLE) for z in TEETH]  # radii of the base circles
curvature_sum = CENTRES * math.sin(math.acos(sum(base) / CENTRES))  # sum of both radii of curvature
pitch = math.pi * MODULE * math.cos(PRESSURE_ANGLE)
# Radius of curvature of the pinion's flank at A, where contact begins, B and D, between which one
# pair carries all, and E, where contact ends.
end = math.sqrt((TIPS[0] / 2) ** 2 - base[0] ** 2)
begin = curvature_sum - math.sqrt((TIPS[1] / 2) ** 2 - base[1] ** 2)
single_begin, single_end = end - pitch, begin + pitch
contact_positions = {
    "A": (begin, 1 / 3),
    "AB": ((begin + single_begin) / 2, 1 / 2),
    "B before": (single_begin, 2 / 3),
    "B": (single_begin, 1.0),
    "BD": ((single_begin + single_end) / 2, 1.0),
    "D": (single_end, 1.0),
    "DE": ((single_end + end) / 2, 1 / 2),
    "E": (end, 1 / 3),
}  # radius of curvature of the pinion's flank [m], and the part of the load that a pair carries

print("place,load [N],velocity [m/s],pin.radius [mm],motion.slide_roll_ratio,"
      "motion.pin_track_length [mm],motion.disk_track_length [mm]")  # fmt: skip
for position, (first, share) in contact_positions.items():
    second = curvature_sum - first
    radius = first * second / curvature_sum
    pinion, wheel = SPEED * first, SPEED * TEETH[0] / TEETH[1] * second  # velocities of the flanks
    ratio = (pinion - wheel) / ((pinion + wheel) / 2)  # the pin is the wheel, the disk the pinion
    # Length that passes the contact in a revolution of the body, at the velocity of its flank.
    tracks = [2e3 * math.pi * curvature for curvature in (second, first)]
    print(f"{position},{share * TORQUE / base[0]:.0f},{abs(pinion - wheel):.4f},{1e3 * radius:.3f},"
          f"{ratio:.4f},{tracks[0]:.1f},{tracks[1]:.1f}")  # fmt: skip
