"""What tests need whose nodes are processes on ROS 2."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from dineros.generators.workspace.building import missing_tools
from dineros.runtime.ros.process.domains import claimed_domain

CACHE = Path(__file__).resolve().parents[2] / "build/tests/cache"


def require_tools() -> None:
    """Skip the test where interfaces cannot be built; with CI set, fail."""
    if missing_tools():
        if os.environ.get("CI"):
            pytest.fail(f"CI is set: {missing_tools()} must be there")
        pytest.skip(f"without {', '.join(missing_tools())}")


@contextmanager
def on_ros() -> Iterator[int]:
    """Let processes run in a domain of this test, with interfaces that other tests may have built.

    One test at a time builds interfaces: those of the same content are built once.
    """
    require_tools()
    CACHE.mkdir(parents=True, exist_ok=True)
    with (
        (CACHE / "lock").open("w") as lock,
        claimed_domain() as domain,
        pytest.MonkeyPatch.context() as patch,
    ):
        fcntl.flock(lock, fcntl.LOCK_EX)
        patch.setenv("XDG_CACHE_HOME", str(CACHE))
        patch.setenv("ROS_DOMAIN_ID", str(domain))
        yield domain
