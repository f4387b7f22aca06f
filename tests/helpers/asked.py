"""The answer on one place as plain values, for tests of closed forms."""

import pipeline


class Asked:
    """Variables of `pipeline.margin` at one place, as numbers and texts."""

    def __init__(self, found):
        self.found = found

    def __getattr__(self, name):
        return self.found[name].item()

    @property
    def flags(self):
        """Names of the caveats that hold."""
        about = self.found["caveats"].attrs
        pairs = zip(about["flag_meanings"].split(), about["flag_masks"], strict=True)
        return {name for name, mask in pairs if int(self.caveats) & mask}

    @property
    def patches(self):
        return self.found.attrs["patches"]

    @property
    def notes(self):
        return self.found.attrs["notes"].split(" | ")


def asked(ds, load, velocity, **conditions):
    """The answer on one place of a sweep."""
    return Asked(pipeline.margin(ds, load, velocity, **conditions))
