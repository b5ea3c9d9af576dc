"""Prints a running application for `dineros top`: a table of its nodes, and waits."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from dineros.cli.console import say_json, warn
from dineros.runtime.ros.overview import NodeView, Overview, Waiting, circle_of, waits_of

if TYPE_CHECKING:
    from rich.console import Group

    from dineros.runtime.ros.process.environment import Reach

PERIOD = 0.5
"""Seconds between two updates."""

NOBODY = 1
"""Exit status if no node was found."""

STYLES = {0: "green", 1: "yellow", 2: "bold red"}
SILENT = 5.0
"""Seconds without a report after which a node counts as silent."""

HEADINGS = (
    "node",
    "state",
    "per s",
    "firings",
    "failed",
    "restarts",
    "lost",
    "fullest queue",
    "slowest callback",
    "tokens",
)
ROOMY, WIDE = 100, 130
"""Least columns of a terminal for the slowest callback, and also for the tokens."""

SHOWN_WAITS = 20
WORDS = {
    "service": "the response of {on}",
    "action": "a goal of {on}",
    "handler": "its handler {on}",
    "room": "room on {on}",
    "proceed": "a command to continue: {on}",
}


def table_of(overview: Overview, width: int) -> Group:
    """Return the current state for a terminal of a given width; a narrow one shows fewer columns."""
    from rich.console import Group
    from rich.table import Table
    from rich.text import Text

    nodes = overview.nodes()
    table = Table(box=None, pad_edge=False, header_style="bold")
    shown = len(HEADINGS) - (width < ROOMY) - (width < WIDE)
    for heading in HEADINGS[:shown]:
        is_text = heading in ("node", "state", "fullest queue", "slowest callback", "tokens")
        table.add_column(heading, justify="left" if is_text else "right", no_wrap=True)
    for view in nodes:
        seconds = overview.silent(view)
        state = f"silent {seconds:.0f} s" if seconds > SILENT else view.state
        style = "dim" if seconds > SILENT else STYLES[view.level]
        row = [
            Text(view.name),
            Text(state, style=style),
            Text(f"{view.count('firings per second'):.1f}"),
            *(Text(f"{view.count(name):.0f}") for name in ("firings", "failures", "restarts")),
            Text(str(view.lost)),
            Text(*_fill(view)),
            Text(*_slowest(view)),
            Text(" ".join(f"{place} {count}" for place, count in view.tokens.items())),
        ]
        table.add_row(*row[: len(table.columns)])
    lines = [Text(text, style=style) for text, style in notes_of(nodes)]
    return Group(table, *lines) if nodes else Group(Text("no node has sent a report on /diagnostics yet"))


def _fill(view: NodeView) -> tuple[str, str]:
    fullest = view.fullest
    if fullest is None:
        return "", ""
    waiting, capacity, place = fullest
    return f"{waiting}/{capacity} {place}", STYLES[1] if "queues" in view.said else ""


def _slowest(view: NodeView) -> tuple[str, str]:
    slowest = view.slowest
    if slowest is None:
        return "", ""
    seconds, callback = slowest
    return f"{seconds * 1e3:.3g} ms {callback}", STYLES[1] if "callbacks" in view.said else ""


def notes_of(nodes: list[NodeView]) -> list[tuple[str, str]]:
    """Return the lines below the table, each with its style: concerns and waits."""
    lines = [
        (f"{view.name}: {text}", STYLES[min(2, max(1, view.level))])
        for view in nodes
        for text in view.said.values()
    ]
    waits = waits_of(nodes)
    if circle := circle_of(waits):
        lines.append((f"wait for each other: {', '.join(circle)}", STYLES[2]))
    told = [(name, wait) for name, found in waits.items() for wait in found if wait.kind != "proceed"]
    told.sort(key=lambda each: -each[1].seconds)
    lines += [(f"{name}: {_words(wait)}", "") for name, wait in told[:SHOWN_WAITS]]
    if len(told) > SHOWN_WAITS:
        lines.append((f"and {len(told) - SHOWN_WAITS} more that wait", "dim"))
    return lines


def _words(wait: Waiting) -> str:
    what = WORDS[wait.kind].format(on=wait.on)
    whose = f", which {wait.node} serves" if wait.node else ""
    return f"{wait.element} waits for {what}{whose}{f', {wait.seconds:.1f} s' if wait.seconds else ''}"


def json_of(overview: Overview) -> dict[str, Any]:
    """Return the current state as JSON values."""
    nodes = overview.nodes()
    waits = waits_of(nodes)
    return {
        "nodes": [
            {
                "name": view.name,
                "application": view.application,
                "level": ("ok", "warning", "error")[view.level],
                "silent": round(overview.silent(view), 1),
                "concerns": view.said,
                "waits": [vars(wait) for wait in waits.get(view.name, ())],
                **view.parts,
            }
            for view in nodes
        ],
        "circle": circle_of(waits),
    }


@contextmanager
def listening(domain: int, reach: Reach) -> Iterator[Overview]:
    """Listen to the nodes of a domain during the block.

    Raises
    ------
    RosError
        ROS is not installed.
    """
    from dineros.runtime.ros.overview import DiagnosticsListener
    from dineros.runtime.ros.process.environment import ros_environment

    overview = Overview()
    with TemporaryDirectory(prefix="dineros-top-") as folder:
        os.environ.update(ros_environment(Path(folder), domain, reach))
        with DiagnosticsListener(overview):
            yield overview


def show_once(domain: int, reach: Reach, seconds: float, as_json: bool) -> int:
    """Listen for some seconds, and print the result; return the exit status."""
    from rich.console import Console

    with listening(domain, reach) as overview:
        time.sleep(seconds)
        if as_json:
            say_json(json_of(overview))
        elif overview.nodes():
            console = Console(highlight=False, markup=False, emoji=False)
            console.print(table_of(overview, console.width))
        else:
            warn(f"no node reports on /diagnostics in the domain {domain}, reach {reach}")
        return 0 if overview.nodes() else NOBODY


def show_live(domain: int, reach: Reach) -> int:
    """Show the current state until Ctrl-C."""
    from rich.console import Console
    from rich.live import Live

    console = Console(highlight=False, markup=False, emoji=False)
    with listening(domain, reach) as overview:
        is_terminal = console.is_terminal
        with Live(
            table_of(overview, console.width), console=console, screen=is_terminal, auto_refresh=False
        ) as live:
            while True:
                time.sleep(PERIOD)
                live.update(table_of(overview, console.width), refresh=True)
