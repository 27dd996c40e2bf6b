"""The answer."""

from __future__ import annotations

import copy
import html
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._errors import Unsolved
from ._numbers import numbers

_Fields = list[tuple[npt.NDArray[np.float64] | None, npt.NDArray[np.float64] | None]]


class Record:
    """A part of a result: its keys are attributes, its lists of numbers are arrays (NaN where there is none)."""

    def __init__(self, keys: dict[str, Any]) -> None:
        self._keys = keys

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return _value(self._keys[name], name)
        except KeyError:
            raise AttributeError(self._missing(name)) from None

    def _missing(self, name: str) -> str:
        return f"this result has no {name!r}; it has: {', '.join(self._keys)}"

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._keys]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Record) and self._keys == other._keys

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Record({', '.join(f'{key}={_brief(value)}' for key, value in self._keys.items())})"

    def to_dict(self) -> dict[str, Any]:
        """The same as a dict of plain numbers and lists."""
        return copy.deepcopy(self._keys)


class FieldRecord(Record):
    """A quantity with a field on a grid of cells: ``values[j, i]`` at ``x[i]``, ``y[j]`` (centres)."""

    def __init__(self, keys: dict[str, Any], values: npt.NDArray[np.float64] | None) -> None:
        super().__init__(keys)
        self._values = values

    def _missing(self, name: str) -> str:
        asked = "ask for it by outputs=['pressure'] or ['gap']"
        of_field = ("field", "values", "extent", "x", "y")
        return f"this result has no field; {asked}" if name in of_field else super()._missing(name)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, FieldRecord) or self._keys != other._keys:
            return False
        return np.array_equal(_or_empty(self._values), _or_empty(other._values), equal_nan=True)

    @property
    def values(self) -> npt.NDArray[np.float64]:
        """The field, ``values[j, i]`` of cell (i, j): y down the rows, x along them."""
        nx, ny = self._grid()[2]
        if self._values is None:
            raise AttributeError(self._missing("field"))
        return self._values.reshape(ny, nx)

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """(left, right, bottom, top), as ``matplotlib.pyplot.imshow(values, extent=extent, origin="lower")`` takes it."""
        (x, y), (dx, dy), (nx, ny) = self._grid()
        return (x, x + nx * dx, y, y + ny * dy)

    @property
    def x(self) -> npt.NDArray[np.float64]:
        """Centres of the cells along x."""
        return self._centres(0)

    @property
    def y(self) -> npt.NDArray[np.float64]:
        """Centres of the cells along y."""
        return self._centres(1)

    def _centres(self, m: int) -> npt.NDArray[np.float64]:
        origin, spacing, shape = self._grid()
        return np.asarray(origin[m] + (np.arange(shape[m]) + 0.5) * spacing[m], dtype=np.float64)

    def _grid(self) -> tuple[list[float], list[float], list[int]]:
        if "field" not in self._keys:
            raise AttributeError(self._missing("field"))
        field = self._keys["field"]
        return field["origin"], field["spacing"], field["shape"]


class Solution(Record):
    """The answer to a scene. Attributes are the keys of a result: ``force``, ``depth``, ``stiffness``, ``force_error``, ``evidence``,
    ``bracket.lower``, ``patch.area``, ``patch.boundary``, ``pressure.max``, ``pressure.values``, ``verdict``, ...; arrays and lists, one
    entry a state, when the loading is a list.
    """

    def __init__(self, keys: dict[str, Any], fields: _Fields) -> None:
        super().__init__(keys)
        self._fields = fields

    def __getattr__(self, name: str) -> Any:
        if name in ("pressure", "gap") and name in self._keys:
            part = self._keys[name]
            which = 0 if name == "pressure" else 1
            if isinstance(part, list):
                return [None if p is None else FieldRecord(p, f[which]) for p, f in zip(part, self._fields, strict=True)]
            return FieldRecord(part, self._fields[0][which])
        if name == "gap":
            raise AttributeError("this result has no gap; ask for it by outputs=['gap']")
        return super().__getattr__(name)

    @property
    def solved(self) -> bool:
        """Whether every state has the answer that was asked for."""
        return bool(self._keys["verdict"] == "solved")

    def check(self) -> Solution:
        """Itself. Raises :class:`Unsolved` unless it is solved."""
        if not self.solved:
            raise Unsolved(self._keys["verdict"], self._keys.get("reason", ""), self)
        return self

    def __len__(self) -> int:
        return len(self._fields)

    def __iter__(self) -> Iterator[Solution]:
        return (self[k] for k in range(len(self)))

    def __getitem__(self, k: int) -> Solution:
        """One state alone."""
        n = len(self._fields)
        if not -n <= k < n:
            raise IndexError(f"state {k} of {n}")
        if not self._is_list():
            return self
        k %= n
        keys: dict[str, Any] = {}
        for key, value in self._keys.items():
            if key in _OF_THE_WHOLE:
                keys[key] = value
            elif value[k] is not None:
                keys[key] = value[k]
        if "verdicts" in keys:
            keys["verdict"] = keys.pop("verdicts")
            for whole, each in (("reason", "reasons"), ("hint", "hints")):
                keys.pop(whole, None)
                if each in keys:
                    keys[whole] = keys.pop(each)
        return Solution(keys, [self._fields[k]])

    def _is_list(self) -> bool:
        loading = self._keys["scene"].get("loading", {})
        return any(key in loading for key in ("depths", "forces", "depth_range"))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Solution) or self._keys != other._keys or len(self) != len(other):
            return False
        pairs = ((a, b) for mine, its in zip(self._fields, other._fields, strict=True) for a, b in zip(mine, its, strict=True))
        return all(np.array_equal(_or_empty(a), _or_empty(b), equal_nan=True) for a, b in pairs)

    def to_dict(self) -> dict[str, Any]:
        """The result as ``contact-patch solve -o result.json`` writes it."""
        whole = super().to_dict()
        for which, name in enumerate(("pressure", "gap")):
            parts = whole.get(name)
            for k, part in enumerate(parts if isinstance(parts, list) else [parts]):
                values = self._fields[k][which] if part else None
                if values is not None:
                    part["field"]["values"] = [value if np.isfinite(value) else None for value in values.tolist()]
        return whole

    def to_json(self) -> str:
        """The same as JSON."""
        return json.dumps(self.to_dict())

    def to_vti(self, path: str | Path | None = None) -> bytes:
        """The fields of pressure and gap (as far as they were asked for) for ParaView, VTK image data; also written to ``path``."""
        fields = [(name, getattr(self, name)) for name in ("pressure", "gap") if "field" in self._one().get(name, {})]
        if not fields:
            raise Unsolved("no_field", "there is no field to write: ask for outputs=['pressure'] or ['gap']", self)
        on = fields[0][1]._grid()
        data = _core.vti(on, [(name, numbers(part._values)) for name, part in fields if part._grid() == on])
        if path is not None:
            Path(path).write_bytes(data)
        return data

    def to_svg(self) -> str | None:
        """The boundary of the patch and the pressure as a picture, as far as they were asked for; None without both."""
        one = self._one()
        field = None
        if "field" in one.get("pressure", {}):
            pressure = self.pressure
            field = (pressure._grid(), numbers(pressure._values))
        without_end = one.get("pressure", {}).get("singular") is not None
        boundary = one.get("patch", {}).get("boundary") or []
        return _core.picture(one["scene"].get("name") or "", boundary, field, without_end)

    def _one(self) -> dict[str, Any]:
        if self._is_list():
            raise ValueError(f"{len(self)} states: choose one, as in solution[-1]")
        return self._keys

    def _rows(self) -> list[tuple[str, str]]:
        """What people look at first."""
        keys = self._keys
        rows = [("verdict", keys["verdict"])]
        rows += [(key, str(keys[key])) for key in ("reason", "hint") if key in keys]
        for name, path in _SHOWN:
            value: Any = keys
            for step in path:
                value = value.get(step) if isinstance(value, dict) else None
            if value is not None:
                rows.append((name, _brief(value)))
        return rows

    def __repr__(self) -> str:
        return f"Solution({', '.join(f'{name}={value}' for name, value in self._rows())})"

    def _repr_html_(self) -> str:
        cell = "<tr><th style='text-align:left'>{}</th><td style='text-align:left'>{}</td></tr>"
        rows = "".join(cell.format(*map(html.escape, row)) for row in self._rows())
        name = self._keys["scene"].get("name")
        caption = f"<caption>{html.escape(name)}</caption>" if name else ""
        svg = None if self._is_list() else self.to_svg()
        return f"<table>{caption}{rows}</table>{svg or ''}"


# Keys that are said once for all states.
_OF_THE_WHOLE = ("scene", "verdict", "reason", "hint", "left_out", "remarks", "curve")

_SHOWN = [
    ("method", ("method",)),
    ("depth", ("depth",)),
    ("force", ("force",)),
    ("force error", ("force_error",)),
    ("evidence", ("evidence",)),
    ("force at least", ("bracket", "lower")),
    ("force at most", ("bracket", "upper")),
    ("stiffness", ("stiffness",)),
    ("patch area", ("patch", "area")),
    ("largest pressure", ("pressure", "max")),
]


def _or_empty(values: npt.NDArray[np.float64] | None) -> npt.NDArray[np.float64]:
    return np.empty(0) if values is None else values


def _value(value: Any, name: str) -> Any:
    """Dicts as records, lists of numbers as arrays."""
    if isinstance(value, dict):
        return Record(value)
    if not isinstance(value, list):
        return value
    if name == "boundary":
        return _boundary(value)
    if value and all(isinstance(item, dict) or item is None for item in value):
        if any(isinstance(item, dict) for item in value):
            return [None if item is None else Record(item) for item in value]
        return list(value)
    if any(isinstance(item, str | bool) for item in value):
        return list(value)
    return _array(value)


def _boundary(value: list[Any]) -> Any:
    """Closed lines: one array of points each."""
    return [np.asarray(line, dtype=np.float64).reshape(-1, 2) for line in value]


def _array(value: list[Any]) -> Any:
    """Numbers and lists of numbers as an array, where they make one; None as NaN."""
    if not value:
        return np.empty(0)
    lists = [item for item in value if isinstance(item, list)]
    if not lists:
        return np.array([np.nan if item is None else item for item in value])
    rows = [_array(item) if isinstance(item, list) else None for item in value]
    shapes = {row.shape for row in rows if isinstance(row, np.ndarray)}
    if len(shapes) != 1 or any(isinstance(row, list) for row in rows):
        return rows
    shape = shapes.pop()
    return np.array([np.full(shape, np.nan) if row is None else row for row in rows])


def _brief(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, dict):
        return "{" + ", ".join(value) + "}"
    if isinstance(value, list) and len(value) > 4:
        return f"[{_brief(value[0])}, ..., {_brief(value[-1])}]"
    if isinstance(value, list):
        return f"[{', '.join(map(_brief, value))}]"
    return str(value)
