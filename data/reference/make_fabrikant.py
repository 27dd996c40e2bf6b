"""Writes fabrikant.json: the values that tests/fabrikant.rs asks for.

Table 1: printed digits from Barber & Billings (1990); `p` recomputed here, mpmath, 30 digits, by Dinkelbach's iteration on
equations (12), (17), (18). Hertz: Carlson forms (DLMF 19.16). Flat polygons: 4 A/L with L integrated numerically.
"""
import json
from math import pi

import mpmath as mp

mp.mp.dps = 30
PRINTED = {3: (1.000, 1.696), 4: (0.853, 1.449), 5: (0.809, 1.373), 6: (0.789, 1.339), 7: (0.778, 1.320),
           8: (0.770, 1.308), 10: (0.763, 1.295), 15: (0.757, 1.283), 20: (0.754, 1.279), 50: (0.750, 1.274)}


def table_row(n):
    d = mp.mpf(3) / 4 * 4 / (3 * mp.pi)
    for _ in range(12):
        k = 3 * mp.pi * d / 4
        a = lambda t: 4 * (1 + mp.sqrt(1 - k * mp.cos(t))) / (3 * mp.pi * mp.cos(t))
        cut = [0, mp.pi / n / 64, mp.pi / n / 16, mp.pi / n / 4, mp.pi / n]
        big_l = mp.quad(a, cut)
        big_n = mp.quad(lambda t: a(t)**2 - mp.pi / 4 * a(t)**3 * mp.cos(t), cut)
        d = big_n / big_l
    return float(4 * d)


def hertz(ratio):
    rd, rf = mp.elliprd, mp.elliprf
    f = lambda x: rd(0, mp.e**(2 * x), 1) / rd(0, 1, mp.e**(2 * x)) - mp.mpf(ratio)
    g = lambda x: mp.log(rd(0, mp.e**(2 * x), 1) / rd(0, 1, mp.e**(2 * x))) - mp.log(mp.mpf(ratio))
    k = mp.mpf(1) if ratio == 1 else mp.e**mp.findroot(g, 0.55 * mp.log(mp.mpf(ratio)))
    big_k = rf(0, k * k, 1)
    a = mp.sqrt(rd(0, k * k, 1) / (3 * big_k * mp.mpf(ratio)))
    return dict(ratio=ratio, a=float(a), b=float(k * a), p=float(2 * mp.pi / 3 * a / big_k))


def regular(n, side=1.0):
    r = side / (2 * mp.sin(mp.pi / n))
    return [[float(r * mp.cos(2 * mp.pi * j / n)), float(r * mp.sin(2 * mp.pi * j / n))] for j in range(n)]


def flat(name, p):
    q = [(mp.mpf(x), mp.mpf(y)) for x, y in p]
    e = list(zip(q, q[1:] + q[:1]))
    area = sum(a[0] * b[1] - a[1] * b[0] for a, b in e) / 2
    c = [sum((a[i] + b[i]) * (a[0] * b[1] - a[1] * b[0]) for a, b in e) / (6 * area) for i in (0, 1)]
    big_l = 0
    for a, b in e:  # int r dtheta along the edge: r dtheta = cross(p, dp)/r
        u = [a[0] - c[0], a[1] - c[1]]
        v = [b[0] - a[0], b[1] - a[1]]
        cross = u[0] * v[1] - u[1] * v[0]
        big_l += mp.quad(lambda s: cross / mp.hypot(u[0] + s * v[0], u[1] + s * v[1]), [0, 0.25, 0.5, 0.75, 1])
    return dict(name=name, polygon=p, stiffness=float(4 * area / big_l))


def rectangle(a):
    return [[0, 0], [a, 0], [a, 1], [0, 1]]


s3 = float(mp.sqrt(3) / 2)
star = []
for j in range(10):
    r = 1.0 if j % 2 == 0 else 0.3819660112501051
    star.append([r * float(mp.cos(mp.pi * j / 5)), r * float(mp.sin(mp.pi * j / 5))])
t = 1 / 6
plus = [[t, -.5], [t, -t], [.5, -t], [.5, t], [t, t], [t, .5], [-t, .5], [-t, t], [-.5, t], [-.5, -t], [-t, -t], [-t, -.5]]
out = dict(
    source="Barber & Billings (1990) for printed_*; the rest by make_fabrikant.py",
    table_1=[dict(faces=n, printed_d=PRINTED[n][0], printed_p=PRINTED[n][1], p=table_row(n)) for n in PRINTED],
    hertz=[hertz(r) for r in (1, 0.5, 0.25, 0.1, 0.01, 1e-4, 1e-6, 1e-8, 1e-10)],
    flat=[flat("equilateral triangle", regular(3)), flat("square", regular(4)), flat("pentagon", regular(5)),
          flat("hexagon", regular(6)), flat("octagon", regular(8))]
         + [flat(f"rectangle {a}:1", rectangle(a)) for a in (2, 3, 4, 5, 10)]
         + [flat("rhombus 60/120", [[0, 0], [1, 0], [1.5, s3], [0.5, s3]]),
            flat("right isosceles triangle", [[0, 0], [1, 0], [0, 1]]),
            flat("L", [[-1, -1], [1, -1], [1, 0], [0, 0], [0, 1], [-1, 1]]),
            flat("plus", plus), flat("pentagram outline", star)],
)
json.dump(out, open("fabrikant.json", "w"), indent=1)
for row in out["table_1"]:
    print(row)
for row in out["flat"]:
    print(row["name"], row["stiffness"])
for row in out["hertz"]:
    print(row)
