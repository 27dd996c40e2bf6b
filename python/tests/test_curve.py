"""The non-linear spring."""

import numpy as np
import pytest

from contact_patch import Contact, SceneError, curve, gap


@pytest.fixture(scope="module")
def spring():
    return Contact(gap.Paraboloid(1.0) + gap.Power(0.5, 4), modulus=1.0, depth=1.0).curve()


def test_it_passes_through_solved_states(spring):
    for depth in (0.01, 0.3, 1.0):
        state = Contact(gap.Paraboloid(1.0) + gap.Power(0.5, 4), modulus=1.0, depth=depth, tolerance=1e-4).solve()
        assert spring(depth) == pytest.approx(state.force, rel=3e-4)
        assert spring.stiffness(depth) == pytest.approx(state.stiffness, rel=3e-3)


def test_the_derivative_is_that_of_the_force(spring):
    depth = np.linspace(0.05, 0.95, 50)
    step = 1e-6
    slope = (spring(depth + step) - spring(depth - step)) / (2 * step)
    assert spring.derivative()(depth) == pytest.approx(slope, rel=1e-6)
    assert np.all(np.diff(spring(depth)) > 0) and np.all(np.diff(spring.stiffness(depth)) > 0)


def test_depth_undoes_force_and_shapes_are_kept(spring):
    depth = np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]], dtype=np.float32)[:, ::-1]
    assert spring(depth).shape == (2, 3)
    assert spring.depth(spring(depth)) == pytest.approx(depth, rel=1e-9)
    assert isinstance(spring(0.5), float) and np.isnan(spring(1.1)) and spring(-1.0) == 0.0
    assert spring.first_touch == 0.0 and spring.deepest == 1.0 and spring.solves > 1 and 0 < spring.error < 1e-3
    assert spring.to_dict().keys() and "Curve(" in repr(spring)


def test_a_force_sets_the_range_too():
    by_force = curve({"effective_modulus": 1.0, "gap": {"kind": "sphere", "radius": 2.0}, "loading": {"force": 1.0}})
    assert by_force(by_force.deepest) == pytest.approx(1.0, rel=1e-3)


def test_what_cannot_be_a_curve_is_said():
    with pytest.raises(SceneError, match="tilt"):
        Contact(gap.Flat(disc=1.0), modulus=1.0, depth=1.0, tilt=[0.1, 0.0]).curve()
    with pytest.raises(SceneError, match="accuracy"):
        Contact(gap.Cone(1.0), modulus=1.0, depth=1.0).curve(accuracy=0.0)
    with pytest.raises(SceneError, match="beyond first touch"):
        Contact(gap.Cone(1.0), modulus=1.0, depth=-1.0).curve()
