"""What several tests share."""

from __future__ import annotations

import shutil
import subprocess
import sysconfig
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def scenes() -> Path:
    return REPOSITORY / "data" / "scenes"


@pytest.fixture
def command():
    """Runs the command that the wheel installs."""
    program = shutil.which("contact-patch", path=sysconfig.get_path("scripts"))
    assert program, "the command is not installed"

    def run(*arguments, **options):
        return subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, timeout=120, **options)

    return run
