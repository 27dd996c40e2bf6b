"""One call for every scene: what comes back, what is refused, how it ends."""

import json
import math
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import contact_patch
from contact_patch import Contact, SceneError, Unsolved, gap

STEEL = [{"youngs_modulus": 2.1e11, "poissons_ratio": 0.3}, "rigid"]
CONE = {"effective_modulus": 1.0, "gap": {"kind": "cone", "inclination": 45.0}, "loading": {"depth": 1.0}}


def without_time(result):
    """A result without what differs from run to run."""
    return {key: value for key, value in result.items() if key != "cost"}


def test_the_force_of_the_paper_lies_in_its_bracket():
    solution = Contact(gap.Pyramid(faces=3, inclination=45.0), bodies=STEEL, depth=1e-6).solve()
    group = solution.force / (2.1e11 / (1 - 0.3**2) * 1e-12)
    assert solution.solved and solution.evidence == "proved"
    assert solution.bracket.lower <= solution.force <= solution.bracket.upper
    assert abs(group / (1.764824 / 2) - 1) <= solution.force_error <= 1e-3


@pytest.mark.parametrize(
    "name",
    ["tetrahedral_punch", "crossed_cylinders", "depth_list", "force_list", "force_off_centre", "height_map_pair", "tilted_square"],
)
def test_a_file_answers_as_the_command_does(scenes, command, tmp_path, name):
    path = scenes / f"{name}.json"
    out = tmp_path / "result.json"
    assert command("solve", path, "--threads", "1", "-o", out).returncode in (0, 1)
    mine = contact_patch.solve(path).to_dict()
    assert without_time(mine) == without_time(json.loads(out.read_text()))


def test_a_scene_is_the_same_as_dict_text_bytes_and_contact():
    text = json.dumps(CONE)
    first = contact_patch.solve(CONE)
    for scene in (text, " \n" + text, text.encode(), Contact(gap.Cone(45.0), modulus=1.0, depth=1.0)):
        other = contact_patch.solve(scene)
        assert without_time(other.to_dict())["force"] == first.force == pytest.approx(2 / math.pi, rel=1e-12)
    assert contact_patch.solve({**CONE, "loading": {"depth": np.float32(1.0)}}).force == first.force
    assert contact_patch.solve({**CONE, "loading": {"depths": np.array([1.0, 2.0])}}).force[0] == first.force


@pytest.mark.parametrize(
    ("scene", "path"),
    [
        ({**CONE, "gap": {"kind": "cone", "incline": 45.0}}, "gap.incline"),
        ({**CONE, "loading": {"depth": math.nan}}, "loading.depth"),
        ({**CONE, "loading": {"depths": [1.0, math.inf]}}, "loading.depths[1]"),
        ({**CONE, "solve": {"tolerance": 2.0}}, "solve.tolerance"),
        ({"gap": CONE["gap"], "loading": CONE["loading"]}, "bodies"),
        ({**CONE, "gap": {"kind": "given", "name": "nobody's"}}, "gap.kind"),
        ({**CONE, "gap": {"kind": "sum", "of": [{"kind": "cone", "inclination": 1.0}, object()]}}, "gap.of[1]"),
        ("{", "$"),
        ("no such file.json", "$"),
        (3, "$"),
    ],
)
def test_what_is_wrong_is_named_by_its_path(scene, path):
    with pytest.raises(ValueError) as caught:
        contact_patch.solve(scene)
    error = caught.value
    assert isinstance(error, SceneError) and error.path == path
    assert error.path in str(error) and error.allowed in str(error)
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


@pytest.mark.skipif(sys.platform == "win32", reason="pipes of POSIX")
def test_only_regular_files_are_read(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with open(tmp_path / "long", "wb") as file:
        file.truncate((1 << 26) + 1)
    for name, told in (("pipe", "regular"), (".", "regular"), ("long", "67108865 bytes"), ("none", "No such file"), ("a\0b", "null")):
        with pytest.raises(SceneError, match=told):
            contact_patch.solve(tmp_path / name)


def test_a_state_that_is_not_solved_is_an_answer_or_raises_on_request():
    contact = Contact(gap.Paraboloid(1.0, 2.0), modulus=1.0, depth=1.0, method="fft", cells=16, tolerance=1e-6)
    solution = contact.solve()
    assert solution.verdict == "tolerance_not_reached" and not solution.solved and solution.force > 0
    assert solution.force_error > 1e-6 and "tolerance" in solution.reason
    with pytest.raises(Unsolved) as caught:
        contact.solve(check=True)
    assert caught.value.verdict == "tolerance_not_reached" and caught.value.solution.force == solution.force
    cylinder = Contact(gap.Paraboloid(1.0, math.inf), modulus=1.0, depth=1.0).solve()
    assert cylinder.verdict == "unbounded"
    with pytest.raises(AttributeError, match="verdict"):
        _ = cylinder.force


def test_lists_of_states_are_arrays_and_sequences():
    depths = [0.5, 1.0, 2.0]
    solution = Contact(gap.Paraboloid(1.0), modulus=1.0, depth=depths, outputs=["pressure"]).solve()
    assert isinstance(solution.force, np.ndarray) and solution.force.shape == (3,)
    assert np.allclose(solution.force, 4 / 3 * np.array(depths) ** 1.5, rtol=1e-12)
    assert len(solution) == 3 and [state.depth for state in solution] == depths
    assert solution[-1].pressure.values.max() > solution[0].pressure.values.max() > 0
    with pytest.raises(IndexError):
        solution[3]
    with pytest.raises(ValueError, match="3 states"):
        solution.to_vti()
    assert solution[1] == pickle.loads(pickle.dumps(solution))[1]


def test_some_states_of_several_may_be_without_an_answer():
    solution = Contact(gap.Flat(disc=1.0), modulus=1.0, force=1.0, through=[2.0, 0.0]).solve()
    assert solution.verdict == "no_equilibrium" and len(solution) == 1
    mixed = Contact(gap.Paraboloid(1.0, 2.0), modulus=1.0, depth=[-1.0, 1.0], method="fft", cells=16, tolerance=1e-6).solve()
    assert [state.verdict for state in mixed] == ["solved", "tolerance_not_reached"]
    assert mixed[1].reason and not mixed[1].solved and mixed[0].solved


def test_fields_lie_where_the_patch_does():
    solution = Contact(
        gap.Paraboloid(1.0).placed(at=[3.0, -1.0]), modulus=1.0, depth=0.01, outputs=["pressure", "patch", "gap"], method="fft"
    ).solve()
    pressure = solution.pressure
    j, i = np.unravel_index(pressure.values.argmax(), pressure.values.shape)
    assert abs(pressure.x[i] - 3.0) < 0.02 and abs(pressure.y[j] + 1.0) < 0.02
    left, right, bottom, top = pressure.extent
    assert left < 3.0 < right and bottom < -1.0 < top
    cell = (right - left) * (top - bottom) / pressure.values.size
    assert pressure.values.sum() * cell == pytest.approx(solution.force, rel=1e-3)
    line = solution.patch.boundary[0]
    assert np.hypot(line[:, 0] - 3.0, line[:, 1] + 1.0) == pytest.approx(0.1, rel=0.05)
    assert solution.gap.values[pressure.values > 0] == pytest.approx(0.0, abs=1e-6)
    with pytest.raises(AttributeError, match="outputs"):
        _ = Contact(gap.Cone(1.0), modulus=1.0, depth=1.0).solve().pressure.values


def test_an_answer_survives_the_pickle_and_shows_itself():
    contact = Contact(gap.Pyramid(4, 20.0), modulus=1.0, depth=1.0, name="<four faces>", outputs=["pressure", "patch"])
    solution = contact.solve()
    again = pickle.loads(pickle.dumps(solution))
    assert again == solution and again.to_vti() == solution.to_vti() and again.to_json() == solution.to_json()
    page = solution._repr_html_()
    assert "&lt;four faces&gt;" in page and "<four" not in page.replace("<four", "", 0).split("<svg")[0]
    assert "<svg" in page and "force at least" in page
    assert f"{solution.force:.6g}" in repr(solution) and "force" in dir(solution)


def test_change_of_units_changes_numbers_by_their_dimension():
    # Lengths in millimetres, forces in newtons: E* in N/mm^2.
    metres = Contact(gap.Pyramid(3, 30.0), modulus=2e11, depth=1e-6).solve()
    millimetres = Contact(gap.Pyramid(3, 30.0), modulus=2e5, depth=1e-3).solve()
    assert millimetres.force == pytest.approx(metres.force, rel=1e-9)
    assert millimetres.patch.area == pytest.approx(metres.patch.area * 1e6, rel=1e-9)


LONG = "Contact(gap.Formula('x^2/2 + y^2/3 + 0.01*abs(x)^3'), modulus=1.0, depth=1.0, method='fft', cells=4096, tolerance=1e-9, seconds=0)"


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize(
    "work",
    [
        f"{LONG}.solve()",
        "solve_table(Contact(gap.Pyramid(3, 45.0), modulus=1.0, depth=1.0, method='qp', cells=40),"
        " {'/loading/depth': np.linspace(1, 2, 10**5)}, threads=2)",
    ],
)
def test_control_c_ends_a_long_solve(work):
    program = (
        "import signal, sys\nimport numpy as np\nfrom contact_patch import Contact, gap, solve_table\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\nprint('now', flush=True)\n"
        f"try:\n    {work}\nexcept KeyboardInterrupt:\n    sys.exit(7)\n"
    )
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "now\n"
    time.sleep(1.0)
    assert child.poll() is None, "it was over before it could be interrupted"
    child.send_signal(signal.SIGINT)
    assert child.wait(timeout=60) == 7


def test_other_threads_of_python_run_meanwhile():
    counted, stop = [0], threading.Event()

    def count():
        while not stop.is_set():
            counted[0] += 1

    thread = threading.Thread(target=count)
    thread.start()
    before = counted[0]
    Contact(gap.Pyramid(3, 45.0), modulus=1.0, depth=1.0, method="fft", cells=512).solve()
    after = counted[0]
    stop.set()
    thread.join()
    assert after > before


def test_threads_of_python_solve_side_by_side():
    alone = [Contact(gap.Cone(45.0), modulus=1.0, depth=float(d)).solve().force for d in range(1, 20)]
    found = {}
    work = lambda d: found.__setitem__(d, Contact(gap.Cone(45.0), modulus=1.0, depth=float(d)).solve().force)  # noqa: E731
    threads = [threading.Thread(target=work, args=(d,)) for d in range(1, 20)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [found[d] for d in range(1, 20)] == alone


def test_plan_and_schema():
    plan = contact_patch.plan(CONE)
    assert plan["method"] == "closed_form" and plan["left_out"]
    with pytest.raises(Unsolved, match="unbounded"):
        contact_patch.plan(Contact(gap.Paraboloid(1.0, math.inf), modulus=1.0, depth=1.0))
    assert "gap" in contact_patch.schema()["properties"]
    with pytest.raises(SceneError, match="threads"):
        contact_patch.solve(CONE, threads=0)
