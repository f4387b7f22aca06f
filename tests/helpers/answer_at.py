"""The answer on one place as plain values, for tests of closed forms."""

import numpy as np

import pipeline


def named(variable):
    """Names of the codes of a variable with flags, as its attributes state them."""
    about = variable.attrs
    names = dict(zip(about["flag_values"].tolist(), about["flag_meanings"].split(), strict=True))
    return np.vectorize(lambda code: names.get(code, ""), otypes=[object])(variable.values)


class Asked:
    """Variables of `pipeline.margin` at one place, as numbers and texts."""

    def __init__(self, found):
        self.found = found

    def __getattr__(self, name):
        return self.found[name].item()

    @property
    def verdict(self):
        """The verdict, as text."""
        return str(named(self.found["verdict"])[()])

    @property
    def origin(self):
        """Where the result is from, as text."""
        return str(named(self.found["origin"])[()])

    @property
    def flags(self):
        """Names of the flags that are set."""
        about = self.found["warning_flags"].attrs
        pairs = zip(about["flag_meanings"].split(), about["flag_masks"], strict=True)
        return {name for name, mask in pairs if int(self.warning_flags) & mask}

    @property
    def realizations(self):
        return self.found.attrs["realizations"]

    @property
    def notes(self):
        return self.found.attrs["notes"].split(" | ")

    @property
    def not_included(self):
        return self.found.attrs["not_included"]


def asked(ds, load, velocity, **conditions):
    """The answer on one place of a sweep."""
    return Asked(pipeline.margin(ds, load, velocity, **conditions))
