"""The answer on one place as plain values, for tests of closed forms."""

import numpy as np

import pipeline


def named(variable):
    """Names of the codes of a variable with flags, as its attributes state them."""
    about = variable.attrs
    names = dict(zip(about["flag_values"].tolist(), about["flag_meanings"].split(), strict=True))
    return np.vectorize(lambda code: names.get(code, ""), otypes=[object])(variable.values)


class PointAnswer:
    """Variables of `pipeline.margin` at one point, as numbers and texts."""

    def __init__(self, answer):
        self.answer = answer

    def __getattr__(self, name):
        return self.answer[name].item()

    @property
    def verdict(self):
        """The verdict, as text."""
        return str(named(self.answer["verdict"])[()])

    @property
    def origin(self):
        """Where the result is from, as text."""
        return str(named(self.answer["origin"])[()])

    @property
    def flags(self):
        """Names of the flags that are set."""
        about = self.answer["warning_flags"].attrs
        pairs = zip(about["flag_meanings"].split(), about["flag_masks"], strict=True)
        return {name for name, mask in pairs if int(self.warning_flags) & mask}

    @property
    def realizations(self):
        return self.answer.attrs["realizations"]

    @property
    def notes(self):
        return self.answer.attrs["notes"].split(" | ")

    @property
    def not_included(self):
        return self.answer.attrs["not_included"]


def asked(ds, load, velocity, **conditions):
    """The answer at one point of a sweep."""
    return PointAnswer(pipeline.margin(ds, load, velocity, **conditions))
