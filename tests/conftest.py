"""Hypothesis profiles: CI draws the same examples in every run; no test fails because a machine is slow."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

from dineros.cli.searching import QUIET_COMPILATION

WORKSPACE = Path(__file__).resolve().parents[1] / "case_study/workspace"


def pytest_configure(config: pytest.Config) -> None:
    """Generate the workspace of the case study where nobody ran `make`; once, not in each process."""
    if not hasattr(config, "workerinput") and not (WORKSPACE / "src/sorting_interfaces").is_dir():
        from case_study.generate import main

        assert main() == 0


settings.register_profile("ci", deadline=None, derandomize=True, print_blob=True)
settings.register_profile("dev", deadline=None)
settings.load_profile("ci" if os.environ.get("CI") else "dev")

# What commands print on stderr must not depend on which test is the first one after an installation.
os.environ[QUIET_COMPILATION] = "1"
