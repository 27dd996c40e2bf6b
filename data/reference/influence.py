"""Influence coefficients of a uniformly loaded rectangle to 60 digits, written to influence.json beside this file,
and the Gauss rules of src/influence/far.rs, printed.

    python3 influence.py            writes influence.json
    python3 influence.py rules      prints the rules

Closed forms (Love 1929): the displacement at a point is a double difference of
F = x asinh(y/|x|) + y asinh(x/|y|); its mean over a cell is a fourth difference of
G = x^2 y/2 asinh(y/|x|) + x y^2/2 asinh(x/|y|) - r^3/6, with G_xxyy = 1/r. The differences cancel as (r/h)^4:
they are taken with 60 digits to spare. A few values are checked against quadrature, an independent route.
"""
import json
import pathlib
import sys

from mpmath import mp, mpf, asinh, sqrt, quad, pi, nstr, factorial, polyroots, matrix, lu_solve

mp.dps = 110


def F(x, y):
    return (x * asinh(y / abs(x)) if x else mpf(0)) + (y * asinh(x / abs(y)) if y else mpf(0))


def G(x, y):
    r = sqrt(x * x + y * y)
    if x == 0 or y == 0:
        return -(r**3) / 6
    return x * x * y / 2 * asinh(y / abs(x)) + x * y * y / 2 * asinh(x / abs(y)) - r**3 / 6


def collocation(h, i, j):
    a, b = h
    x, y = i * a, j * b
    return (F(x + a / 2, y + b / 2) - F(x - a / 2, y + b / 2) - F(x + a / 2, y - b / 2) + F(x - a / 2, y - b / 2)) / pi


def galerkin(h, i, j):
    a, b = h
    w = [1, -2, 1]
    total = sum(w[k + 1] * w[l + 1] * G((i + k) * a, (j + l) * b) for k in (-1, 0, 1) for l in (-1, 0, 1))
    return total / (a * b * pi)


def check_by_quadrature():
    mp.dps = 30
    for h, i, j in [((mpf(1), mpf(1)), 2, 3), ((mpf(10), mpf(1)), 0, 4), ((mpf(1), mpf(7)), 3, 2)]:
        a, b = h
        box = quad(lambda s, t: 1 / sqrt((i * a + s) ** 2 + (j * b + t) ** 2), [-a / 2, a / 2], [-b / 2, b / 2]) / pi
        hat = quad(lambda s, t: (a - abs(s)) * (b - abs(t)) / sqrt((i * a + s) ** 2 + (j * b + t) ** 2),
                   [-a, 0, a], [-b, 0, b]) / (pi * a * b)
        assert abs(box / collocation(h, i, j) - 1) < mpf(10) ** -15, (h, i, j)
        assert abs(hat / galerkin(h, i, j) - 1) < mpf(10) ** -15, (h, i, j)
    mp.dps = 110


def offsets():
    some = [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (0, 2), (2, 1), (1, 2), (2, 2), (3, 0), (0, 3), (3, 1), (1, 3), (2, 3),
            (3, 3), (4, 0), (0, 4), (4, 1), (1, 4), (3, 4), (5, 0), (0, 5), (5, 1), (1, 5), (4, 4), (6, 2), (7, 0), (0, 7),
            (1, 8), (8, 1), (0, 8), (8, 0), (0, 9), (9, 0), (8, 8), (10, 3), (3, 10), (11, 0), (0, 11), (12, 0), (0, 12),
            (8, 9), (13, 1), (1, 13), (9, 16), (17, 0), (0, 17), (31, 5), (0, 33), (33, 0), (2, 40), (40, 3), (64, 64),
            (0, 100), (100, 0), (1, 127), (129, 1), (200, 17), (3, 399), (401, 2), (512, 512), (0, 1000), (1000, 0),
            (1, 2047), (2049, 3), (777, 1234), (3000, 4), (4, 3000), (4095, 0), (0, 4095), (4096, 4096), (4096, 1), (1, 4096)]
    return some


def rules():
    """Even Gauss rules of the box |s| < 1/2 and of the hat 1 - |s|: positive nodes and weights, by their moments."""
    for name, moment in (("box", lambda k: mpf(1) / (4**k * (2 * k + 1))),
                         ("hat", lambda k: mpf(2) / ((2 * k + 1) * (2 * k + 2)))):
        for n in (1, 2, 3, 4):
            # Orthogonal polynomial of degree n in s^2 for the weight, from the Hankel system.
            m = matrix(n, n)
            rhs = matrix(n, 1)
            for r in range(n):
                rhs[r] = -moment(n + r)
                for c in range(n):
                    m[r, c] = moment(r + c)
            c = lu_solve(m, rhs)
            roots = sorted(polyroots([mpf(1)] + [c[k] for k in range(n - 1, -1, -1)], maxsteps=500, extraprec=800))
            v = matrix(n, n)
            w = matrix(n, 1)
            for r in range(n):
                w[r] = moment(r)
                for k in range(n):
                    v[r, k] = roots[k] ** r
            weights = lu_solve(v, w)
            print(name, 2 * n, [(nstr(sqrt(x), 18), nstr(q / 2, 18)) for x, q in zip(roots, weights)])


if len(sys.argv) > 1:
    rules()
else:
    check_by_quadrature()
    values = []
    for a, b in (("1", "1"), ("1.7", "1"), ("1", "6"), ("100", "1"), ("10000", "1"), ("1", "10000")):
        h = (mpf(a), mpf(b))
        for i, j in offsets():
            values.append({"spacing": [float(a), float(b)], "offset": [i, j],
                           "collocation": float(nstr(collocation(h, i, j), 25)),
                           "galerkin": float(nstr(galerkin(h, i, j), 25))})
    out = {"source": "closed forms (Love 1929) with mpmath, 110 digits: data/reference/influence.py",
           "unit": "displacement per unit pressure, E* = 1, spacing in lengths of the same unit", "values": values}
    pathlib.Path(__file__).with_suffix(".json").write_text(json.dumps(out, indent=0).replace("\n}", "}").replace("{\n", "{") + "\n")
