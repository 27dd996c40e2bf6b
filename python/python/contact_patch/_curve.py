"""The non-linear spring."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._numbers import numbers

_Array = npt.NDArray[np.float64]


class Curve:
    """Force over depth: increasing, convex, once differentiable. Called with depths of any shape it returns forces: zero before first
    touch, NaN beyond the range.

    >>> from contact_patch import Contact, gap
    >>> spring = Contact(gap.Paraboloid(1.0), modulus=1.0, depth=1.0).curve()
    >>> bool(abs(spring(0.25) - 4 / 3 * 0.125) < 2e-5)
    True
    """

    def __init__(self, core: _core.Curve) -> None:
        self._core = core

    def __call__(self, depth: npt.ArrayLike) -> Any:
        """Force at a depth."""
        return _each(self._core.force, depth)

    def derivative(self) -> Callable[[npt.ArrayLike], Any]:
        """Stiffness dP/dd as a function of depth."""
        return self.stiffness

    def stiffness(self, depth: npt.ArrayLike) -> Any:
        """dP/dd at a depth."""
        return _each(self._core.stiffness, depth)

    def depth(self, force: npt.ArrayLike) -> Any:
        """Depth at a force: the inverse; NaN for a pull and beyond the range."""
        return _each(self._core.depth, force)

    @property
    def first_touch(self) -> float:
        """Depth at which the bodies first touch."""
        return self._core.facts()[0]

    @property
    def deepest(self) -> float:
        """Largest depth."""
        return self._core.facts()[1]

    @property
    def error(self) -> float:
        """Estimate (not a bound) of the largest relative error of the force."""
        return self._core.facts()[2]

    @property
    def solves(self) -> int:
        """States that were solved."""
        return self._core.facts()[3]

    def to_dict(self) -> dict[str, Any]:
        """Knots, solved states, fitted power law, error."""
        whole: dict[str, Any] = json.loads(self._core.json())
        return whole

    def __repr__(self) -> str:
        touch, deepest, error, solves = self._core.facts()
        return f"Curve({touch:.6g} to {deepest:.6g}, error {error:.1e}, {solves} solves)"


def _each(of: Callable[[_Array], _Array], at: npt.ArrayLike) -> Any:
    points = np.asarray(at, dtype=np.float64)
    values = of(numbers(points)).reshape(points.shape)
    return values[()]
