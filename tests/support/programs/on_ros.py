"""What tests need whose nodes are processes on ROS 2."""

from __future__ import annotations

import fcntl
import os
import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partialmethod
from pathlib import Path

import pytest

from benchmarks.endurance.applications import Application
from dineros.generators.workspace.building import build_interfaces, manifest_of, missing_tools
from dineros.runtime.ros.process.domains import claimed_domain

CACHE = Path(__file__).resolve().parents[3] / "build/tests/cache"


def require_tools() -> None:
    """Skip the test where interfaces cannot be built; with CI set, fail."""
    if missing_tools():
        if os.environ.get("CI"):
            pytest.fail(f"CI is set: {missing_tools()} must be there")
        pytest.skip(f"without {', '.join(missing_tools())}")


@contextmanager
def on_ros() -> Iterator[int]:
    """Let processes run in a domain of this test, with interfaces that other tests may have built.

    Interfaces of the same content are built once, also those of the applications that benchmarks stop, kill
    and flood. Tests run side by side, so models of the same id must have the same interfaces.
    """
    require_tools()
    CACHE.mkdir(parents=True, exist_ok=True)
    with claimed_domain() as domain, pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(CACHE))
        patch.setenv("ROS_DOMAIN_ID", str(domain))
        patch.setattr(Application, "workspace", partialmethod(_workspace_as_before, Application.workspace))
        yield domain


def _workspace_as_before(
    application: Application,
    generate: Callable[[Application, Path, Sequence[str]], None],
    folder: Path,
    settings: Sequence[str],
) -> None:
    generate(application, folder, settings)
    build_as_before(folder)


def build_as_before(workspace: Path) -> None:
    """Build the interfaces of a workspace, unless an earlier test built the same; within `on_ros`.

    One test at a time builds. The stamp of the build is a part of what is kept, so `build_interfaces` itself
    notices that nothing changed.
    """
    package = manifest_of(workspace).interfaces
    kept, installed = CACHE / "interfaces" / package, workspace / "install" / package
    with _alone():
        if kept.is_dir() and not installed.exists():
            shutil.copytree(kept, installed, symlinks=True)
        build_interfaces(workspace)
        _keep(installed, kept)


def keep_for_others(workspace: Path) -> None:
    """Let other tests have the interfaces that were built in a workspace."""
    package = manifest_of(workspace).interfaces
    with _alone():
        _keep(workspace / "install" / package, CACHE / "interfaces" / package)


@contextmanager
def _alone() -> Iterator[None]:
    """Be the only test that builds interfaces, in all test processes."""
    CACHE.mkdir(parents=True, exist_ok=True)
    with (CACHE / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _keep(installed: Path, kept: Path) -> None:
    shutil.rmtree(kept, ignore_errors=True)
    shutil.copytree(installed, kept, symlinks=True)
