"""Tables of scenes: each kind in, the same kind out, every row as if it were alone."""

import csv
import io
import math
from decimal import Decimal

import numpy as np
import pytest

from contact_patch import Contact, SceneError, gap, solve_table

TEMPLATE = Contact(gap.Paraboloid(1.0, 3.0), modulus=1.0, depth=1.0)
DEPTHS = np.linspace(-0.1, 0.9, 41)


def alone(depth):
    return Contact(gap.Paraboloid(1.0, 3.0), modulus=1.0, depth=float(depth)).solve()


def test_rows_are_what_scenes_alone_are():
    table = solve_table(TEMPLATE, {"/loading/depth": DEPTHS}, outputs=["force", "stiffness", "patch.area", "patch.centroid[0]", "method"])
    for k, depth in enumerate(DEPTHS):
        state = alone(depth)
        assert table["force"][k] == state.force and table["stiffness"][k] == state.stiffness
        assert table["patch.area"][k] == state.patch.area and table["method"][k] == state.method
        assert np.isnan(table["patch.centroid[0]"][k]) == (depth <= 0)
    assert set(table["verdict"]) == {"solved"}


def test_answers_do_not_depend_on_threads_or_order():
    rng = np.random.default_rng(7)
    columns = {"/gap/inclination": rng.uniform(1, 80, 500), "/gap/faces": rng.integers(3, 9, 500), "/loading/depth": rng.uniform(0, 1, 500)}
    template = Contact(gap.Pyramid(3, 45.0), modulus=1.0, depth=1.0, method="fabrikant")
    one = solve_table(template, columns)
    two = solve_table(template, columns, threads=2)
    back = solve_table(template, {name: column[::-1] for name, column in columns.items()}, threads=2)
    for name in ("force", "patch.area", "stiffness"):
        assert np.array_equal(one[name], two[name]) and np.array_equal(one[name], back[name][::-1])
    assert np.all(one["force"] > 0)


def test_wrong_rows_are_nan_with_a_verdict_and_stop_nothing():
    columns = {
        "/gap/inclination": np.array([45.0, 95.0, np.nan, 45.0, 45.0]),
        "/loading/depth": np.array([1.0, 1.0, 1.0, np.inf, 1.0]),
        "/solve/method": ["auto", "auto", "auto", "auto", "no such"],
    }
    table = solve_table(Contact(gap.Cone(1.0), modulus=1.0, depth=1.0, method="auto"), columns, outputs=["force", "reason"])
    assert table["verdict"].tolist() == ["solved"] + ["wrong_scene"] * 4
    assert table["force"][0] == pytest.approx(2 / np.pi) and np.isnan(table["force"][1:]).all()
    for word, reason in zip(["gap.inclination", "gap.inclination", "loading.depth", "solve.method"], table["reason"][1:], strict=True):
        assert word in reason
    assert table["reason"][0] is None


def test_cells_of_any_kind_are_wrong_for_their_own_row_alone():
    cells = [0.5, "x", None, math.inf, [1], {}, object(), 1.0]
    force = solve_table(SCENE, {"/loading/depth": cells}, outputs=["force", "reason"])
    assert force["verdict"].tolist() == ["solved", *["wrong_scene"] * 6, "solved"]
    assert force["force"][[0, -1]] == pytest.approx([FORCE[0], FORCE[2]]) and np.isnan(force["force"][1:-1]).all()
    assert all("loading.depth" in reason for reason in force["reason"][1:-1])
    ragged = solve_table(TEMPLATE, {"/gap/radii": [[1.0, 3.0], [1.0, 2.0, 3.0], [1.0, 3.0]]}, outputs=["force"])
    assert ragged["verdict"].tolist() == ["solved", "wrong_scene", "solved"]
    decimals = solve_table(SCENE, {"/loading/depth": [Decimal("0.5"), Decimal("1")]}, outputs=["force"])
    assert decimals["force"] == pytest.approx([FORCE[0], FORCE[2]])


def test_unsolved_rows_keep_their_best_numbers():
    template = Contact(gap.Paraboloid(1.0), modulus=1.0, depth=1.0, method="fft", cells=16, tolerance=1e-6)
    table = solve_table(template, {"/gap/radii/1": [1.0, 2.0, "flat"]}, outputs=["force", "force_error"])
    assert table["verdict"].tolist() == ["tolerance_not_reached"] * 2 + ["unbounded"]
    assert (table["force"][:2] > 0).all() and (table["force_error"][:2] > 1e-6).all() and np.isnan(table["force"][2])


def test_one_slow_row_holds_up_none_but_itself():
    template = Contact(gap.Formula("x^2 + y^2 + 0.1*abs(x)^3"), modulus=1.0, depth=1.0, method="fft", cells=32, tolerance=1e-3)
    columns = {"/solve/cells": np.array([32, 4000, 32]), "/solve/tolerance": np.array([0.5, 1e-9, 0.5])}
    table = solve_table(template, columns, seconds=0.5, threads=2)
    assert table["verdict"].tolist() == ["solved", "time_limit", "solved"]
    assert table["force"][0] == table["force"][2] > 0


def pandas_like(kind):
    module = pytest.importorskip(kind)
    return module


COLUMNS = {"name": ["a", "b", "c"], "/loading/depth": [0.5, -1.0, 1.0], "/solve/method": ["auto", "auto", "closed_form"]}
SCENE = Contact(gap.Cone(45.0), modulus=1.0, depth=1.0, method="auto")
FORCE = [0.25 * 2 / np.pi, 0.0, 2 / np.pi]


def test_numpy_keeps_its_kinds():
    table = solve_table(SCENE, COLUMNS, outputs=["force"])
    assert isinstance(table, dict) and list(table) == [*COLUMNS, "force", "verdict"] and table["name"] is COLUMNS["name"]
    assert table["force"] == pytest.approx(FORCE)
    rows = np.zeros((2, 2), dtype=[("/loading/depth", "f4"), ("k", "i8")])
    rows["/loading/depth"] = [[0.5, 1.0], [0.25, -1.0]]
    rows["k"] = [[1, 2], [3, 4]]
    answered = solve_table(SCENE, rows, outputs=["force", "method"])
    assert answered.shape == (2, 2) and answered.dtype.names == ("/loading/depth", "k", "force", "method", "verdict")
    assert answered["k"][1, 1] == 4 and answered["force"][0, 1] == pytest.approx(2 / np.pi) and answered["verdict"][0, 0] == "solved"


def crooked(values):
    """The same numbers, one byte off the places where doubles belong: as buffers that came over a network may lie."""
    values = np.ascontiguousarray(values, dtype=np.float64)
    moved = np.frombuffer(b"x" + values.tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(values.shape)
    assert not moved.flags.aligned
    return moved


def test_arrays_may_lie_anywhere():
    depths = np.array([0.25, 0.5, 1.0])
    assert np.array_equal(solve_table(SCENE, {"/loading/depth": crooked(depths)})["force"], solve_table(SCENE, {"/loading/depth": depths})["force"])
    y, x = np.mgrid[-5:6, -5:6] * 0.2
    straight, moved = (
        Contact(gap.HeightMap(z, 0.2, surface="upper"), modulus=1.0, depth=0.2, outputs=["pressure"]).solve()
        for z in (x**2 + y**2, crooked(x**2 + y**2))
    )
    assert straight.force == moved.force
    image = moved.to_vti()
    moved._fields = [(crooked(moved._fields[0][0]), None)]
    assert moved.to_vti() == image and moved.to_svg() == straight.to_svg()
    spring = Contact(gap.Cone(45.0), modulus=1.0, depth=1.0).curve()
    assert np.array_equal(spring(crooked(depths)), spring(depths))


def test_pandas_keeps_index_and_columns():
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame(COLUMNS, index=[7, 3, 5])
    table = solve_table(SCENE, frame, outputs=["force", "reason"])
    assert isinstance(table, pandas.DataFrame) and table.index.tolist() == [7, 3, 5]
    assert table["force"].tolist() == pytest.approx(FORCE) and (table["verdict"] == "solved").all() and table["reason"].isna().all()
    assert list(frame.columns) == list(COLUMNS), "the table that was given is as it was"
    gaps = frame.assign(**{"/loading/depth": pandas.array([1, None, 2], dtype="Int64")})
    assert solve_table(SCENE, gaps)["verdict"].tolist() == ["solved", "wrong_scene", "solved"]
    assert len(solve_table(SCENE, frame.iloc[:0])) == 0


def test_polars_keeps_its_frame():
    polars = pytest.importorskip("polars")
    table = solve_table(SCENE, polars.DataFrame(COLUMNS), outputs=["force", "reason"])
    assert isinstance(table, polars.DataFrame) and table.columns == [*COLUMNS, "force", "reason", "verdict"]
    assert table["force"].to_list() == pytest.approx(FORCE) and table["verdict"].to_list() == ["solved"] * 3
    missing = polars.DataFrame({"/loading/depth": [1, None]})
    assert solve_table(SCENE, missing)["verdict"].to_list() == ["solved", "wrong_scene"]


def test_arrow_keeps_tables_and_batches():
    pyarrow = pytest.importorskip("pyarrow")
    for make in (pyarrow.table, pyarrow.RecordBatch.from_pydict):
        given = make(COLUMNS)
        table = solve_table(SCENE, given, outputs=["force", "reason"])
        assert type(table) is type(given) and table.column("force").to_pylist() == pytest.approx(FORCE)
        assert table.schema.field("verdict").type == pyarrow.string() and table.column("reason").null_count == 3

    class Stream:
        def __arrow_c_stream__(self, requested_schema=None):
            return pyarrow.table(COLUMNS).__arrow_c_stream__(requested_schema)

    assert isinstance(solve_table(SCENE, Stream()), pyarrow.Table)


def test_a_function_or_a_map_is_read_once_for_all_rows():
    calls = []

    def bowl(x, y):
        calls.append(len(x))
        return (x**2 + y**2) / 2

    depths = np.array([0.5, 1.0])
    table = solve_table(Contact(bowl, modulus=1.0, depth=1.0), {"/loading/depth": depths}, outputs=["force", "force_error"])
    assert table["force"] == pytest.approx(4 / 3 * depths**1.5, rel=2e-3) and calls
    y, x = np.mgrid[-20:21, -20:21] * 0.1
    rough = Contact(gap.HeightMap((x**2 + y**2) / 2, 0.1, surface="upper"), modulus=1.0, depth=1.0)
    assert solve_table(rough, {"/loading/depth": depths})["force"] == pytest.approx(4 / 3 * depths**1.5, rel=2e-2)

    def failing(x, y):
        raise RuntimeError("out of order")

    with pytest.raises(RuntimeError, match="out of order"):
        solve_table(Contact(failing, modulus=1.0, depth=1.0), {"/loading/depth": depths})


@pytest.mark.parametrize(
    ("template", "table", "options", "told"),
    [
        (SCENE, {"depth": [1.0]}, {}, "JSON pointer"),
        (SCENE, {"/loading/depth/x": [1.0]}, {}, "/loading/depth"),
        (SCENE, {"/nothing/here": [1.0]}, {}, "template"),
        (SCENE, {"/loading/depth": [1.0], "/solve/cells": [1, 2]}, {}, "rows"),
        (SCENE, {"/loading/depth": [1.0]}, {"outputs": ["farce"]}, "farce"),
        (SCENE, {"/loading/depth": [1.0], "force": [1.0]}, {"outputs": ["force"]}, "differ"),
        (SCENE, {"/loading/depth": [1.0]}, {"seconds": -1.0}, "seconds"),
        (SCENE, {"/loading/depth": [1.0]}, {"threads": 0}, "threads"),
        (SCENE, {"/loading/depth": 1.0}, {}, "one value a row"),
        (SCENE, [1.0], {}, "list"),
        ({"gap": {"kind": "cone", "inclined": 1}, "loading": {}, "effective_modulus": 1}, {"/loading/depth": [1.0]}, {}, "inclined"),
        (Contact(gap.Cone(1.0), modulus=1.0, depth=[1.0, 2.0]), {"/gap/inclination": [1.0]}, {}, "one load a row"),
    ],
)
def test_what_is_wrong_with_the_whole_is_raised(template, table, options, told):
    with pytest.raises(SceneError, match=told):
        solve_table(template, table, **options)


def test_the_command_answers_a_csv_the_same(command, tmp_path):
    (tmp_path / "scene.json").write_text('{"effective_modulus": 1, "gap": {"kind": "cone", "inclination": 45}, "loading": {}}')
    rows = io.StringIO()
    depths = [0.1, -2.0, 1 / 3]
    csv.writer(rows).writerows([["id", "/loading/depth"], *zip(["a,b", 'q"', "c"], map(repr, depths), strict=True), ["bad", "x"]])
    (tmp_path / "rows.csv").write_text(rows.getvalue())
    run = command("batch", "--table", tmp_path / "rows.csv", "--template", tmp_path / "scene.json", "--outputs", "force,reason")
    assert run.returncode == 0, run.stderr
    answers = list(csv.DictReader(io.StringIO(run.stdout)))
    mine = solve_table(tmp_path / "scene.json", {"/loading/depth": depths}, outputs=["force"])
    assert [float(row["force"]) for row in answers[:3]] == mine["force"].tolist()
    assert answers[3]["force"] == "" and answers[3]["verdict"] == "wrong_scene" and "loading.depth" in answers[3]["reason"]
    assert [row["id"] for row in answers] == ["a,b", 'q"', "c", "bad"]
