"""Elastic influence in 25 digits, from definitions that the package does not use.

Free: Love's closed form. Periodic along y: differences from the self term, near it by mpmath's
extrapolated sum over images, farther than an eighth of a period by the Fourier series along y;
for elements that are much longer than the period, by Clausen's integral. Periodic along both
axes: modes of the discrete spectrum, by the alternating sum over all waves that a grid cannot
tell apart.

    cd tests/tribo/contact/references && python elastic_influence.py > elastic_influence.json

E* is 1/π, so that the values are ∫∫ 1/r over the element; lengths are in units of dx.
"""

import json

import mpmath as mp

mp.mp.dps = 25


# 16 Gauss nodes integrate K0 over an element, which is short against its distance, to 20 digits.
GAUSS = [
    (node, 2 / ((1 - node**2) * mp.diff(lambda s: mp.legendre(16, s), node) ** 2))
    for node in mp.polyroots(mp.taylor(lambda s: mp.legendre(16, s), 0, 16)[::-1], maxsteps=200)
]


def term(x, y):
    total = mp.mpf(0)
    if x != 0:
        total += x * mp.asinh(y / abs(x))
    if y != 0:
        total += y * mp.asinh(x / abs(y))
    return total


def element(x, y, dx, dy):
    a, b = mp.mpf(dx) / 2, mp.mpf(dy) / 2
    x, y = mp.mpf(x), mp.mpf(y)
    return term(x + a, y + b) - term(x - a, y + b) - term(x + a, y - b) + term(x - a, y - b)


def by_images(x, y, dx, dy, period):
    """Influence of an element and all its images along y, less that on itself."""

    def pair(n):
        shifted = element(x, y + n * period, dx, dy) + element(x, y - n * period, dx, dy)
        return shifted - 2 * element(0, n * period, dx, dy)

    single = element(x, y, dx, dy) - element(0, 0, dx, dy)
    return single + mp.nsum(lambda n: pair(int(n)), [1, mp.inf])


def by_modes(x, y, dx, dy, period):
    """The same up to a constant, from -2/L ln|x| + 4/L sum K0(k|x|) cos(ky), for x > dx."""
    a, b = mp.mpf(dx) / 2, mp.mpf(dy) / 2
    total = -2 / period * 2 * b * mp.quad(mp.log, [x - a, x + a])
    for m in range(1, 1 + int(mp.ceil(45 * period / (2 * mp.pi * (x - a))))):
        k = 2 * mp.pi * m / period
        along_x = sum(weight * mp.besselk(0, k * (x + a * node)) for node, weight in GAUSS) * a
        total += 4 / period * along_x * 2 * mp.sin(k * b) / k * mp.cos(k * y)
    return total


def by_clausen(x, y, dx, dy, period):
    """The same up to a constant, for dx >> L: what varies along y is that of an endless bar."""
    a, b = mp.mpf(dx) / 2, mp.mpf(dy) / 2
    total = -2 / period * 2 * b * mp.quad(mp.log, [abs(x - a), x + a])
    if x < a:
        total = -2 / period * 2 * b * 2 * mp.quad(mp.log, [0, a])
        angles = (2 * mp.pi * (b + y) / period, 2 * mp.pi * (b - y) / period)
        total += period / mp.pi * sum(mp.clsin(2, angle) for angle in angles)
    return total


def line_periodic(x, y, dx, dy, period):
    if dx > 20 * period:
        return by_clausen(x, y, dx, dy, period) - by_clausen(0, 0, dx, dy, period)
    joint = max(2 * mp.mpf(dx), period / 8)
    if x <= joint:
        return by_images(x, y, dx, dy, period)
    far = by_modes(x, y, dx, dy, period) - by_modes(joint, 0, dx, dy, period)
    return far + by_images(joint, mp.mpf(0), dx, dy, period)


def alternating(function):
    """The sum of (-1)^k function(k) over all integers, k and -1 - k together."""
    terms = 60
    d = (3 + mp.sqrt(8)) ** terms  # Cohen, Rodriguez Villegas & Zagier (2000), algorithm 1
    d = (d + 1 / d) / 2
    b, c, total = mp.mpf(-1), -d, mp.mpf(0)
    for k in range(terms):
        c = b - c
        total += c * (function(k) - function(-1 - k))
        b *= mp.mpf((k + terms) * (k - terms)) / ((k + mp.mpf(1) / 2) * (k + 1))
    return total / d


def doubly_periodic(m, n, nx, ny, dx, dy):
    """The mode m, n of the transform of the influence on a grid of nx x ny."""
    mu, nu, dx, dy = mp.mpf(m) / nx, mp.mpf(n) / ny, mp.mpf(dx), mp.mpf(dy)
    if m == 0:  # all other waves along x have whole periods in an element
        series = alternating(lambda r: dy / ((nu + r) * abs(nu + r)))
        return mp.sin(mp.pi * nu) / mp.pi * series
    if n == 0:
        return doubly_periodic(n, m, ny, nx, dy, dx)

    def along_y(u):
        return alternating(lambda r: 1 / ((nu + r) * mp.hypot(u / dx, (nu + r) / dy)))

    series = alternating(lambda p: along_y(mu + p) / (mu + p))
    return mp.sin(mp.pi * mu) * mp.sin(mp.pi * nu) / mp.pi**2 * series


def main():
    free = [
        {"dx": 1.0, "dy": dy, "i": i, "j": j, "value": float(element(i, j * mp.mpf(dy), 1, dy))}
        for dy in (1.0, 1.25, 100.0, 0.01, 1000.0, 0.001)
        for i, j in ((0, 0), (1, 0), (0, 1), (3, 2), (19, 1), (25, 30), (200, 150))
    ]
    periodic = [
        {
            "dx": 1.0,
            "dy": dy,
            "ny": ny,
            "i": i,
            "j": j,
            "value": float(line_periodic(mp.mpf(i), j * mp.mpf(dy), 1, dy, ny * mp.mpf(dy))),
        }
        for dy, ny in ((1.25, 16), (1.0, 240), (300.0, 1), (0.9, 27), (1000.0, 7), (0.001, 9))
        for i, j in ((1, 0), (0, ny // 3), (0, ny // 2), (5, ny // 4), (40, 0), (239, ny // 2))
        if (i, j) != (0, 0)
    ]
    doubly = [
        {
            "dy": dy,
            "shape": [nx, ny],
            "mode": [m, n],
            "value": float(doubly_periodic(m, n, nx, ny, 1, dy)),
        }
        for nx, ny, dy in (
            (256, 256, 1.0),
            (512, 480, 1.25),
            (27, 35, 0.9),
            (1, 6, 1.0),
            (5, 1, 7.0),
            (16, 9, 1000.0),
            (16, 9, 0.001),
        )
        for m, n in ((1, 0), (0, 1), (1, 2), (3, 4), (nx // 2, ny // 2), (nx // 2, 1), (nx // 3, 0))
        if (m, n) != (0, 0) and m <= nx // 2 and n <= ny // 2
    ]
    references = {"free": free, "line_periodic": periodic, "doubly_periodic": doubly}
    print(json.dumps(references, indent=1))


if __name__ == "__main__":
    main()
