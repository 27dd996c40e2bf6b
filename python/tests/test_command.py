"""The command that the wheel installs."""

import json
import subprocess
import sys

import pytest

import contact_patch


def test_it_is_the_program(command, scenes):
    run = command("solve", scenes / "cone.json", "--json", "-")
    assert run.returncode == 0
    mine = contact_patch.solve(scenes / "cone.json")
    assert json.loads(run.stdout)["force"] == mine.force
    assert command("--version").stdout.split()[1] == contact_patch.__version__


def test_exit_codes_and_messages(command, tmp_path):
    assert command("solve", tmp_path / "none.json").returncode == 2
    assert command("no-such-command").returncode == 2
    scene = '{"effective_modulus": 1, "gap": {"kind": "paraboloid", "radii": [1, "flat"]}, "loading": {"depth": 1}}'
    assert command("solve", "-", input=scene).returncode == 1
    assert command("solve", "-", input="{").returncode == 2


def test_it_runs_as_a_module(scenes):
    run = subprocess.run([sys.executable, "-m", "contact_patch", "plan", scenes / "cone.json"], capture_output=True, text=True)
    assert run.returncode == 0 and "closed_form" in run.stdout


@pytest.mark.skipif(sys.platform == "win32", reason="a shell of POSIX")
def test_a_closed_pipe_is_no_fault(scenes):
    line = '{"effective_modulus": 1, "gap": {"kind": "cone", "inclination": 45}, "loading": {"depth": 1}}\n'
    run = subprocess.run(
        f"{sys.executable} -m contact_patch batch | head -n 1", shell=True, input=line * 3000, capture_output=True, text=True
    )
    assert json.loads(run.stdout)["verdict"] == "solved" and "Traceback" not in run.stderr
