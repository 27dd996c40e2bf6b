"""From what a user writes to what is solved: a text, and beside it arrays of heights and functions."""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._errors import SceneError
from ._numbers import numbers
from .gap import Function, Gap, HeightMap, Topography

if TYPE_CHECKING:
    from ._curve import Curve
    from ._solution import Solution

Body = Mapping[str, float] | str
"""``{"youngs_modulus": 2.1e11, "poissons_ratio": 0.3}``, ``{"shear_modulus": ..., "poissons_ratio": ...}`` or ``"rigid"``."""

_METHOD_KEYS = ("method", "tolerance", "cells", "kernel", "evidence", "boundary", "seconds")


class Contact:
    """Two bodies, the gap between them, a loading, and how to solve it.

    ``gap``: a gap of :mod:`contact_patch.gap`, a dict, a function f(x, y) of arrays, or a topography. Bodies: ``modulus`` (E*) or ``bodies``
    (one or two). Loading, exactly one of: ``depth`` (with ``tilt``), ``force`` (with ``through`` or ``moment``), each a number or a list.
    ``units``: labels of tables and pictures, ``{"length": "mm", "force": "N"}``; numbers are not converted.
    ``outputs``: what to compute besides (``"patch"``, ``"pressure"``, ``"gap"``, ``"bracket"``, ``"curve"``, ``"energy"``). The other keys
    are those of ``solve`` in a scene. Angles of gaps are in degrees, ``tilt`` in radians.

    >>> from contact_patch import Contact, gap
    >>> Contact(gap=gap.Cone(45.0), modulus=1.0, depth=1.0).solve().evidence
    'exact'
    """

    def __init__(
        self,
        gap: Gap | Mapping[str, Any] | Callable[..., Any] | Topography,
        *,
        modulus: float | None = None,
        bodies: Sequence[Body] | None = None,
        depth: npt.ArrayLike | None = None,
        force: npt.ArrayLike | None = None,
        through: Sequence[float] | None = None,
        moment: Sequence[float] | None = None,
        tilt: Sequence[float] | None = None,
        name: str | None = None,
        units: Mapping[str, str] | None = None,
        outputs: Sequence[str] = (),
        method: str | None = None,
        tolerance: float | None = None,
        cells: int | str | None = None,
        kernel: str | None = None,
        evidence: str | None = None,
        boundary: Any = None,
        seconds: float | None = None,
    ) -> None:
        given = (method, tolerance, cells, kernel, evidence, boundary, seconds)
        solve = {key: value for key, value in zip(_METHOD_KEYS, given, strict=True) if value is not None}
        loading: dict[str, Any] = {}
        for key, value in (("depth", depth), ("force", force)):
            if value is not None:
                loading[key if np.ndim(value) == 0 else f"{key}s"] = value
        for key, value in (("through", through), ("moment", moment), ("tilt", tilt)):
            if value is not None:
                loading[key] = value
        scene = {
            "name": name,
            "units": units,
            "bodies": bodies,
            "effective_modulus": modulus,
            "gap": gap,
            "loading": loading,
            "solve": solve or None,
            "output": list(outputs) or None,
        }
        self._scene = {key: value for key, value in scene.items() if value is not None}

    def to_dict(self) -> dict[str, Any]:
        """The scene. Arrays and functions stay what they are."""
        return dict(self._scene)

    def solve(self, *, threads: int = 1, check: bool = False) -> Solution:
        """As :func:`contact_patch.solve`."""
        from ._api import solve

        return solve(self, threads=threads, check=check)

    def curve(self, *, accuracy: float = 1e-4, threads: int = 1) -> Curve:
        """As :func:`contact_patch.curve`."""
        from ._api import curve

        return curve(self, accuracy=accuracy, threads=threads)

    def __repr__(self) -> str:
        return f"Contact({', '.join(f'{key}={value!r}' for key, value in self._scene.items())})"


Scene = Contact | Mapping[str, Any] | str | os.PathLike[str] | bytes
"""A contact, a dict, JSON (text that begins with a brace, or bytes), or the path of a scene file."""

Heights = tuple[str, npt.NDArray[np.float64], tuple[int, int], tuple[float, float], tuple[float, float] | None]
Source = tuple[bytes, Path, list[Heights], list[tuple[str, Callable[..., Any]]]]


def source(scene: Scene) -> Source:
    """What the compiled part takes."""
    heights: list[Heights] = []
    functions: list[tuple[str, Callable[..., Any]]] = []
    if isinstance(scene, bytes | bytearray):
        return bytes(scene), Path(), heights, functions
    if isinstance(scene, str) and scene.lstrip("\ufeff \t\r\n").startswith("{"):
        return scene.encode(), Path(), heights, functions
    if isinstance(scene, str | os.PathLike):
        return _read(Path(scene)), Path(scene).parent, heights, functions
    if isinstance(scene, Contact):
        scene = scene.to_dict()
    if not isinstance(scene, Mapping):
        raise SceneError("$", f"a {type(scene).__name__}", "a Contact, a dict, JSON, or the path of a scene file")
    plain = _plain(scene, "", heights, functions)
    return json.dumps(plain).encode(), Path(), heights, functions


_LONGEST = 1 << 26
"""Bytes of the longest scene file that is read."""


def _read(path: Path) -> bytes:
    """A regular file of a limited size; to open a pipe would be to wait for its other end."""
    allowed = f"a regular file of at most {_LONGEST} bytes, a dict, or JSON"
    try:
        about = path.stat()
        if not stat.S_ISREG(about.st_mode):
            raise SceneError("$", f"{path} (not a regular file)", allowed)
        if about.st_size > _LONGEST:
            raise SceneError("$", f"{path} ({about.st_size} bytes)", allowed)
        return path.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, SceneError):
            raise
        what = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise SceneError("$", f"{path} ({what})", allowed) from error


def _plain(value: Any, path: str, heights: list[Heights], functions: list[tuple[str, Callable[..., Any]]]) -> Any:
    """The value with nothing in it that JSON cannot say."""
    if isinstance(value, Gap):
        value = value.to_dict()
    if isinstance(value, str | bool | int | float | None):
        return value
    if isinstance(value, Mapping):
        value = dict(value)
        if value.get("kind") == "given" and "function" in value:
            value["name"] = f"function {len(functions) + 1}"
            functions.append((value["name"], value.pop("function")))
        elif value.get("kind") == "height_map":
            for key in ("file", "against"):
                if key in value and not isinstance(value[key], str | os.PathLike):
                    value[key] = _heights(value[key], value, f"{path}.{key}".lstrip("."), heights)
        return {str(key): _plain(item, f"{path}.{key}".lstrip("."), heights, functions) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return np.ma.filled(value, np.nan).tolist() if isinstance(value, np.ma.MaskedArray) else value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Sequence):
        return [_plain(item, f"{path}[{k}]", heights, functions) for k, item in enumerate(value)]
    if isinstance(value, Topography):
        return _plain(HeightMap.of(value), path, heights, functions)
    if callable(value):
        return _plain(Function(value), path, heights, functions)
    raise SceneError(path or "$", f"a {type(value).__name__}", "what JSON can say, an array, or a gap of contact_patch.gap")


def _heights(values: Any, keys: Mapping[str, Any], path: str, heights: list[Heights]) -> str:
    """Keeps an array of heights; the name under which the scene finds it."""
    array = np.ma.filled(np.ma.asarray(values, dtype=np.float64), np.nan)
    if array.ndim != 2:
        raise SceneError(path, f"an array of shape {array.shape}", "heights[j, i] in two dimensions")
    spacing = keys.get("spacing")
    if spacing is None:
        raise SceneError(path.rpartition(".")[0] + ".spacing", "nothing", "the steps (dx, dy) between the heights")
    dx, dy = (float(step) for step in np.broadcast_to(np.asarray(spacing, dtype=float), 2))
    name = f"array {len(heights) + 1}"
    shape = (array.shape[1], array.shape[0])
    heights.append((name, numbers(array), shape, (dx, dy), None))
    return name
