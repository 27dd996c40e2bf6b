"""Contact patch, force, stiffness and pressure of two bodies pressed together, with an error bar.

>>> from contact_patch import Contact, gap
>>> punch = Contact(gap=gap.Pyramid(faces=3, inclination=45.0), depth=1e-6,
...                 bodies=[{"youngs_modulus": 2.1e11, "poissons_ratio": 0.3}, "rigid"])
>>> solution = punch.solve()
>>> solution.evidence, bool(solution.bracket.lower <= solution.force <= solution.bracket.upper)
('proved', True)
"""

from . import gap
from ._api import curve, plan, schema, solve
from ._core import __version__
from ._curve import Curve
from ._errors import SceneError, Unsolved
from ._scene import Contact
from ._solution import FieldRecord, Record, Solution
from ._table import solve_table

__all__ = [
    "Contact",
    "Curve",
    "FieldRecord",
    "Record",
    "SceneError",
    "Solution",
    "Unsolved",
    "__version__",
    "curve",
    "gap",
    "plan",
    "schema",
    "solve",
    "solve_table",
]
