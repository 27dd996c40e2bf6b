"""The calls."""

from __future__ import annotations

import json
from typing import Any

from . import _core
from ._curve import Curve
from ._errors import SceneError
from ._scene import Scene, source
from ._solution import Solution


def _threads(threads: int) -> int:
    if not (isinstance(threads, int) and 1 <= threads <= 1024):
        raise SceneError("threads", repr(threads), "a whole number from 1 to 1024")
    return threads


def solve(scene: Scene, *, threads: int = 1, check: bool = False) -> Solution:
    """Solves a scene: a :class:`Contact`, a dict, JSON, or the path of a scene file.

    A scene that is wrong raises :class:`SceneError`, a ValueError with the path of what is wrong. A state that is not solved is an
    answer, with its ``verdict``; with ``check`` it raises :class:`Unsolved`. Ctrl-C ends it.

    >>> import contact_patch
    >>> solution = contact_patch.solve({"effective_modulus": 1.0, "gap": {"kind": "cone", "inclination": 45.0},
    ...                                 "loading": {"depth": 1.0}})
    >>> round(solution.force, 6)  # 2/pi
    0.63662
    """
    text, fields = _core.solve(source(scene), _threads(threads))
    solution = Solution(json.loads(text), fields)
    return solution.check() if check else solution


def plan(scene: Scene) -> dict[str, Any]:
    """What would run, why, and what is left out, without running it: ``{"method", "steps", "left_out"}``."""
    method, steps, left_out = _core.plan(source(scene))
    return {"method": method, "steps": steps, "left_out": left_out}


def curve(scene: Scene, *, accuracy: float = 1e-4, threads: int = 1) -> Curve:
    """Force over depth up to the largest load of a scene, to this relative error. Raises :class:`SceneError` for loads that make no curve,
    :class:`Unsolved` where a state is not solved."""
    if not 0.0 < accuracy < 1.0:
        raise SceneError("accuracy", repr(accuracy), "a number greater than 0 and less than 1")
    return Curve(_core.curve(source(scene), accuracy, _threads(threads)))


def schema() -> dict[str, Any]:
    """The JSON Schema of a scene."""
    whole: dict[str, Any] = json.loads(_core.schema())
    return whole
