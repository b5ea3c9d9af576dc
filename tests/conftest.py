"""Hypothesis profiles: CI draws the same examples in every run; no test fails because a machine is slow.

``DINEROS_EXAMPLES=10`` draws ten times as many examples in every test.
"""

import gc
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import is_hypothesis_test, settings

from dineros.cli.coding import CACHE
from dineros.cli.searching import FOLLOW_AFTER, QUIET_COMPILATION
from tests.support.programs.warm_commands import served
from tests.views.browser import chromium

if TYPE_CHECKING:
    from playwright.sync_api import Browser

WORKSPACE = Path(__file__).resolve().parents[1] / "case_study/workspace"


USUAL_THRESHOLDS = gc.get_threshold()
gc.disable()  # until all tests are collected: none of that is garbage, and there is much to look through


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop() -> None:
    """Take what is collected out of what the garbage collector looks through, and let it work.

    Counting what is frozen walks through all of it: 70 ms for each model that a test reads or flattens.
    """
    gc.freeze()
    gc.get_freeze_count = lambda: 1
    gc.enable()


def pytest_configure(config: pytest.Config) -> None:
    """Generate the workspace of the case study where nobody ran `make`; once, not in each process.

    No test loses power, so writes of the test process need not reach the disk: while other processes build
    applications, each call of `fsync` can wait for all that they write. Tests of `fsync` replace it.
    """
    os.fsync = lambda fd: None
    if not hasattr(config, "workerinput") and not (WORKSPACE / "src/sorting_interfaces").is_dir():
        from case_study.generate import main

        assert main() == 0


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Let modules with long tests come first; multiply the examples that tests draw, where that is asked for.

    Tests are handed out in this order: with quick ones at the end, all processes end at about the same time.
    """
    with_long = {item.path for item in items if item.get_closest_marker("long")}
    items.sort(key=lambda item: item.path not in with_long)
    times = int(os.environ.get("DINEROS_EXAMPLES", "1"))
    tests = {item.function for item in items if isinstance(item, pytest.Function)} if times > 1 else set()
    for test in filter(is_hypothesis_test, tests):
        own = (
            test._hypothesis_internal_use_settings
        )  # where Hypothesis's own plugin for pytest sets them, too
        test._hypothesis_internal_use_settings = settings(own, max_examples=own.max_examples * times)


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown() -> None:
    """Collect garbage as often as before: a command that runs in this process makes that rare, for itself."""
    gc.set_threshold(*USUAL_THRESHOLDS)


@pytest.fixture(scope="session")
def warm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Serve quick commands at a socket; `tests.support.programs.warm_commands.program` is one of them."""
    with served(tmp_path_factory.mktemp("warm") / "socket") as place:
        yield place


@pytest.fixture(scope="module")
def own_time() -> Iterator[None]:
    """Let budgets count the time of this process, so that a busy machine decides nothing."""
    from tests.support.own_time import of_budgets

    with of_budgets():
        yield


@pytest.fixture(scope="session")
def browser() -> Iterator["Browser"]:
    """Return a browser that all tests of a worker share: there can be only one in a process."""
    with chromium() as started:
        yield started


settings.register_profile("ci", max_examples=40, deadline=None, derandomize=True, print_blob=True)
settings.register_profile("dev", max_examples=40, deadline=None)
settings.load_profile("ci" if os.environ.get("CI") else "dev")

# What commands print on stderr must not depend on which test is the first one after an installation.
os.environ[QUIET_COMPILATION] = "1"
os.environ[FOLLOW_AFTER] = "9999"
os.environ[CACHE] = ""
