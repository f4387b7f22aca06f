"""A sweep as the text that a store keeps, and back."""

import json

from pipeline.sweep.stored import plain_sweep, sweep_of_plain


def sweep_text(sweep):
    return json.dumps(plain_sweep(sweep)[0])


def parse_sweep(text, arrays):
    return sweep_of_plain(json.loads(text), arrays)


def file_contents(sweep):
    return plain_sweep(sweep)[1]
