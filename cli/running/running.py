"""Runs an application: signals, the folder of the traces, the live page, and the result."""

from __future__ import annotations

import logging
import os
import shutil
import signal
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.console import say, warn
from dineros.cli.options import invocation
from dineros.cli.running import watching
from dineros.cli.running.watching import Options, Wanted
from dineros.runtime.application.ending import Ending
from dineros.runtime.application.observer import FolderObserver

if TYPE_CHECKING:
    from dineros.analysis.conformance import Verdict
    from dineros.cli.running.applications import Application
    from dineros.views.live import Steering

VIOLATED, FAILED, UNKNOWN, INTERRUPTED = 1, 2, 3, 130


@dataclass(frozen=True)
class Outcome:
    """The result of a run.

    Attributes
    ----------
    verdict : Verdict or None
        Of the monitor, if it saw the whole run.
    """

    application: Application
    options: Options
    ending: watching.Ending
    observer: FolderObserver
    verdict: Verdict | None

    @property
    def missing(self) -> list[str]:
        """Ids of the nodes that did not come up; empty if the run was interrupted before any did."""
        started = self.observer.came_up
        if self.ending == "interrupted" and not started:
            return []
        return [id for model in self.application.models if (id := str(model.node.id)) not in started]

    @property
    def status(self) -> int:
        """The exit status: that of the ending, unless a node was missing or halted by a failure."""
        if self.missing:
            return FAILED
        status = self._status_of_ending
        return VIOLATED if status == 0 and self.observer.halted else status

    @property
    def _status_of_ending(self) -> int:
        ending, waits = self.ending, self.options.until is not None
        status = {"timeout": UNKNOWN if waits else 0, "deviated": VIOLATED, "failed": FAILED}.get(ending, 0)
        if waits and ending in ("ended", "idle"):
            status = VIOLATED
        if waits and ending == "interrupted":
            status = INTERRUPTED
        if self.verdict is not None and self.verdict.status == "violated" and status != FAILED:
            status = VIOLATED
        return status


def run_application(application: Application, options: Options, tell: Callable[[Outcome], None]) -> int:
    """Run all nodes until the run ends.

    `tell`: gets the result while the traces still exist.

    Returns
    -------
    int
        The exit status.

    Raises
    ------
    DinerosError
        There are no traces to continue from, or the application cannot run.
    """
    if options.is_resumed and options.trace is not None:
        _check_traces(options.trace, [each.node.id for each in application.models])
    process: Ending | None = None
    with ExitStack() as stack:
        # A supervisor of this program ends it as Ctrl-C does.
        stack.callback(
            signal.signal, signal.SIGTERM, signal.signal(signal.SIGTERM, signal.default_int_handler)
        )
        ending: watching.Ending | None = None
        folder = options.trace or Path(tempfile.mkdtemp(prefix="dineros-run-"))

        def forget() -> None:
            if ending != "failed":  # then a message names the file with the output of the node
                shutil.rmtree(folder, ignore_errors=True)

        if options.trace is None:
            stack.callback(forget)
        until = application.condition(options.until) if options.until is not None else None
        wanted = Wanted(until, folder, application.monitor() if options.is_monitored else None, options)
        for caught in (signal.SIGINT, signal.SIGTERM):
            stack.callback(signal.signal, caught, signal.signal(caught, wanted.interrupt))
        observer = FolderObserver(folder)
        steering = None
        if options.is_shown:
            steering = stack.enter_context(_page(folder, application))
        if options.ros is None:
            from dineros.cli.running.local import run_in_process
            from dineros.runtime.application.logs import logs_to, terminal_handler

            level = logging.INFO if invocation().verbosity > 0 else logging.WARNING
            stack.enter_context(logs_to(terminal_handler(), level))
            with Ending(INTERRUPTED, wanted.interrupt) as process:
                try:
                    ending = run_in_process(application, wanted, observer, steering)
                except KeyboardInterrupt:  # while nodes were made or started
                    ending = "interrupted"
        else:
            from dineros.cli.running.ros import run_on_ros

            try:
                ending = run_on_ros(application, wanted, observer, options.ros, steering)
            except KeyboardInterrupt:
                ending = "interrupted"
        finished = ending != "deviated"
        verdict = wanted.monitor.finish() if wanted.monitor is not None and finished else None
        for deviation in verdict.violations if verdict is not None else ():
            warn(f"{deviation.location}: {deviation}")
        outcome = Outcome(application, options, ending, observer, verdict)
        tell(outcome)
    if process is not None:
        process.leave(outcome.status)  # a handler that does not return delays no other
    return outcome.status


def domain_of(given: int | None) -> int:
    """Return the ROS domain: the one given, or that of the environment."""
    return given if given is not None else int(os.environ.get("ROS_DOMAIN_ID") or 0)


def _check_traces(folder: Path, nodes: list[str]) -> None:
    """Reject continuing without traces; print which nodes start again.

    A run that ended before any node had recorded something can be continued: all of them begin.

    Raises
    ------
    DinerosError
        There was no run, or the trace of a node is missing.
    """
    from dineros.cli.running.ros import SUPERVISOR_LOG
    from dineros.metamodel.errors import DinerosError, Location
    from dineros.metamodel.files.reading import read_bytes
    from dineros.metamodel.records import node_traces
    from dineros.metamodel.records.files import file_name, journals_path

    known = node_traces(folder) if folder.is_dir() else {}
    if not known and not (folder / SUPERVISOR_LOG).is_file():
        raise DinerosError(
            "holds no traces to continue from", location=Location(folder), hint="run without --resume"
        )
    journals = journals_path(folder)
    listed = read_bytes(journals).decode(errors="replace").split("\n") if journals.is_file() else []
    for node in nodes:
        if node in known:
            continue
        if file_name(node) in listed:
            raise DinerosError(
                f"the trace of node {node} is missing",
                location=Location(folder),
                hint="restore it from a copy, or start all nodes again in another folder",
            )
        warn(f"{folder}: node {node} has no trace, so it begins with its initial marking")


@contextmanager
def _page(folder: Path, application: Application) -> Iterator[Steering]:
    """Serve the live page, which controls the run, during the run."""
    from dineros.views.live import Steering, serve_live

    folder.mkdir(parents=True, exist_ok=True)
    steering = Steering()
    handle = serve_live(folder, application.system_model(), title=application.title, steering=steering)
    say(f"follow it at {handle.url}")
    try:
        yield steering
    finally:
        handle.stop()
