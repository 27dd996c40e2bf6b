"""The recipes for clusters, run for real: 10^5 scenes on two processes, with wrong rows, a slow one, and a worker that dies in mid-run.
Answers are those of one process, to the last digit."""

import os
import signal
import sys
from pathlib import Path

import numpy as np
import pytest

from contact_patch import solve_table

pandas = pytest.importorskip("pandas")

ROWS = 100_000
TEMPLATE = {
    "effective_modulus": 1.0,
    "gap": {"kind": "paraboloid", "radii": [1.0, 2.0]},
    "loading": {"depth": 1.0},
    "solve": {},
}
OUTPUTS = ["force", "patch.area", "method"]
# Row -> what is wrong with it.
WRONG = {7: ("/gap/radii/1", -1.0), ROWS // 2: ("/loading/depth", np.inf), ROWS - 1: ("/gap/radii/1", np.nan)}
SLOW = ROWS // 3


def frame():
    rng = np.random.default_rng(11)
    table = pandas.DataFrame(
        {"id": np.arange(ROWS), "/loading/depth": rng.uniform(-0.1, 1.0, ROWS), "/gap/radii/1": rng.uniform(1.0, 4.0, ROWS)}
    )
    for row, (column, value) in WRONG.items():
        table.loc[row, column] = value
    # Ten thousand times the work of its neighbours.
    table["/solve/method"] = np.where(table["id"] == SLOW, "fft", "closed_form")
    table["/solve/tolerance"] = np.where(table["id"] == SLOW, 1e-5, 1e-3)
    return table


@pytest.fixture(scope="module")
def alone():
    return solve_table(TEMPLATE, frame(), outputs=OUTPUTS)


def die_once(flag: str) -> None:
    """Kills the process that calls it, the first time."""
    try:
        os.close(os.open(flag, os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return
    os.kill(os.getpid(), signal.SIGKILL)


def same(found, alone):
    found = found.sort_values("id", ignore_index=True)
    for name in ("force", "patch.area"):
        assert np.array_equal(found[name].to_numpy(), alone[name].to_numpy(), equal_nan=True)
    for name in ("verdict", "method"):
        assert found[name].fillna("").tolist() == alone[name].fillna("").tolist()
    assert found.index[found["verdict"] == "wrong_scene"].tolist() == sorted(WRONG)
    assert found["method"][SLOW] == "fft" and found["force"][SLOW] > 0


def test_dask(alone, tmp_path):
    distributed = pytest.importorskip("distributed")
    from dask import dataframe

    flag = str(tmp_path / "died")

    def answer(part):
        if (part["id"] == ROWS // 2).any():
            die_once(flag)
        return solve_table(TEMPLATE, part, outputs=OUTPUTS)

    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, local_directory=str(tmp_path), silence_logs=50
    )
    with cluster, distributed.Client(cluster):
        table = dataframe.from_pandas(frame(), npartitions=20)
        meta = solve_table(TEMPLATE, frame().iloc[:0], outputs=OUTPUTS)
        found = table.map_partitions(answer, meta=meta).compute()
    assert Path(flag).exists()
    same(found, alone)


@pytest.mark.filterwarnings("ignore:PySpark does not yet:FutureWarning")
def test_spark(alone, tmp_path, monkeypatch):
    pyspark = pytest.importorskip("pyspark")
    pyarrow = pytest.importorskip("pyarrow")
    import shutil

    if shutil.which("java") is None:
        pytest.skip("Spark needs Java")
    monkeypatch.setenv("PYSPARK_PYTHON", sys.executable)
    monkeypatch.setenv("SPARK_LOCAL_IP", "127.0.0.1")
    from pyspark import cloudpickle
    from pyspark.sql import SparkSession

    # The workers do not have this file.
    cloudpickle.register_pickle_by_value(sys.modules[__name__])

    flag = str(tmp_path / "died")

    def answer(batches):
        for batch in batches:
            if ROWS // 2 in batch.column("id").to_pylist():
                die_once(flag)
            yield solve_table(TEMPLATE, batch, outputs=OUTPUTS)

    # Two processes; a task may fail four times.
    session = (
        SparkSession.builder.master("local[2,4]")
        .config("spark.ui.enabled", "false")
        .config("spark.sql.shuffle.partitions", "2")
        .config("spark.driver.host", "127.0.0.1")
        .config("spark.local.dir", str(tmp_path))
        .getOrCreate()
    )
    try:
        session.sparkContext.setLogLevel("OFF")
        from pyspark.sql.pandas.types import from_arrow_schema

        rows = pyarrow.Table.from_pandas(frame(), preserve_index=False)
        # What comes out, told by a table without rows.
        schema = from_arrow_schema(solve_table(TEMPLATE, rows.slice(0, 0), outputs=OUTPUTS).schema)
        table = session.createDataFrame(rows).repartition(8)
        found = table.mapInArrow(answer, schema).toArrow().to_pandas()
    finally:
        session.stop()
    assert Path(flag).exists()
    same(found, alone)
    assert pyspark.__version__


def test_ray(alone):
    ray = pytest.importorskip("ray")
    ray.init(num_cpus=2, include_dashboard=False)
    try:
        table = ray.data.from_pandas(frame())
        found = table.map_batches(lambda part: solve_table(TEMPLATE, part, outputs=OUTPUTS), batch_format="pandas").to_pandas()
    finally:
        ray.shutdown()
    same(found, alone)
