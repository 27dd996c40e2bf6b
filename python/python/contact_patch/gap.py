"""The initial gap g(x, y) of the undeformed bodies at zero depth, one class a kind.

Each class takes the keys of the kind of the same name in a scene file; angles are in degrees. ``gap.placed(at=, rotate=)`` moves and
turns a gap, ``a + b`` is the sum of two (two curved bodies), ``Min(a, b)`` the lesser of two (a punch with two tips).

>>> from contact_patch import gap
>>> (gap.Paraboloid(1.0, 2.0) + gap.Cone(1.0)).to_dict()["kind"]
'sum'
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from ._errors import SceneError

__all__ = [
    "Berkovich",
    "Cone",
    "CubeCorner",
    "Flat",
    "Formula",
    "Function",
    "Gap",
    "HeightMap",
    "Min",
    "Paraboloid",
    "Polyhedron",
    "Power",
    "Profile",
    "Pyramid",
    "Revolved",
    "Sphere",
    "Sum",
    "Topography",
    "Vickers",
]

_Values = npt.NDArray[np.float64]
_Pair = Sequence[float]


class Gap:
    """A gap of any kind: ``Gap("cone", inclination=45.0)``. Keys that are None are left out."""

    def __init__(self, kind: str, **keys: Any) -> None:
        self._keys: dict[str, Any] = {"kind": kind, **{key: value for key, value in keys.items() if value is not None}}

    def to_dict(self) -> dict[str, Any]:
        """The gap as it stands in a scene. Arrays and functions stay what they are."""
        return dict(self._keys)

    def placed(self, at: _Pair | None = None, rotate: float | None = None) -> Gap:
        """With its origin at ``at``, turned about it by ``rotate`` degrees, counter-clockwise."""
        if "at" in self._keys or "rotate" in self._keys:
            return Sum(self).placed(at, rotate)
        placed = Gap.__new__(Gap)
        placed._keys = {**self._keys, **{k: v for k, v in (("at", at), ("rotate", rotate)) if v is not None}}
        return placed

    def __add__(self, other: Gap | Callable[..., Any]) -> Gap:
        return Sum(self, other)

    def __radd__(self, other: Gap | Callable[..., Any]) -> Gap:
        return Sum(other, self)

    def __repr__(self) -> str:
        keys = ", ".join(f"{key}={value!r}" for key, value in self._keys.items() if key != "kind")
        return f"Gap({self._keys['kind']!r}, {keys})"


class Paraboloid(Gap):
    """x^2/(2 R1) + y^2/(2 R2); one radius alone for both; ``inf`` or ``"flat"`` for a cylinder."""

    def __init__(self, radius: float | str, radius_y: float | str | None = None) -> None:
        radii = [radius, radius if radius_y is None else radius_y]
        super().__init__("paraboloid", radii=["flat" if r == np.inf else r for r in radii])


class Sphere(Gap):
    """A true sphere."""

    def __init__(self, radius: float) -> None:
        super().__init__("sphere", radius=radius)


class Cone(Gap):
    """A cone; ``inclination`` in degrees from the surface; ``rounded``: radius of curvature of a round tip."""

    def __init__(self, inclination: float, rounded: float | None = None) -> None:
        super().__init__("cone", inclination=inclination, rounded=rounded)


class Power(Gap):
    """coefficient r^exponent."""

    def __init__(self, coefficient: float, exponent: float) -> None:
        super().__init__("power", coefficient=coefficient, exponent=exponent)


class Pyramid(Gap):
    """A regular pyramid with this many faces; ``flat``: inradius of its cut tip; ``rounded``: radius of curvature of a round one."""

    def __init__(
        self, faces: int, inclination: float, flat: float | None = None, rounded: float | None = None
    ) -> None:
        super().__init__("pyramid", faces=faces, inclination=inclination, flat=flat, rounded=rounded)


class _Indenter(Gap):
    _kind: str

    def __init__(
        self, face_angle: float | None = None, *, flat: float | None = None, rounded: float | None = None
    ) -> None:
        super().__init__(self._kind, face_angle=face_angle, flat=flat, rounded=rounded)


class Berkovich(_Indenter):
    """A pyramid of three faces, 65.27 degrees from the axis to a face unless ``face_angle`` says otherwise; ``flat``: inradius of a cut
    tip; ``rounded``: radius of curvature of a round one."""

    _kind = "berkovich"


class Vickers(_Indenter):
    """The same with four faces, 68 degrees from the axis to a face: 136 between opposite ones."""

    _kind = "vickers"


class CubeCorner(_Indenter):
    """The same with the three faces of a cube, 35.26 degrees from the axis."""

    _kind = "cube_corner"


class Polyhedron(Gap):
    """The highest of planes, (slope_x, slope_y, offset) each."""

    def __init__(self, planes: npt.ArrayLike) -> None:
        super().__init__("polyhedron", planes=planes)


class Flat(Gap):
    """A flat end: exactly one of ``disc`` (radius), ``ellipse`` (semi-axes) and ``polygon`` (corners)."""

    def __init__(
        self, *, disc: float | None = None, ellipse: _Pair | None = None, polygon: npt.ArrayLike | None = None
    ) -> None:
        super().__init__("flat", outline=_outline(disc, ellipse, polygon))


class Revolved(Gap):
    """A gap of revolution through points (r, z)."""

    def __init__(self, points: npt.ArrayLike) -> None:
        super().__init__("revolved", points=points)


class Formula(Gap):
    """A gap as text: ``"x^2/2 + 0.1*abs(y)^3"`` in x, y, r and theta; what is known of it follows from how it is written."""

    def __init__(
        self,
        expression: str,
        *,
        disc: float | None = None,
        ellipse: _Pair | None = None,
        polygon: npt.ArrayLike | None = None,
    ) -> None:
        region = None
        if (disc, ellipse, polygon) != (None, None, None):
            region = _outline(disc, ellipse, polygon)
        super().__init__("formula", expression=expression, region=region)


class Function(Gap):
    """A gap given by a function f(x, y) of two arrays of points (one-dimensional, of one length) that returns the gaps there, ``inf``
    where there is no material. Nothing is known of it but its values: errors are estimates, and :class:`Formula` is better wherever
    it can be written."""

    def __init__(self, function: Callable[[_Values, _Values], npt.ArrayLike]) -> None:
        if not callable(function):
            raise SceneError("gap", repr(function), "a function of two arrays")
        super().__init__("given")
        self._keys["function"] = function


class HeightMap(Gap):
    """A measured surface: ``heights[j, i]`` at x = x0 + i dx, y = y0 + j dy, as in a picture drawn with ``origin="lower"``.

    ``heights`` may be of any type of number, strided, with holes (NaN, or masked); or the name of a file. ``spacing`` is (dx, dy) or one
    number. ``surface`` says whose heights these are: ``"lower"`` (peaks touch first) or ``"upper"``. Further keys are those of
    ``height_map`` in a scene (``level="plane"``, ``scale``, ``zero``, ``against``, ...).
    """

    def __init__(
        self,
        heights: npt.ArrayLike | str,
        spacing: float | _Pair | None = None,
        *,
        surface: str,
        origin: _Pair | None = None,
        **keys: Any,
    ) -> None:
        steps = None if spacing is None else np.broadcast_to(np.asarray(spacing, dtype=float), 2).tolist()
        super().__init__("height_map", file=heights, spacing=steps, surface=surface, origin=origin, **keys)

    @classmethod
    def of(cls, topography: Topography, *, surface: str = "lower", unit: str | None = "m", **keys: Any) -> HeightMap:
        """A topography of any package that has ``heights()`` (first index x; masked where nothing was measured), ``physical_sizes`` and
        ``unit``. Lengths are converted from its unit to ``unit``; None leaves the numbers as they are. Periodic ones are refused."""
        if getattr(topography, "is_periodic", False):
            raise SceneError("gap", "a periodic topography", "one that is not periodic: detrend it, or cut it out")
        heights: _Values = np.ma.filled(np.ma.asarray(topography.heights(), dtype=float), np.nan)
        if heights.ndim != 2:
            raise SceneError("gap", f"heights of shape {heights.shape}", "heights of two dimensions")
        given = getattr(topography, "unit", None)
        factor = 1.0 if unit is None or given is None else _metres(given) / _metres(unit)
        sizes = np.asarray(topography.physical_sizes, dtype=float) * factor
        if sizes.shape != (2,):
            raise SceneError("gap", f"physical_sizes {topography.physical_sizes!r}", "two lengths")
        # A pixel of width dx holds each height: n of them make up the size.
        spacing = sizes / heights.shape
        return cls(heights.T * factor, spacing.tolist(), surface=surface, **keys)


class Profile(Gap):
    """A measured line y, z across a body: an array of points (n, 2), or the name of a file (two columns, ``.ban``, ``.whl``).

    ``along`` is the axis along which it is extruded, ``radius`` that with which it rolls. Further keys are those of ``profile`` in a
    scene (``unit``, ``mirror``, ``shift``, ``turn``, ``between``, ``smooth``, ``zero``, ...).
    """

    def __init__(
        self,
        line: npt.ArrayLike | str,
        *,
        along: str,
        surface: str | None = None,
        radius: float | None = None,
        **keys: Any,
    ) -> None:
        given = {"file": line} if isinstance(line, str) else {"points": np.asarray(line, dtype=float).tolist()}
        super().__init__("profile", **given, along=along, surface=surface, radius=radius, **keys)


class Sum(Gap):
    """The sum of gaps: two curved bodies."""

    def __init__(self, *of: Gap | Callable[..., Any] | Mapping[str, Any]) -> None:
        super().__init__("sum", of=list(of))


class Min(Gap):
    """The least of gaps: a punch with several tips."""

    def __init__(self, *of: Gap | Callable[..., Any] | Mapping[str, Any]) -> None:
        super().__init__("min", of=list(of))


@runtime_checkable
class Topography(Protocol):
    """What :meth:`HeightMap.of` takes."""

    @property
    def physical_sizes(self) -> Any: ...

    def heights(self) -> Any: ...


def _outline(disc: float | None, ellipse: _Pair | None, polygon: npt.ArrayLike | None) -> dict[str, Any]:
    shapes = {"disc": disc, "ellipse": ellipse, "polygon": polygon}
    return {name: shape for name, shape in shapes.items() if shape is not None}


_UNITS = {
    **dict.fromkeys(["m", "meter", "metre"], 1.0),
    **dict.fromkeys(["km"], 1e3),
    **dict.fromkeys(["cm"], 1e-2),
    **dict.fromkeys(["mm"], 1e-3),
    **dict.fromkeys(["um", "µm", "μm", "micron"], 1e-6),
    **dict.fromkeys(["nm"], 1e-9),
    **dict.fromkeys(["Å", "A", "Angstrom"], 1e-10),
    **dict.fromkeys(["pm"], 1e-12),
}


def _metres(unit: str) -> float:
    if unit not in _UNITS:
        raise SceneError("gap.unit", repr(unit), f"one of {', '.join(_UNITS)}, or unit=None for numbers as they are")
    return _UNITS[unit]
