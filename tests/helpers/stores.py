"""Stores as tests look at them."""

import numpy as np

from pipeline.store.create import writing
from pipeline.store.place import place_of
from pipeline.store.root import read_root
from pipeline.store.schema import DONE
from pipeline.store.write import Store


def opened(path):
    """Open a store to read."""
    place = place_of(path)
    return Store(place, read_root(place))


def done_points(path):
    """Points that are done, in the order of the store."""
    store = opened(path)
    return store.points_at(np.nonzero(store.flags == DONE))


def asked_points(path):
    """Points that the last run asked for."""
    store = opened(path)
    return store.points_at(np.nonzero(store.asked == 1))


def at(path, point, name):
    """Values of a variable at a point."""
    store = opened(path)
    return store.read(name, store.index(point))


def make(path, sweep):
    """Make the store of a sweep, or make room in it."""
    with writing(path, sweep) as store:
        return store
