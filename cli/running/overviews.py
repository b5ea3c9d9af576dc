"""Listening to a running application, and showing what is heard, until Ctrl-C."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from dineros.cli.console import say_json, warn

if TYPE_CHECKING:
    from dineros.runtime.ros.overview import Overview
    from dineros.runtime.ros.process.environment import Reach

PERIOD = 0.5
"""Seconds between two pictures."""

NOBODY = 1
"""Exit status where no node was heard."""


@contextmanager
def listening(domain: int, reach: Reach) -> Iterator[Overview]:
    """Hear the nodes of a domain as long as the block lasts.

    Raises
    ------
    RosError
        ROS is not there.
    """
    from dineros.runtime.ros.overview import Listener, Overview
    from dineros.runtime.ros.process.environment import ros_environment

    overview = Overview()
    with TemporaryDirectory(prefix="dineros-top-") as folder:
        os.environ.update(ros_environment(Path(folder), domain, reach))
        with Listener(overview):
            yield overview


def show_once(domain: int, reach: Reach, seconds: float, as_json: bool) -> int:
    """Listen for some seconds, and print what was heard; return the exit status."""
    from rich.console import Console

    from dineros.cli.presentation.overviews import json_of, table_of

    with listening(domain, reach) as overview:
        time.sleep(seconds)
        if as_json:
            say_json(json_of(overview))
        elif overview.nodes():
            console = Console(highlight=False, markup=False, emoji=False)
            console.print(table_of(overview, console.width))
        else:
            warn(f"no node is heard on /diagnostics in the domain {domain}, reach {reach}")
        return 0 if overview.nodes() else NOBODY


def show_live(domain: int, reach: Reach) -> int:
    """Show what is heard until Ctrl-C."""
    from rich.console import Console
    from rich.live import Live

    from dineros.cli.presentation.overviews import table_of

    console = Console(highlight=False, markup=False, emoji=False)
    with listening(domain, reach) as overview:
        is_terminal = console.is_terminal
        with Live(
            table_of(overview, console.width), console=console, screen=is_terminal, auto_refresh=False
        ) as live:
            while True:
                time.sleep(PERIOD)
                live.update(table_of(overview, console.width), refresh=True)
