"""Sources of an observed system: their options, and the system."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dineros.cli.console import warn
from dineros.cli.options import (
    Adds,
    collected,
    flag,
    invocation,
    path_option,
    together,
    value_option,
    values_option,
)
from dineros.cli.searching import search

if TYPE_CHECKING:
    from dineros.observation.recordings import Recording
    from dineros.observation.systems import ObservedSystem


@dataclass(frozen=True)
class Source:
    """The source of an observed system."""

    graph: bool
    """In a running graph."""
    bag: Path | None
    """In a recording of rosbag2."""
    domain: int | None
    """The ROS domain of the graph; None: that of the environment."""
    namespaces: tuple[str, ...]
    without: tuple[str, ...]
    """`namespaces`, `without`: only nodes in these namespaces; full names of nodes that are left out."""
    seconds: float
    """How long the graph is watched."""

    def _require_one(self) -> None:
        if self.graph == (self.bag is not None):
            raise click.UsageError("name one source of the system: --graph or --bag RECORDING")
        given = {"--domain": self.domain, "--namespace": self.namespaces, "--without": self.without}
        for option, value in given.items():
            if self.bag is not None and value not in (None, ()):
                raise click.UsageError(
                    f"{option} cannot be combined with --bag: a recording does not contain the names of nodes"
                )

    def system(self, doubts: Callable[[ObservedSystem], bool]) -> ObservedSystem:
        """Return the observed system of all namespaces; print how long a graph was watched.

        `doubts`: returns whether an observed graph seems to have faults; then it is watched again.

        Raises
        ------
        UsageError
            None or both of graph and recording are named, or a filter of the graph is for a recording.
        DinerosError
            ROS 2 is not there, no node or topic is, or the recording cannot be read.
        """
        self._require_one()
        if self.bag is not None:
            with opened(self.bag) as recording:
                return recording.system()
        from dineros.observation.graph.watching import watch

        search().stage(f"watching the graph for {self.seconds:g} s")
        system = watch(self.seconds, self.domain, without=self.without, doubts=doubts)
        for each in system.left_out:
            warn(f"{system.source}: left out: {each}")
        if system.watched is not None and (invocation().verbosity >= 0 or not system.watched.is_stable):
            warn(f"{system.source}: {system.watched}")
        return system


@contextmanager
def opened(bag: Path) -> Iterator[Recording]:
    """Open a recording, and warn of topics in it that cannot be read.

    Raises
    ------
    DinerosError
        The recording cannot be read.
    """
    from dineros.observation.recordings import Recording

    search().stage(f"reading {bag.name}")
    with Recording(bag) as recording:
        for each in recording.left_out:
            warn(f"{bag}: left out: {each}")
        yield recording


source_options = together(
    collected(Source, "source"),
    flag("--graph", "Observe the graph of a running ROS 2 system."),
    path_option("--bag RECORDING", "Read a recording of rosbag2: its folder, or one .mcap or .db3 file."),
    value_option(
        "--domain N",
        "The ROS domain of the graph.",
        type=click.IntRange(0, 101),
        show_default="as ROS_DOMAIN_ID says",
    ),
    values_option("--namespace /NAME", "Only the nodes in a namespace; repeatable.", into="namespaces"),
    values_option("--without /NODE", "Leave out a node, such as a recorder; repeatable."),
    value_option(
        "--watch SECONDS",
        "How long the graph is watched; extended while new parts appear.",
        into="seconds",
        type=click.FloatRange(0.0, 3600.0),
        default=3.0,
        show_default=True,
    ),
)
"""The options of a source, passed as `source`."""


def recording_options(when: str = "") -> Adds:
    """Add `--tolerance` and `--midway` for explaining a recording; `when` begins their help."""

    def said(text: str) -> str:
        return when + text if when else text.capitalize()

    return together(
        value_option(
            "--tolerance S",
            said("messages of different topics within this time may have been published in any order."),
            type=click.FloatRange(min=0, max=3600),
            default=0.001,
            show_default=True,
        ),
        flag("--midway", said("the nodes may have run before the recorder was started.")),
    )
