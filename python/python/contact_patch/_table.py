"""Many scenes: a template, and a table of what stands at some of its places."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._api import _threads
from ._errors import SceneError
from ._numbers import numbers
from ._scene import Scene, source

OUTPUTS = ("depth", "force", "force_error", "stiffness", "patch.area", "pressure.max")
"""What is taken of each answer unless said."""

_Column = npt.NDArray[Any] | list[Any]
# The columns of a table by name, and how answers are put beside them.
_Opened = tuple[dict[Any, Any], Callable[[dict[str, Any]], Any]]


def solve_table(
    template: Scene, table: Any, *, outputs: Sequence[str] = OUTPUTS, threads: int = 1, seconds: float | None = None
) -> Any:
    """Solves a scene for each row of a table.

    ``template`` is a scene; columns of the table that are named by JSON pointers (``/loading/depth``, ``/gap/radii/0``, ``/solve/method``)
    fill places of it, a value a row; other columns are carried along. ``table`` is a dict of arrays, a structured array, a frame of pandas
    or polars, a table or record batch of pyarrow, or anything with ``__arrow_c_stream__``; the same kind comes back (a pyarrow table for
    the last), with a column for each of ``outputs`` (places in a result: ``force``, ``patch.area``, ``moment[0]``, ``bracket.lower``; words:
    ``method``, ``evidence``, ``reason``) and with ``verdict``.

    A row never stops the others: numbers that it has not are NaN, and its verdict is not ``solved``: ``wrong_scene`` for a row that is not
    a scene (``reason`` tells why), else as for a scene alone. Only a wrong template raises :class:`SceneError`. ``seconds``: CPU seconds
    that a row may take (60 unless the template says otherwise; 0: no limit). Answers do not depend on ``threads``.

    >>> import numpy as np
    >>> from contact_patch import Contact, gap, solve_table
    >>> template = Contact(gap.Paraboloid(1.0), modulus=0.75, depth=1.0)
    >>> solve_table(template, {"/loading/depth": np.array([1.0, 4.0])}, outputs=["force"])["force"].round(9).tolist()
    [1.0, 8.0]
    """
    columns, closed = _opened(table)
    places = {name: column for name, column in columns.items() if isinstance(name, str) and name.startswith("/")}
    if not places:
        given = ", ".join(map(repr, columns)) or "no column"
        raise SceneError("table", given, "a column named by a JSON pointer into the template, such as '/loading/depth'")
    for name in (*outputs, "verdict"):
        if name in columns or list(outputs).count(name) > 1:
            raise SceneError("outputs", repr(name), "names that differ from each other and from the columns of the table")
    if seconds is not None and not (0.0 <= seconds < np.inf):
        raise SceneError("seconds", repr(seconds), "CPU seconds, 0 or more; 0: no limit")
    cells = [(name, _cells(name, column)) for name, column in places.items()]
    answers, verdicts, words = _core.table(source(template), cells, list(outputs), _threads(threads), seconds)
    found: dict[str, Any] = dict(zip(outputs, answers, strict=True))
    found["verdict"] = np.array(words, dtype=object)[verdicts] if len(verdicts) else np.empty(0, dtype=object)
    return closed(found)


def _cells(name: str, column: Any) -> npt.NDArray[np.float64] | list[str]:
    """Numbers as they are, everything else as JSON."""
    try:
        array = np.ma.filled(column.astype(float), np.nan) if isinstance(column, np.ma.MaskedArray) else np.asarray(column)
    except ValueError:
        # Lists among numbers: each cell stays what it is, and is wrong for its own row alone.
        array = np.array([*column, None], dtype=object)[:-1]
    if array.dtype.kind in "US" and not isinstance(column, np.ndarray):
        # Numbers and words in one list: each stays what it is.
        array = np.array([*column, None], dtype=object)[:-1]
    if array.ndim == 1 and array.dtype.kind in "fiu":
        return numbers(array)
    if array.ndim == 0:
        raise SceneError(name, repr(column), "one value a row")
    plain = array.tolist() if array.ndim > 1 or array.dtype != object else [_plain(item) for item in array]
    try:
        return [json.dumps(item, allow_nan=False) for item in plain]
    except (TypeError, ValueError):
        # A cell that JSON cannot say is wrong for its own row alone.
        return [_text(item) for item in plain]


def _plain(item: Any) -> Any:
    if isinstance(item, Decimal):
        return float(item)
    return item.tolist() if isinstance(item, np.ndarray | np.generic) else item


def _text(item: Any) -> str:
    try:
        return json.dumps(item, allow_nan=False)
    except (TypeError, ValueError):
        return "null"


def _opened(table: Any) -> _Opened:
    """The columns of a table, and how its kind is made again with more of them."""
    package = type(table).__module__.partition(".")[0]
    if package == "pandas" and hasattr(table, "columns"):
        return _of_pandas(table)
    if package == "polars" and hasattr(table, "get_columns"):
        return {s.name: _of_polars(s) for s in table.get_columns()}, lambda found: table.with_columns(
            **{name: _series(name, values) for name, values in found.items()}
        )
    if isinstance(table, Mapping):
        return dict(table), lambda found: {**table, **_arrays(found)}
    if isinstance(table, np.ndarray) and table.dtype.names:
        return {name: table[name].ravel() for name in table.dtype.names}, lambda found: _structured(table, _arrays(found))
    if package == "pyarrow" and hasattr(table, "column_names"):
        return _of_arrow(table)
    if hasattr(table, "__arrow_c_stream__"):
        import pyarrow

        return _of_arrow(pyarrow.table(table))
    allowed = "a dict of arrays, a structured array, a frame of pandas or polars, a pyarrow table, or an Arrow stream"
    raise SceneError("table", f"a {type(table).__name__}", allowed)


def _arrays(found: dict[str, Any]) -> dict[str, Any]:
    return {name: np.array(values, dtype=object) if isinstance(values, list) else values for name, values in found.items()}


def _structured(table: npt.NDArray[Any], found: dict[str, Any]) -> npt.NDArray[Any]:
    whole = np.empty(table.shape, dtype=[*table.dtype.descr, *((name, values.dtype) for name, values in found.items())])
    for name in table.dtype.names or ():
        whole[name] = table[name]
    for name, values in found.items():
        whole[name] = values.reshape(table.shape)
    return whole


def _of_pandas(table: Any) -> _Opened:
    def column(values: Any) -> Any:
        if values.dtype.kind in "fiu":
            return values.to_numpy(dtype=np.float64, na_value=np.nan)
        return values.to_numpy(dtype=object, na_value=None)

    def closed(found: dict[str, Any]) -> Any:
        import pandas

        new = {name: pandas.Series(values, index=table.index) for name, values in found.items()}
        return table.assign(**new)

    return {name: column(values) for name, values in table.items()}, closed


def _of_polars(values: Any) -> Any:
    if values.dtype.is_numeric():
        # Nulls become NaN.
        return values.cast(float).to_numpy()
    return np.array([*values.to_list(), None], dtype=object)[:-1]


def _series(name: str, values: Any) -> Any:
    import polars

    words = isinstance(values, list) or values.dtype == object
    return polars.Series(name, list(values), dtype=polars.String) if words else polars.Series(name, values)


def _of_arrow(table: Any) -> _Opened:
    import pyarrow

    def column(values: Any) -> Any:
        kind = values.type
        if pyarrow.types.is_integer(kind) or pyarrow.types.is_floating(kind):
            return values.cast(pyarrow.float64(), safe=False).to_numpy(zero_copy_only=False) if _is_array(values) else (
                values.cast(pyarrow.float64(), safe=False).to_numpy()
            )
        return np.array([*values.to_pylist(), None], dtype=object)[:-1]

    def closed(found: dict[str, Any]) -> Any:
        new = table
        for name, values in found.items():
            words = isinstance(values, list) or values.dtype == object
            new = new.append_column(name, pyarrow.array(values, type=pyarrow.string() if words else pyarrow.float64()))
        return new

    def _is_array(values: Any) -> bool:
        return isinstance(values, pyarrow.Array)

    return {name: column(table.column(name)) for name in table.column_names}, closed
