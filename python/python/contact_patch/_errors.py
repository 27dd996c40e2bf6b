"""What can be wrong with a scene, and what can stop a solve."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._solution import Solution


class SceneError(ValueError):
    """A scene that is wrong: where (``path``, as in ``gap.radii[0]``), what was ``given``, what is ``allowed``."""

    def __init__(self, path: str, given: str, allowed: str) -> None:
        super().__init__(path, given, allowed)
        self.path = path
        self.given = given
        self.allowed = allowed

    def __str__(self) -> str:
        return f"{self.path}: given {self.given}; allowed: {self.allowed}"


class Unsolved(RuntimeError):
    """A scene without the answer that was asked for. ``solution`` has the verdict, and the best numbers there are."""

    def __init__(self, verdict: str, reason: str, solution: Solution | None = None) -> None:
        super().__init__(verdict, reason, solution)
        self.verdict = verdict
        self.reason = reason
        self.solution = solution

    def __str__(self) -> str:
        return f"{self.verdict}: {self.reason}"
