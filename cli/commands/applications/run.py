"""``dineros run``: an application, all its nodes watched and recorded."""

from __future__ import annotations

import logging
import os
import shutil
import signal
import tempfile
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dineros.cli.console import say, say_json, summarise, warn
from dineros.cli.options import command, invocation, json_option, model_argument, settings_option

if TYPE_CHECKING:
    from dineros.cli.running import watching
    from dineros.cli.running.applications import Application
    from dineros.cli.running.watching import Wanted
    from dineros.runtime.application.observer import FolderObserver

VIOLATED, FAILED, UNKNOWN, INTERRUPTED = 1, 2, 3, 130


@command(
    "dineros run sorting.sym.xmi --simulate --seed 7",
    "dineros run sorting.sym.xmi --local --until 'RedObjects == 1' --timeout 60 --trace traces --monitor",
)
@model_argument()
@click.option("--local", is_flag=True, help="Run all nodes in this process, on threads, without ROS.")
@click.option(
    "--simulate", is_flag=True, help="As --local, in simulated time: the same seed gives the same run."
)
@click.option("--seed", type=click.IntRange(0, 2**32 - 1), metavar="N", help="Seed of the firing selections.")
@click.option(
    "--handlers",
    "handler_file",
    type=click.Path(path_type=Path),
    metavar="FILE.py",
    help="The handlers; by default handlers.py beside the model, where it is there.",
)
@click.option("--until", metavar="EXPR", help="End when this holds, such as 'Shown >= 4'.")
@click.option("--trace", type=click.Path(path_type=Path), metavar="DIR", help="Keep the nodes' traces here.")
@click.option("--timeout", type=click.FloatRange(min=0), metavar="S", help="End after so many seconds.")
@click.option(
    "--watchdog",
    type=click.FloatRange(0, 86400),
    metavar="S",
    help="Name a handler that keeps its node from all else for so many seconds, by default 10; 0: never.",
)
@click.option("--resume", is_flag=True, help="Go on from the traces in DIR.")
@click.option("--monitor", is_flag=True, help="Replay the run on the model meanwhile; end at a deviation.")
@click.option("--view", is_flag=True, help="Serve a page on 127.0.0.1 that follows the run.")
@click.option(
    "--with",
    "programs",
    multiple=True,
    metavar="COMMAND",
    help="Run this program as well, in the environment of the nodes; repeatable.",
)
@click.option(
    "--restarts", type=click.IntRange(0), default=5, show_default=True, help="Restarts per minute and node."
)
@click.option(
    "--domain", type=click.IntRange(0, 101), metavar="N", help="ROS domain; by default ROS_DOMAIN_ID."
)
@click.option(
    "--reach",
    type=click.Choice(["memory", "machine", "network"]),
    default="machine",
    show_default=True,
    help="How far ROS messages go.",
)
@click.option(
    "--stale-after",
    multiple=True,
    metavar="SIGNAL=SECONDS[:THEN]",
    help="Notice when nobody sets this signal for so long; then keep its value (keep), stop its node (stop), "
    "or give it a value (true, false). Repeatable.",
)
@settings_option
@json_option
def run(
    model: Path,
    local: bool,
    simulate: bool,
    seed: int | None,
    handler_file: Path | None,
    until: str | None,
    trace: Path | None,
    timeout: float | None,
    watchdog: float | None,
    resume: bool,
    monitor: bool,
    view: bool,
    programs: tuple[str, ...],
    restarts: int,
    domain: int | None,
    reach: str,
    stale_after: tuple[str, ...],
    settings: tuple[str, ...],
    as_json: bool,
) -> int:
    """Run all nodes of a system model, or of a generated workspace, until --until, --timeout or Ctrl-C.

    Every node is a ROS 2 process of its own, unless --local or --simulate says otherwise; one that fails is
    started again and goes on from its trace. MODEL is a system model or the folder of a workspace. Exit
    status: 1 where a step was not allowed, 2 where a node could not go on, 3 where time was over before
    --until held.
    """
    from dineros.cli.running.applications import application_of
    from dineros.cli.running.watching import Wanted
    from dineros.metamodel.errors import DinerosError
    from dineros.runtime.application.ending import Ending
    from dineros.runtime.application.observer import FolderObserver

    if resume and trace is None:
        raise DinerosError("--resume needs the traces to go on from", hint="name their folder with --trace")
    if programs and (local or simulate):
        raise DinerosError("--with needs ROS", hint="let handlers.py define simulate(application) instead")
    application = application_of(model, settings, handler_file, stale_after)
    if resume and trace is not None:
        _check_traces(trace, [each.node.id for each in application.models])
    process: Ending | None = None
    with ExitStack() as stack:
        # Whoever supervises this program ends it as Ctrl-C does.
        stack.callback(
            signal.signal, signal.SIGTERM, signal.signal(signal.SIGTERM, signal.default_int_handler)
        )
        ending: watching.Ending | None = None
        folder = trace or Path(tempfile.mkdtemp(prefix="dineros-run-"))

        def forget() -> None:
            if ending != "failed":  # then people are told to look at what the node has printed
                shutil.rmtree(folder, ignore_errors=True)

        if trace is None:
            stack.callback(forget)
        wanted = Wanted(
            application.condition(until) if until is not None else None,
            timeout,
            folder,
            seed,
            watchdog,
            resume,
            application.monitor() if monitor else None,
        )
        for caught in (signal.SIGINT, signal.SIGTERM):
            stack.callback(signal.signal, caught, signal.signal(caught, wanted.interrupt))
        observer = FolderObserver(folder)
        if view:
            stack.enter_context(_page(folder, application))
        if local or simulate:
            from dineros.cli.running.local import run_in_process
            from dineros.runtime.application.logs import logs_to, terminal_handler

            level = logging.INFO if invocation().verbosity > 0 else logging.WARNING
            stack.enter_context(logs_to(terminal_handler(), level))
            with Ending(INTERRUPTED, wanted.interrupt) as process:
                try:
                    ending = run_in_process(application, wanted, observer, is_simulated=simulate)
                except KeyboardInterrupt:  # while nodes were made or started
                    ending = "interrupted"
        else:
            from dineros.cli.running.ros import RosOptions, run_on_ros

            number = domain if domain is not None else int(os.environ.get("ROS_DOMAIN_ID") or 0)
            options = RosOptions(number, reach, programs, restarts)  # type: ignore[arg-type]
            try:
                ending = run_on_ros(application, wanted, observer, options)
            except KeyboardInterrupt:
                ending = "interrupted"
        status = _report(application, wanted, observer, ending, trace, as_json)
    if process is not None:
        process.leave(status)  # a handler that does not return keeps nobody
    return status


def _check_traces(folder: Path, nodes: list[str]) -> None:
    """Refuse to go on from nothing; say which nodes begin anew.

    Raises
    ------
    DinerosError
        There are no traces, or the trace of a node has gone.
    """
    from dineros.metamodel.errors import DinerosError, Location
    from dineros.metamodel.files.reading import read_bytes
    from dineros.metamodel.records import node_traces
    from dineros.metamodel.records.files import file_name, journals_path

    known = node_traces(folder) if folder.is_dir() else {}
    if not known:
        raise DinerosError(
            "holds no traces to go on from", location=Location(folder), hint="run it without --resume"
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
                hint="restore it from a copy, or start all nodes anew in another folder",
            )
        warn(f"{folder}: node {node} has no trace, so it begins with its initial marking")


def _page(folder: Path, application: Application) -> Any:
    """Serve the live page as long as the run goes on."""
    from contextlib import contextmanager

    from dineros.views.live import serve_live

    @contextmanager
    def served() -> Any:
        folder.mkdir(parents=True, exist_ok=True)
        handle = serve_live(folder, application.system_model(), title=application.title)
        say(f"follow it at {handle.url}")
        try:
            yield
        finally:
            handle.stop()

    return served()


def _report(
    application: Application,
    wanted: Wanted,
    observer: FolderObserver,
    ending: watching.Ending,
    trace: Path | None,
    as_json: bool,
) -> int:
    status = {"timeout": UNKNOWN if wanted.until else 0, "deviated": VIOLATED, "failed": FAILED}.get(
        ending, 0
    )
    if wanted.until is not None and ending in ("ended", "idle"):
        status = VIOLATED
    if ending == "interrupted" and wanted.until is not None:
        status = INTERRUPTED
    verdict = None
    if wanted.monitor is not None and ending != "deviated":
        verdict = wanted.monitor.finish()
        for deviation in verdict.violations:
            warn(f"{deviation.location}: {deviation}")
        if verdict.status == "violated" and status != FAILED:
            status = VIOLATED
    if as_json:
        say_json(
            {
                "model": str(application.source),
                "ending": ending,
                "firings": observer.firings,
                "drops": observer.drops,
                "errors": observer.errors,
                "restarts": observer.restarts,
                "marking": {place: tokens for place, tokens in sorted(observer.marking.items()) if tokens},
                "signals": dict(sorted(observer.signals.items())),
                "conformance": verdict.status if verdict is not None else None,
                "traces": str(trace) if trace is not None else None,
            }
        )
        return status
    marked = [f"{place} {tokens}" for place, tokens in sorted(observer.marking.items()) if tokens]
    say(f"{_ENDINGS[ending]}; marked: {', '.join(marked) or 'nothing'}")
    if verdict is not None:
        say(f"conformance: {verdict.status}, {verdict.steps} steps replayed")
    counts = {"firings": observer.firings, "drops": observer.drops, "errors": observer.errors}
    told = ", ".join(f"{number} {noun}" for noun, number in counts.items())
    kept = f"; traces in {trace}" if trace is not None else ""
    summarise(f"{application.title}: {told}, {observer.restarts} restarts{kept}")
    return status


_ENDINGS: dict[str, str] = {
    "reached": "the condition holds",
    "ended": "all nodes have ended",
    "idle": "nothing is left to do",
    "timeout": "time is over",
    "interrupted": "interrupted",
    "failed": "a node could not go on",
    "deviated": "a step is not allowed by the model",
}
