"""Hypothesis profiles: CI draws the same examples in every run; no test fails because a machine is slow."""

import os
from collections.abc import Iterator

import pytest
from hypothesis import settings

from dineros.cli.analysing import QUIET_COMPILATION
from dineros.runtime.ros.domains import claimed_domain

settings.register_profile("ci", deadline=None, derandomize=True, print_blob=True)
settings.register_profile("dev", deadline=None)
settings.load_profile("ci" if os.environ.get("CI") else "dev")

# What commands print on stderr must not depend on which test is the first one after an installation.
os.environ[QUIET_COMPILATION] = "1"


@pytest.fixture
def ros_domain() -> Iterator[int]:
    """Return a ROS domain that no other run on this machine has, of these tests or of others."""
    with claimed_domain() as domain:
        yield domain
