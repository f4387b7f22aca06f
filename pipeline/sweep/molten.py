"""Contacts so hot that steel would have melted."""

MELTS = 1700.0  # K, where a carbon steel of 1 % begins to

WORDS = (
    f"the deciding temperature is above {MELTS - 273.15:.0f} °C, where steel melts: the model's "
    "bodies stay solid and keep their properties, so that it says no more than that wear is "
    "severe; check the load, the velocity and the units if this is where tests were"
)
