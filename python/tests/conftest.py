"""What several tests share."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def scenes() -> Path:
    return REPOSITORY / "data" / "scenes"


@pytest.fixture
def command():
    """Runs the command that the wheel installs."""
    program = Path(sys.executable).with_name("contact-patch")

    def run(*arguments, **options):
        return subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, timeout=120, **options)

    return run
