"""Gaps as Python writes them: builders, arrays, functions, topographies."""

import json
import math

import numpy as np
import pytest

import contact_patch
from contact_patch import Contact, SceneError, gap


def force(of, **keys):
    return Contact(of, modulus=1.0, **{"depth": 0.1, **keys}).solve().force


@pytest.mark.parametrize(
    ("built", "written"),
    [
        (gap.Paraboloid(2.0), {"kind": "paraboloid", "radii": [2.0, 2.0]}),
        (gap.Paraboloid(2.0, math.inf), {"kind": "paraboloid", "radii": [2.0, "flat"]}),
        (gap.Sphere(1.0), {"kind": "sphere", "radius": 1.0}),
        (gap.Cone(45.0), {"kind": "cone", "inclination": 45.0}),
        (gap.Power(1.0, 4), {"kind": "power", "coefficient": 1.0, "exponent": 4}),
        (gap.Pyramid(3, 45.0), {"kind": "pyramid", "faces": 3, "inclination": 45.0}),
        (gap.Pyramid(4, 5.0, flat=0.1), {"kind": "pyramid", "faces": 4, "inclination": 5.0, "flat": 0.1}),
        (gap.Pyramid(4, 5.0, rounded=0.1), {"kind": "pyramid", "faces": 4, "inclination": 5.0, "rounded": 0.1}),
        (gap.Cone(5.0, rounded=0.1), {"kind": "cone", "inclination": 5.0, "rounded": 0.1}),
        (gap.Berkovich(65.03, flat=2e-8), {"kind": "berkovich", "face_angle": 65.03, "flat": 2e-8}),
        (gap.Vickers(), {"kind": "vickers"}),
        (gap.CubeCorner(rounded=5e-8), {"kind": "cube_corner", "rounded": 5e-8}),
        (
            gap.Profile([[-1, 1], [0, 0], [1, 1]], along="x", radius=2.0, mirror="y"),
            {"kind": "profile", "points": [[-1.0, 1.0], [0.0, 0.0], [1.0, 1.0]], "along": "x", "radius": 2.0, "mirror": "y"},
        ),
        (gap.Profile("rail.ban", along="x"), {"kind": "profile", "file": "rail.ban", "along": "x"}),
        (gap.Polyhedron(np.eye(3)), {"kind": "polyhedron", "planes": np.eye(3).tolist()}),
        (gap.Flat(disc=1.0), {"kind": "flat", "outline": {"disc": 1.0}}),
        (gap.Revolved([[0, 0], [1, 1]]), {"kind": "revolved", "points": [[0, 0], [1, 1]]}),
        (gap.Formula("x^2", disc=1.0), {"kind": "formula", "expression": "x^2", "region": {"disc": 1.0}}),
        (gap.Cone(45.0).placed([1, 2], 30.0), {"kind": "cone", "inclination": 45.0, "at": [1, 2], "rotate": 30.0}),
        (
            gap.Min(gap.Cone(1.0), gap.Cone(2.0) + gap.Sphere(1.0)),
            {"kind": "min", "of": [gap.Cone(1.0).to_dict(), {"kind": "sum", "of": [gap.Cone(2.0).to_dict(), gap.Sphere(1.0).to_dict()]}]},
        ),
    ],
)
def test_builders_write_what_a_file_would_say(built, written):
    from contact_patch._scene import source

    text = source(Contact(built, modulus=1.0, depth=1.0))[0]
    assert json.loads(text)["gap"] == written
    assert "Gap(" in repr(built)


def test_units_are_labels():
    contact = Contact(gap.Sphere(20.0), modulus=1e5, force=10.0, units={"length": "mm", "force": "N"})
    assert contact.to_dict()["units"] == {"length": "mm", "force": "N"}
    assert contact.solve().depth == Contact(gap.Sphere(20.0), modulus=1e5, force=10.0).solve().depth
    with pytest.raises(SceneError) as refused:
        Contact(gap.Sphere(20.0), modulus=1e5, force=10.0, units={"length": 3}).solve()
    assert "units" in refused.value.path


def test_a_profile_is_read_as_its_points(tmp_path):
    y = np.linspace(-1.0, 1.0, 41)
    line = np.column_stack([y, y**2 / 2])
    (tmp_path / "line.txt").write_text("\n".join(f"{a};{b}" for a, b in line))
    by_points = force(gap.Profile(line, along="x", radius=1.0), tolerance=0.01)
    assert force(gap.Profile(str(tmp_path / "line.txt"), along="x", radius=1.0), tolerance=0.01) == by_points
    assert by_points == pytest.approx(force(gap.Paraboloid(1.0)), rel=0.01)


def test_a_gap_is_moved_twice():
    twice = gap.Pyramid(3, 45.0).placed(at=[1.0, 0.0]).placed(rotate=90.0)
    solution = Contact(twice, modulus=1.0, depth=0.1).solve()
    assert solution.patch.centroid == pytest.approx([0.0, 1.0], abs=0.05)


def test_a_function_is_a_gap():
    by_function = Contact(lambda x, y: x**2 / 2 + np.abs(y) ** 3, modulus=1.0, depth=0.1).solve()
    by_formula = Contact(gap.Formula("x^2/2 + abs(y)^3"), modulus=1.0, depth=0.1).solve()
    assert by_function.evidence == "estimated"
    apart = abs(by_function.force / by_formula.force - 1)
    assert apart <= by_function.force_error + by_formula.force_error
    # A cell that a kink runs through is halved until it is right.
    ridge = lambda x, y: np.maximum(np.abs(x), np.abs(x) + 0.7 * y) + y**2  # noqa: E731
    kinked = Contact(ridge, modulus=1.0, depth=0.1, method="fft", cells=48, tolerance=0.5).solve()
    written = Contact(gap.Formula("max(abs(x), abs(x) + 0.7*y) + y^2"), modulus=1.0, depth=0.1, method="fft", cells=48, tolerance=0.5)
    assert kinked.force == pytest.approx(written.solve().force, rel=1e-3)


def test_a_function_has_edges_and_stands_in_sums():
    def disc(x, y):
        return np.where(x**2 + y**2 <= 1.0, 0.0, np.inf)

    flat = Contact(disc, modulus=1.0, depth=1.0, tolerance=0.05).solve()
    assert flat.force == pytest.approx(2.0, rel=max(flat.force_error, 0.05))
    half = lambda x, y: (x**2 + y**2) / 4  # noqa: E731
    both = gap.Sum(half, gap.Paraboloid(2.0))
    assert force(both) == pytest.approx(force(gap.Paraboloid(1.0)), rel=2e-3)
    assert force({"kind": "sum", "of": [half, {"kind": "paraboloid", "radii": [2.0, 2.0]}]}) == force(both)
    # A constant is a gap, too, and one that never touches has no force.
    assert force(lambda x, y: 1.0) == 0.0


@pytest.mark.parametrize(
    ("function", "error", "told"),
    [
        (lambda x, y: 1 / 0, ZeroDivisionError, "division"),
        (lambda x, y: np.full((2, 2), 0.0), ValueError, "shape"),
        (lambda x, y: np.where(x > 0.3, np.nan, x**2 + y**2), ValueError, "NaN at"),
        (lambda x, y: "wide", ValueError, "wide"),
        (lambda x: x, TypeError, "argument"),
    ],
)
def test_what_a_function_does_wrong_is_raised(function, error, told):
    with pytest.raises(error, match=told):
        force(function)


def test_a_function_may_solve_itself():
    inner = []

    def nested(x, y):
        if not inner:
            inner.append(force(gap.Cone(45.0)))
        return x**2 + y**2

    assert force(nested) > 0 and inner[0] > 0


def heights():
    """Higher along x than along y, and lopsided: no mirror, no swap leaves it as it is."""
    x, y = np.meshgrid(np.arange(24) - 9.0, np.arange(17) - 6.0)
    return 0.01 * x**2 + 0.03 * y**2 + 0.002 * x * y


def test_heights_are_read_in_every_form_of_array():
    first = force(gap.HeightMap(heights(), (0.5, 0.25), surface="upper"))
    wide = np.empty((34, 24))
    wide[::2] = heights()
    for same in (np.asfortranarray(heights()), wide[::2], heights()[::-1][::-1], heights().tolist(), np.ma.asarray(heights())):
        assert force(gap.HeightMap(same, (0.5, 0.25), surface="upper")) == first
    narrow = force(gap.HeightMap(heights().astype(np.float32), (0.5, 0.25), surface="upper"))
    assert narrow == pytest.approx(first, rel=1e-5)
    assert force(gap.HeightMap(-heights(), (0.5, 0.25), surface="lower")) == first
    assert force(gap.HeightMap(heights().T, (0.25, 0.5), surface="upper")) == pytest.approx(first, rel=2e-3)


def test_the_first_index_runs_along_y():
    solution = Contact(gap.HeightMap(heights(), (0.5, 0.25), surface="upper"), modulus=1.0, depth=0.05).solve()
    # The lowest node is at (9, 6) of (24, 17).
    middle = [(9 - 11.5) * 0.5, (6 - 8) * 0.25]
    assert solution.patch.centroid == pytest.approx(middle, abs=0.3)


def test_heights_in_memory_and_in_a_file_are_one(tmp_path):
    np.save(tmp_path / "map.npy", heights())
    scene = {
        "effective_modulus": 1.0,
        "gap": {"kind": "height_map", "file": "map.npy", "spacing": [0.5, 0.25], "surface": "upper", "level": "plane"},
        "loading": {"depth": 0.1},
    }
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    by_file = contact_patch.solve(tmp_path / "scene.json")
    assert force(gap.HeightMap(heights(), (0.5, 0.25), surface="upper", level="plane")) == by_file.force
    assert force(gap.HeightMap(str(tmp_path / "map.npy"), (0.5, 0.25), surface="upper", level="plane")) == by_file.force


def test_holes_have_no_material():
    filled = heights()
    holed = filled.copy()
    holed[6, 9] = np.nan
    masked = np.ma.masked_array(filled, mask=np.isnan(holed))
    by_nan = force(gap.HeightMap(holed, 0.5, surface="upper"))
    assert by_nan == force(gap.HeightMap(masked, 0.5, surface="upper"))
    assert by_nan < force(gap.HeightMap(filled, 0.5, surface="upper", zero="as_is")) or by_nan != 0


@pytest.mark.parametrize(
    ("built", "path"),
    [
        (lambda: gap.HeightMap(np.zeros(4), 1.0, surface="upper"), "gap.file"),
        (lambda: gap.HeightMap(np.zeros((4, 4)), surface="upper"), "gap.spacing"),
        (lambda: gap.HeightMap(np.zeros((4, 4)), -1.0, surface="upper"), "gap.spacing[0]"),
        (lambda: gap.HeightMap(np.full((4, 4), np.inf), 1.0, surface="upper"), "gap.values[0]"),
        (lambda: gap.HeightMap(np.zeros((4, 4)), 1.0, surface="left"), "gap.surface"),
        (lambda: gap.HeightMap(np.zeros((1, 4)), 1.0, surface="lower"), "gap.shape"),
    ],
)
def test_what_is_wrong_with_heights_is_named(built, path):
    with pytest.raises(SceneError) as caught:
        force(built())
    assert caught.value.path == path


class Topography:
    """As packages for topographies have them: first index x, sizes of the whole, a unit."""

    def __init__(self, of, sizes, unit="m", is_periodic=False):
        self._heights, self.physical_sizes, self.unit, self.is_periodic = of, sizes, unit, is_periodic

    def heights(self):
        return self._heights


def test_a_topography_is_a_gap():
    sizes = (24 * 0.5, 17 * 0.25)
    mine = force(gap.HeightMap(-heights(), (0.5, 0.25), surface="lower"))
    assert force(Topography(-heights().T, sizes)) == mine
    # Heights and sizes in micrometres, the rest in metres.
    micro = Topography(-heights().T * 1e6, (sizes[0] * 1e6, sizes[1] * 1e6), unit="µm")
    assert force(micro) == pytest.approx(mine, rel=1e-9)
    as_it_is = gap.HeightMap.of(micro, unit=None)
    assert force(as_it_is, depth=0.1e6) == pytest.approx(mine * 1e12, rel=1e-9)
    masked = Topography(np.ma.masked_less(-heights().T, -2.0), sizes)
    assert force(masked) > 0


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (Topography(np.zeros((4, 4)), (1.0, 1.0), is_periodic=True), "periodic"),
        (Topography(np.zeros(4), (1.0,)), "two dimensions"),
        (Topography(np.zeros((4, 4)), (1.0,)), "two lengths"),
        (Topography(np.zeros((4, 4)), (1.0, 1.0), unit="furlong"), "furlong"),
    ],
)
def test_what_is_wrong_with_a_topography_is_said(wrong, told):
    with pytest.raises(SceneError, match=told):
        force(wrong)
