"""The code of the README runs as it stands there, and what it says of the shell, too."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from contact_patch import Contact, gap, solve_table

TEXT = (Path(__file__).parents[1] / "README.md").read_text()


def test_its_code_runs():
    names = {}
    blocks = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    assert len(blocks) >= 5
    for block in blocks:
        exec(compile(block, "README.md", "exec"), names)
    assert set(names["answers"]["verdict"]) == {"solved"} and names["spring"](0.05) > 0
    forces = [names[name].solve().force for name in ("measured", "written", "function")]
    assert max(forces) == pytest.approx(min(forces), rel=0.01)


RECIPES = re.findall(r"```py\n(.*?)```", TEXT, re.DOTALL)


def test_its_recipes_are_python():
    assert len(RECIPES) == 4
    for recipe in RECIPES:
        compile(recipe, "README.md", "exec")


def test_its_recipe_for_dask_runs():
    dask = pytest.importorskip("dask")
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("dask.dataframe")
    template = Contact(gap.Cone(45.0), modulus=1.0, depth=1.0)
    frame = pandas.DataFrame({"/loading/depth": np.linspace(0.1, 1.0, 1000)})
    names = {"dask": dask, "frame": frame, "solve_table": solve_table, "template": template}
    exec(compile(RECIPES[0], "README.md", "exec"), names)
    pandas.testing.assert_frame_equal(names["answers"].compute(), solve_table(template, frame), check_exact=True)


def test_its_line_for_gnu_parallel(command, tmp_path):
    if shutil.which("parallel") is None:
        pytest.skip("GNU parallel is not there")
    line = re.search(r"^parallel .*$", TEXT, re.MULTILINE)[0].replace("--block 1M", "--block 200")
    program = Path(command("--version").args[0])
    (tmp_path / "scene.json").write_text(json.dumps({"effective_modulus": 1, "gap": {"kind": "sphere", "radius": 1}, "loading": {}}))
    depths = [k / 100 for k in range(1, 60)]
    (tmp_path / "scenes.csv").write_text("/loading/depth\n" + "".join(f"{depth}\n" for depth in depths))
    subprocess.run(line.replace("contact-patch", str(program), 1), shell=True, cwd=tmp_path, check=True)
    rows = [row for row in (tmp_path / "answers.csv").read_text().splitlines() if not row.startswith("/")]
    assert [float(row.split(",")[0]) for row in rows] == depths and all(row.endswith(",solved") for row in rows)
