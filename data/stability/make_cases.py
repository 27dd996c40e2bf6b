"""The cases of `contact-patch stability`, one file a topic, with forces from formulas or from converged solutions.

Run in this directory: python3 make_cases.py. Needs mpmath.
"""
import json, math
from mpmath import mp, mpf, ellipk, ellipe, findroot, gamma, sqrt, pi, tan

mp.dps = 40
K3, K4 = mpf("0.8824122"), mpf("0.7376164")  # force of the 3- and 4-faced punch in E* d^2/tan(alpha), converged
CONVERGED = "boundary elements, extrapolated to 1e-7"


def scene(gap, loading, e_star=1.0, **more):
    return {"effective_modulus": e_star, "gap": gap, "loading": loading, **more}


def run(method, within, cells=None, tolerance=None):
    out = {"method": method, "within": within}
    if cells:
        out["cells"] = cells
    if tolerance:
        out["tolerance"] = tolerance
    return out


def case(name, scene, runs, force=None, source=None, verdict=None, regions=None):
    out = {"name": name, "scene": scene, "runs": runs}
    if force is not None:
        out["force"], out["source"] = float(force), source
    if verdict:
        out["verdict"] = verdict
    if regions:
        out["regions"] = regions
    return out


def pyramid(n, inclination=45.0, **more):
    return {"kind": "pyramid", "faces": n, "inclination": inclination, **more}


def write(topic, cases):
    with open(topic + ".json", "w") as f:
        f.write("[\n" + ",\n".join("  " + json.dumps(c) for c in cases) + "\n]\n")


ALL = [run("auto", 1e-3), run("fft", 1e-3, 64), run("qp", 5e-3, 24), run("fabrikant", 0.04), run("ritz", 0.13)]
QUICK = [run("auto", 1e-3), run("fft", 1e-3, 64)]


def depth(d):
    return {"depth": d}


# Units: modulus, depth, Poisson's ratio, inclination, length.
units = []
for e in [1e-12, 1e-6, 1.0, 1e9, 1e15]:
    units.append(case(f"E* = {e:g}", scene(pyramid(3), depth(1.0), e), ALL, K3 * e, CONVERGED))
for d in [1e-12, 1e-6, 1e-3, 1e3, 1e6]:
    units.append(case(f"depth {d:g}", scene(pyramid(3), depth(d)), ALL, K3 * d * d, CONVERGED))
for nu in [-0.99, 0.0, 0.4999999, 0.5]:
    s = scene({"kind": "cone", "inclination": 45.0}, depth(1.0))
    del s["effective_modulus"]
    s["bodies"] = [{"youngs_modulus": 1.0, "poissons_ratio": nu}, "rigid"]
    runs = [run("closed_form", 1e-13), run("fft", 2e-3, 64), run("fabrikant", 1e-6), run("ritz", 1e-6)]
    units.append(case(f"nu = {nu}", s, runs, 2 / pi / (1 - mpf(nu) ** 2), "Love 1939"))
for a in [1e-6, 1e-3, 1.0, 80.0, 89.9]:
    runs = ALL
    units.append(case(f"inclination {a:g} degrees", scene(pyramid(3, a), depth(1.0)), runs, K3 / tan(mpf(a) * pi / 180), CONVERGED))
for scale in [1e-300, 1e-150, 1e150, 1e300]:
    s = scene({"kind": "paraboloid", "radii": [scale, scale]}, depth(scale))
    # P = 4/3 E* sqrt(R) d^(3/2) would be scale^2: E* makes up for it where it can.
    units.append(case(f"lengths of {scale:g}", s, [run("auto", 1e-12), run("fft", 1e-2, 32)], None, None, "solved or stopped"))
write("units", units)

# Shapes.
shapes = []
for n in [0.05, 0.5, 1.0, 2.0, 20.0, 200.0]:
    m = mpf(n)
    kappa = sqrt(pi) * gamma(m / 2 + 1) / gamma((m + 1) / 2)
    a = (1 / kappa) ** (1 / m)
    force = 2 * a * m / (m + 1)
    needle = n < 0.5
    runs = [run("closed_form", 1e-12), run("auto", 1e-12), run("fft", 0.2 if needle else 5e-3, 128)]
    shapes.append(case(f"gap ~ r^{n:g}", scene({"kind": "power", "coefficient": 1.0, "exponent": n}, depth(1.0)), runs, force, "Sneddon 1965"))
shapes.append(case("2 faces: a wedge without end", scene(pyramid(2), depth(1.0)), [run(m, 0.0) for m in ["auto", "fft", "qp", "closed_form"]], verdict="unbounded"))
shapes.append(case("3 faces", scene(pyramid(3), depth(1.0)), ALL, K3, CONVERGED))
shapes.append(case("1000 faces", scene(pyramid(1000), depth(1.0)), [run("auto", 1e-3), run("fft", 2e-3, 64), run("fabrikant", 1e-3)], 2 / pi, "Love 1939, the cone; 1000 faces differ by 2e-5"))
for t in [1e-6, 1e-2]:
    # The flat of inradius t lowers the gap by t tan(45): between the punch at depth 1 and at depth 1 + t.
    shapes.append(case(f"flat tip of {t:g}", scene(pyramid(4, 45.0, flat=t), depth(1.0)), [run("auto", 1e-3 + 3 * t), run("fft", 2e-3 + 3 * t, 64)], K4, CONVERGED))
for t in [1e-6, 1e-3]:
    # A hyperboloid of tip radius t: between the cone of depth 1 and that of depth 1 + t.
    tip = {"kind": "formula", "expression": f"sqrt(r^2 + {t * t:g}) - {t:g}"}
    shapes.append(case(f"tip of radius {t:g}", scene(tip, depth(1.0)), [run("auto", 1e-6 + 2 * t), run("fft", 5e-3 + 2 * t, 64)], 2 / pi, "Love 1939, the cone; a rounder tip differs by less than 2 t"))


def hertz(ratio):
    """P at depth 1 of x^2/2 + y^2 ratio/2, E* = 1 (Johnson 1985, section 4.2)."""
    A, B = mpf(1) / 2, mpf(ratio) / 2
    if ratio == 1:
        return mpf(4) / 3
    # Semi-axes a > b, k = b/a, m = 1 - k^2: B/A = (E/k^2 - K)/(K - E).
    f = lambda lk: mp.log((ellipe(1 - mp.e ** (2 * lk)) / mp.e ** (2 * lk) - ellipk(1 - mp.e ** (2 * lk))) / (ellipk(1 - mp.e ** (2 * lk)) - ellipe(1 - mp.e ** (2 * lk)))) - mp.log(B / A)
    k = mp.e ** findroot(f, -mpf(2) / 3 * mp.log(ratio) / 1 * mpf("0.9") - mpf("0.1"))
    K, E = ellipk(1 - k**2), ellipe(1 - k**2)
    # p0 b K/E* = d; A = p0 b/(E* a^2 m) (K - E).
    p0b = 1 / K
    a = sqrt(p0b * (K - E) / (A * (1 - k**2)))
    return 2 * pi / 3 * a * p0b


for ratio in [1, 1e2, 1e4, 1e8, 1e12]:
    runs = [run("closed_form", 1e-10), run("auto", 1e-10), run("ritz", 1e-6)] + ([run("fft", 1e-2, 64)] if ratio <= 1e4 else [])
    shapes.append(case(f"curvature ratio {ratio:g}", scene({"kind": "paraboloid", "radii": [1.0, 1.0 / ratio]}, depth(1.0)), runs, hertz(ratio), "Hertz 1881"))
for aspect in [10, 1000]:
    k = mpf(1) / aspect
    stiffness = pi * aspect / ellipk(1 - k**2)
    runs = [run("closed_form", 1e-10), run("auto", 1e-10), run("fft", 4e-2, 128)]
    shapes.append(case(f"flat ellipse {aspect}:1", scene({"kind": "flat", "outline": {"ellipse": [float(aspect), 1.0]}}, depth(1.0)), runs, stiffness, "Galin 1961"))
# A box takes at least half as many cells across as along: here they are 1000 times longer than wide.
k = mpf(1) / 2000
runs = [run("closed_form", 1e-10), run("fft", 5e-2, 64), run("fft", 5e-2, 128), run("qp", 0.1, 24)]
shapes.append(case("cells 1000 times longer than wide", scene({"kind": "flat", "outline": {"ellipse": [2000.0, 1.0]}}, depth(1.0)), runs, pi * 2000 / ellipk(1 - k**2), "Galin 1961"))
write("shapes", shapes)

# Meshes and places.
grids = []
# On so few cells the force is not known to within 100 %: no answer.
for n in [1, 2, 3, 5]:
    grids.append(case(f"{n} cells along the box", scene(pyramid(3), depth(1.0)), [run("fft", 0.0, n), run("qp", 0.0, n)], verdict="tolerance_not_reached"))
grids.append(case("no contact", scene(pyramid(3), depth(-1.0)), [run(m, 0.0) for m in ["auto", "fft", "qp", "fabrikant", "ritz"]], 0, "the bodies do not touch"))
grids.append(case("depth 0", scene(pyramid(3), depth(0.0)), [run(m, 0.0) for m in ["auto", "fft", "qp", "fabrikant", "ritz"]], 0, "the bodies do not touch"))
for n in [64, 65]:
    grids.append(case(f"apex on a {'node' if n == 64 else 'cell centre'}", scene(pyramid(4), depth(1.0)), [run("fft", 1e-3, n), run("qp", 1e-3, 32 if n == 64 else 33)], K4, CONVERGED))
for at in [[1e-9, 0.0], [1e-3, 1e-9], [0.1234, -0.4321], [1e6, -1e6]]:
    grids.append(case(f"apex at ({at[0]:g}, {at[1]:g})", scene(pyramid(3, at=at), depth(1.0)), QUICK, K3, CONVERGED))
for turn in [1e-9, 15.0, 45.0]:
    grids.append(case(f"turned by {turn:g} degrees", scene(pyramid(4, rotate=turn), depth(1.0)), [run("auto", 1e-3), run("fft", 2e-3, 64)], K4, CONVERGED))
# Contact over a whole rectangle, so that its corners place the cells and the apex lies where it is put.
for where, n in [("a node", 24), ("an edge", 28), ("a cell centre", 25)]:
    for off in [0.0, 1e-9, 1e-4]:
        corners = [[-1.0 + off, -0.75 + off], [1.0 + off, -0.75 + off], [1.0 + off, 0.75 + off], [-1.0 + off, 0.75 + off]]
        gap = {"kind": "formula", "expression": "0.05*(abs(x) + abs(y))", "region": {"polygon": corners}}
        name = f"apex on {where} of a full contact" if off == 0.0 else f"apex {off:g} beside {where} of a full contact"
        grids.append(case(name, scene(gap, depth(1.0)), [run("fft", 0.0, n), run("qp", 1e-6, n)]))
write("grids", grids)

# Several patches.
patches = []


def tips(s):
    ball = lambda x: {"kind": "paraboloid", "radii": [1.0, 1.0], "at": [x, 0.0]}
    return {"kind": "min", "of": [ball(-s / 2), ball(s / 2)]}


for s in [1e-3, 1e-2]:
    # Between one tip, 4/3, and one tip lowered by at most s a with a = 1: dP = 2 s a.
    patches.append(case(f"two tips {s:g} radii apart", scene(tips(s), depth(1.0)), [run("auto", 2e-3 + 3 * s), run("fft", 5e-3 + 3 * s, 64)], mpf(4) / 3, "Hertz 1881, one tip"))
for s in [0.3, 1.0, 1.9, 2.0, 2.1, 2.5, 5.0]:
    patches.append(case(f"two tips {s:g} radii apart", scene(tips(s), depth(1.0)), [run("auto", 2e-2), run("fft", 2e-2, 96), run("qp", 2e-2, 32)]))
patches.append(case("merging tips, two solvers on one grid", scene(tips(2.0), depth(1.0)), [run("fft", 1e-6, 48), run("qp", 1e-6, 48)]))
for d in [0.1, 0.2, 0.3, 0.4]:
    # Two valleys and the saddle between them, of height 1/4: the patches merge somewhere below 0.4.
    valleys = {"kind": "formula", "expression": "0.25*(x^2 - 1)^2 + 0.5*y^2"}
    patches.append(case(f"two valleys at depth {d:g}", scene(valleys, depth(d)), [run("fft", 0.0, 40), run("qp", 1e-6, 40), run("auto", 3e-2)]))
for s in [30.0, 100.0, 1000.0]:
    # Each tip is lowered by u = P/(pi E* s) of the other: P = 4/3 (1 - u)^(3/2).
    p = mpf(4) / 3
    for _ in range(50):
        p = mpf(4) / 3 * (1 - p / (pi * s)) ** mpf(1.5)
    patches.append(case(f"two tips {s:g} radii apart", scene(tips(s), depth(1.0)), [run("auto", 5e-3)], 2 * p, "two Hertzian contacts, each in the far field of the other", "solved or stopped"))
rough = "0.02*(cos(9*x + 1) + cos(7*y + 2) + cos(11*x + 13*y + 3) + cos(17*x - 8*y) + 0.5*cos(23*x + 19*y) + 0.5*cos(31*y - 14*x)) + 0.1"
disc = {"disc": 1.0}
patches.append(case("rough disc, a few asperities", scene({"kind": "formula", "expression": rough, "region": disc}, depth(0.02)), [run("auto", 2e-2, None, 1e-2), run("fft", 2e-2, 128)]))
patches.append(case("rough disc, half in contact", scene({"kind": "formula", "expression": rough, "region": disc}, depth(0.2)), [run("auto", 2e-2, None, 1e-2), run("fft", 2e-2, 128)]))
patches.append(case("rough disc, two solvers on one grid", scene({"kind": "formula", "expression": rough, "region": disc}, depth(0.2)), [run("fft", 1e-6, 40), run("qp", 1e-6, 40)]))
smooth = "1e-3*(cos(8*x) + cos(8*y))"
patches.append(case("wavy disc, full contact", scene({"kind": "formula", "expression": smooth, "region": disc}, depth(1.0)), [run("auto", 2e-2, None, 1e-2), run("fft", 3e-2, 128)], 2, "flat disc, 2 E* a d; the waves are of 1e-3"))
# The waves are flattened where the mean pressure is above E* k h/2 for each: near the middle it is not, by a little.
wavy = "0.045*(cos(8*x) + cos(8*y)) + 0.09"
nearly = {"kind": "formula", "expression": wavy, "region": disc}
patches.append(case("wavy disc, nearly full contact", scene(nearly, depth(1.0)), [run("auto", 2e-2, None, 1e-2), run("fft", 3e-2, 128)]))
patches.append(case("wavy disc, nearly full contact, two solvers on one grid", scene(nearly, depth(1.0)), [run("fft", 0.0, 32), run("qp", 1e-6, 32)]))
# Waves of two lengths on a dome: some two hundred summits, none like the other.
summits = "0.002*(2 - cos(37*x + 0.3)*cos(37*y) - 0.2*cos(11*x + 7*y)) + 0.001*r^2"
square = {"polygon": [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]}
rough_map = {"kind": "formula", "expression": summits, "region": square}
patches.append(case("rough map of 200 patches", scene(rough_map, depth(4e-3)), [run("fft", 0.0, 256), run("fft", 3e-2, 192)], regions=200))
patches.append(case("rough map of 200 patches, two solvers on one grid", scene(rough_map, depth(4e-3)), [run("fft", 0.0, 60), run("qp", 1e-6, 60)]))
write("patches", patches)

# Tilts and moments.
moments = []
moments.append(case("force at the middle of a disc", scene({"kind": "flat", "outline": disc}, {"force": 1.0, "through": [0.0, 0.0]}), [run("auto", 1e-9)], 1, "prescribed"))
moments.append(case("force at a third of the radius", scene({"kind": "flat", "outline": disc}, {"force": 1.0, "through": [0.333, 0.0]}), [run("auto", 1e-9)], 1, "prescribed"))
for e in [0.5, 0.8, 0.95]:
    # Beyond a/3 the far side lifts: contact at a part of the rim.
    moments.append(case(f"force at {e:g} of the radius: part of the disc lifts", scene({"kind": "flat", "outline": disc}, {"force": 1.0, "through": [e, 0.0]}), [run("auto", 1e-3, None, 1e-2)], 1, "prescribed, and its moment"))
def disc_tilted(t):
    return scene({"kind": "flat", "outline": disc}, {"depth": 1.0, "tilt": [t, 0.0]})


# p ~ (1 + 2 t x)/sqrt(1 - x^2 - y^2): whole contact until t = 1/2, whose force does not know of the tilt.
moments.append(case("disc tilted until its rim is about to lift", disc_tilted(0.5), [run("auto", 1e-2, None, 1e-2), run("fft", 3e-2, 128), run("qp", 8e-2, 24)], 2, "Galin 1961"))
for t in [1.0, 3.0, 100.0]:
    # The middle is pressed in by 1, the rim by 1 + t: contact of a part of the disc, at last without its middle.
    moments.append(case(f"disc tilted by {t:g} of its depth", disc_tilted(t), [run("fft", 0.0, 40), run("qp", 1e-6, 40)]))
moments.append(case("force beyond the rim", scene({"kind": "flat", "outline": disc}, {"force": 1.0, "through": [1.5, 0.0]}), [run("auto", 0.0)], verdict="no_equilibrium"))
moments.append(case("force 1e-30", scene(pyramid(3), {"force": 1e-30}), [run("auto", 1e-9), run("fft", 1e-9, 64)], 1e-30, "prescribed"))
moments.append(case("force 1e30", scene(pyramid(3), {"force": 1e30}), [run("auto", 1e-9), run("fft", 1e-9, 64)], 1e30, "prescribed"))
write("loads", moments)

# Sharp edges: level, tilted, lifting off, turned, bands, rings.
SQUARE = 2 * 1.152298  # P/(E* d) of the square of half side 1, graded cells, extrapolated to 1e-6
half = {"polygon": [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]}
tee = {"polygon": [[-1.0, 1.0], [-1.0, 0.6], [-0.2, 0.6], [-0.2, -1.0], [0.2, -1.0], [0.2, 0.6], [1.0, 0.6], [1.0, 1.0]]}
FITTED = "graded cells, extrapolated"
ROLLER = 5.7529e-4  # radius 1, length 2, overlap 1e-3
TOROID = 7.69139 * (0.75 / (2 * 75.485) + 0.99e-6)  # N for E* of 1/(0.75/(2 * 75.485) + 0.99e-6) MPa, lengths in mm
CORNER = 3.1740e-3  # one corner of a flat, overlap 0.1 less the distances from both sides


def flat(outline, **more):
    return {"kind": "flat", "outline": outline, **more}


edges = []
for turn in [0.0, 30.0, 45.0]:
    edges.append(case(f"square, turned by {turn:g} degrees", scene(flat(half, rotate=turn), depth(1.0)), [run("auto", 1.1e-3), run("edge_fitted", 2e-4, None, 2e-4)], SQUARE, FITTED))
    # Contact everywhere: the tilt adds no force.
    edges.append(case(f"square, turned by {turn:g} degrees and tilted", scene(flat(half, rotate=turn), {"depth": 1.0, "tilt": [0.1, -0.15]}), [run("auto", 1.1e-3)], SQUARE, FITTED))
# f = 0.1 less the distances from the sides of one corner, whatever the square.
for size in [0.1, 1.0, 30.0]:
    corner = {"polygon": [[-size, -size], [size, -size], [size, size], [-size, size]]}
    edges.append(case(f"one corner of a square of half side {size:g}", scene(flat(corner), {"depth": 0.1 - 2 * size, "tilt": [1.0, 1.0]}), [run("auto", 2e-3)], CORNER, "cells fitted to the edges, to 5e-4"))
edges.append(case("T lifting off", scene(flat(tee), {"depth": 0.5, "tilt": [0.8, -0.5]}), [run("auto", 0.0), run("fft", 2e-2, 256)]))
edges.append(case("T pressed at the end of its stem", scene(flat(tee), {"force": 1.0, "through": [0.05, -0.8]}), [run("auto", 1e-9)], 1, "prescribed, and its moment"))
edges.append(case("T pressed beside its stem", scene(flat(tee), {"force": 1.0, "through": [0.9, -0.8]}), [run("auto", 0.0)], verdict="no_equilibrium"))
for n in [8, 30, 60]:
    def arc(r):
        return [[r * math.cos(5.0 * k / n), r * math.sin(5.0 * k / n)] for k in range(n + 1)]
    bow = {"polygon": arc(1.0) + arc(0.85)[::-1]}
    edges.append(case(f"C-ring of {n} sides", scene(flat(bow), depth(1.0)), [run("auto", 0.0), run("fft", 3e-2, 192)]))
for inner, k in [(0.1, 0.999864355578), (0.5, 0.981017896923), (0.9, 0.821029779368)]:
    gap = {"kind": "formula", "expression": f"0*sqrt(r - {inner})", "region": {"disc": 1.0}}
    edges.append(case(f"flat ring as a formula, inner radius {inner}", scene(gap, depth(1.0)), [run("auto", 1.1e-3)], 2 * k, "Nystroem's method"))
# Rollers that end sharply, along whatever axes; one closed strip that is all but round.
ended = {"polygon": [[-0.9, -1.0], [0.9, -1.0], [0.9, 1.0], [-0.9, 1.0]]}
roller = {"kind": "formula", "expression": "x^2/2", "region": ended}
for turn in [0.0, 17.0, 37.0, 45.0, 88.0]:
    edges.append(case(f"roller with sharp ends, turned by {turn:g} degrees", scene({**roller, "rotate": turn}, depth(1e-3)), [run("auto", 1.1e-3)], ROLLER, "projected conjugate gradients on graded cells, to 3e-5"))
edges.append(case("roller with sharp ends in a sum, turned", scene({"kind": "sum", "of": [{**roller, "rotate": 37.0}, {"kind": "sphere", "radius": 1e9}]}, depth(1e-3)), [run("auto", 1.1e-3)], ROLLER, "projected conjugate gradients on graded cells, to 3e-5"))
for turn in [0.0, 33.0]:
    toroid = {"kind": "formula", "expression": "(hypot(x, 1.000000001*y) - 2.5732)^2/(2*0.23975)", "rotate": turn}
    edges.append(case(f"toroid that is not known to be round, turned by {turn:g} degrees", scene(toroid, depth(1.1789e-2)), [run("auto", 1.1e-3)], TOROID, "rings, refined to 1e-5"))
# Flats whose edges are rounded or slope, beside sharp ones or not, with radii and depths over decades.
GRIDS = "grids to 2048 cells, and lines to 1e-4"
beside = {"polygon": [[-1.5, -0.8], [1.5, -0.8], [1.5, 0.8], [-1.5, 0.8]]}
rounded = {"kind": "formula", "expression": "(max(0, abs(x) - 0.9)^2 + max(0, abs(y) - 0.6)^2)/0.2"}
sloping = {"kind": "formula", "expression": "max(0, 0.2*abs(x) - 0.1)", "region": beside}
round_and_sharp = {"kind": "formula", "expression": "max(0, abs(x) - 0.5)^2/0.4", "region": beside}
for turn in [0.0, 37.0]:
    for name, gap, d, within, known in [
        ("a flat with rounded edges", rounded, 0.01, 1.1e-3, 0.0172429), ("a flat with sloping and with sharp edges", sloping, 0.02, 1.1e-3, 0.029562),
        ("a flat with rounded and with sharp edges", round_and_sharp, 0.01, 1.1e-3, 0.0148944)]:
        edges.append(case(f"{name}, turned by {turn:g} degrees", scene({**gap, "rotate": turn}, depth(d)), [run("auto", within)], known, GRIDS))
# All but sharp ones: the flat punch.
for radius in [1e-6, 1e-9]:
    gap = {"kind": "formula", "expression": f"(max(0, abs(x) - 1)^2 + max(0, abs(y) - 1)^2)/{2 * radius:g}"}
    edges.append(case(f"a flat with edges rounded to {radius:g}", scene(gap, depth(1e-3)), [run("auto", 1.3e-3)], 1e-3 * SQUARE, FITTED))
# Truncated pyramids of inradius 0.5, 45 degrees: force at depths of 0.003 to 0.3 of that.
TIPS = {
    (4, 0.003): 1.728433e-3, (4, 0.01): 5.761568e-3, (4, 0.03): 1.728775e-2, (4, 0.1): 5.773331e-2, (4, 0.3): 0.1757190,
    (3, 0.01): 6.825472e-3, (3, 0.1): 6.843994e-2, (6, 0.01): 5.280253e-3, (6, 0.1): 5.289617e-2, (6, 0.3): 0.1608195,
}
for (faces, part), known in TIPS.items():
    tip = scene(pyramid(faces, flat=0.5, rotate=17.0), depth(0.5 * part))
    edges.append(case(f"pyramid of {faces} faces with a flat, {part:g} of it deep", tip, [run("auto", 1.1e-3)], known, "other cells on flat and flanks, or a grid, to 5e-5"))
write("edges", edges)
