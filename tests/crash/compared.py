"""What a store holds of a point, beside what was computed."""


def differing(store, result):
    """Variables of a point that are not, bit for bit, what was computed."""
    expected = result.columns | (result.fields if "pressure" in store.names else {})
    found = store.at(result.point, list(expected))
    return [
        name
        for name, values in expected.items()
        if found[name][: len(values)].tobytes() != values.tobytes()
    ]
