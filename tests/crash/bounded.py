"""Trying as many cases as there is time for."""

import random
import time


def until(seconds, cases, seed=0):
    """Cases in an order of chance, so that those left out lie all over, until the time is up."""
    cases, end = list(cases), time.monotonic() + seconds
    random.Random(seed).shuffle(cases)
    for case in cases:
        if time.monotonic() > end:
            return
        yield case


def add_seconds(parser):
    """Add the option that bounds a campaign in time."""
    parser.add_argument(
        "--seconds", type=float, default=float("inf"), help="after which to try nothing further"
    )
