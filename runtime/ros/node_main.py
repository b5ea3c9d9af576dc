"""The process of one node on ROS 2, started by generated packages and by `dineros run`.

``python -m dineros.runtime.ros.node_main NODE.rtm.xmi [--handlers FILE_OR_MODULE] [--lifecycle] [--ros-args
...]``

The exit status is 0 if the process was stopped (SIGINT, SIGTERM), 1 if its node failed, and 2 if it cannot
start. After a signal, it ends within five seconds, even if a handler does not return.
"""

from __future__ import annotations

import argparse
import functools
import importlib
import itertools
import logging
import sys
import threading
import traceback
import uuid
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from dineros.metamodel import rtm, sym
from dineros.metamodel.elements import label
from dineros.metamodel.errors import DinerosError, Location
from dineros.runtime.application.ending import Ending
from dineros.runtime.application.gate import Gate, inherited_gate
from dineros.runtime.application.handler_files import HandlerFile, HandlerFileError, load_handler_file
from dineros.runtime.application.line import Line, inherited_line
from dineros.runtime.application.logs import FORMAT
from dineros.runtime.application.steered import steered_over
from dineros.runtime.journal import JournalRecorder, resume_journal
from dineros.runtime.journal.rebuilding import rebuild_at
from dineros.runtime.journal.saved import SavedState
from dineros.runtime.nodes.net import Net, load_runtime_model
from dineros.runtime.nodes.steering import SteeredNet
from dineros.runtime.ros.channels.parameters import JOURNAL, LOG_LEVEL, RESUME, SEED, WATCHDOG, declare
from dineros.runtime.ros.logs import ros_logs
from dineros.runtime.ros.process.clocks import clocks_of
from dineros.runtime.ros.process.session import Session
from dineros.runtime.ros.running import RosNode

LOG = logging.getLogger("dineros.runtime")

Register = Callable[[Net], None]
"""Registers the handlers of a net."""


def run_node(
    model: rtm.RuntimeModel,
    register: Register,
    arguments: Sequence[str] | None = None,
    *,
    source: str = "",
    settings: Sequence[str] = (),
    lifecycle: bool = False,
) -> int:
    """Run a node until the process is stopped.

    Parameters
    ----------
    model : rtm.RuntimeModel
        The runtime model.
    register : callable
        Registers the handlers of the net, before it starts.
    arguments : sequence of str, optional
        The command line, for ROS: remappings and parameters; by default that of the process.
    source, settings : str and sequence of str
        The system model's file, and the settings of ``--set``, for the journal.
    lifecycle : bool
        Whether it is a managed node, which opens its channels when it is configured and fires while it is
        active; so is a node whose model has a lifecycle.

    Returns
    -------
    int
        The exit status: 0; 1 if the node failed; 2 if it could not start.
    """
    logging.basicConfig(format=FORMAT)
    origin = {"source": source, "settings": settings}
    given = sys.argv[1:] if arguments is None else arguments
    line, gate = inherited_line(), inherited_gate()
    with Ending() as ending:
        try:
            status = _run(model, register, given, origin, lifecycle, ending.asked, line, gate)
        except DinerosError as error:
            print(error, file=sys.stderr)
            status = 2
    ending.leave(status)
    return status


def _run(
    model: rtm.RuntimeModel,
    register: Register,
    arguments: Sequence[str],
    origin: Mapping[str, Any],
    lifecycle: bool,
    ending: threading.Event,
    line: Line | None,
    gate: Gate | None,
) -> int:
    node = model.node
    lifecycle = lifecycle or (node.lifecycle is not None and model.middleware == sym.Middleware.ros2)
    options: dict[str, Any] = {}
    if lifecycle:
        if gate is not None:
            gate.leave()  # a manager activates the node later
        from dineros.runtime.ros.managed import make_managed_node

        options["make_node"] = make_managed_node
    session = Session(
        label(node),
        node.namespace or "",
        arguments=arguments,
        executor=str(node.executor),
        threads=node.threads,
        ending=ending,
        gate=gate,
        **options,
    )
    try:
        level = str(declare(session.node, LOG_LEVEL))
        with ros_logs(session.node, level, arguments, register.__module__.partition(".")[0]):
            times = itertools.count()

            def make() -> RosNode:
                return _make_node(model, register, session, origin, is_again=next(times) > 0)

            state = _last_state(model, session) if node.lifecycle is not None else ""
            _work(session, make, lifecycle, ending, state, line)
    finally:
        session.close()
    if session.failure is not None:
        return 2 if isinstance(session.failure, DinerosError) and not lifecycle else 1
    return 0


def _last_state(model: rtm.RuntimeModel, session: Session) -> str:
    """Return the state of a managed node when its process ended; empty if it does not continue."""
    folder = str(declare(session.node, JOURNAL))
    if not folder or not bool(declare(session.node, RESUME)):
        return ""
    try:
        return rebuild_at(Path(folder), model.node.id).lifecycle or ""
    except DinerosError:
        return ""


def _work(
    session: Session,
    make: Callable[[], RosNode],
    lifecycle: bool,
    ending: threading.Event,
    state: str,
    line: Line | None,
) -> None:
    """Run a node until the process is stopped, or the node fails."""
    if lifecycle:
        session.node.manage(make)
        session.node.come_back(state)
        session.start(session.node.work)
    else:
        running = make()
        running.start()

    def steered() -> SteeredNet | None:
        found: RosNode | None = session.node.running if lifecycle else running
        return None if found is None else found.steered

    with steered_over(line, steered):
        while not ending.is_set() and not session.join(timeout=0):
            ending.wait(0.2)
    if lifecycle:
        session.end()
        if session.node.running is not None:
            session.node.running.await_end()
        else:
            session.join()
        session.node.finish()
    else:
        running.stop("signal" if session.failure is None else "failure")


def _make_node(
    model: rtm.RuntimeModel,
    register: Register,
    session: Session,
    origin: Mapping[str, Any],
    *,
    is_again: bool,
) -> RosNode:
    """Create the node according to its parameters; a managed node that is configured again continues."""
    seed = int(declare(session.node, SEED))
    folder = str(declare(session.node, JOURNAL))
    resume = bool(declare(session.node, RESUME)) or is_again
    net = Net(model, seed=None if seed < 0 else seed, **clocks_of(session.node))
    net.ros_node = session.node
    net.watchdog = float(declare(session.node, WATCHDOG)) or None
    _register(register, net)
    recorder: JournalRecorder | None = None
    checkpoint: SavedState | None = None
    if folder and resume:
        recorder, checkpoint = resume_journal(Path(folder), net.id, **origin)
    elif folder:
        recorder = JournalRecorder(Path(folder), net.id, **origin)
    # Receivers that outlive this process must not confuse its messages with those of an earlier process.
    run = "" if checkpoint is not None else uuid.uuid4().hex[:8]
    return RosNode(net, recorder, resume=checkpoint, run=run, session=session)


def _register(register: Register, net: Net) -> None:
    """Register the handlers of a net.

    Raises
    ------
    HandlerFileError
        They cannot be imported, or their registration fails.
    """
    try:
        register(net)
    except DinerosError:
        raise
    except Exception as error:
        at = [frame for frame in traceback.extract_tb(error.__traceback__) if _is_of_developers(frame)]
        place = Location(Path(at[-1].filename), at[-1].lineno) if at else None
        said = str(error)
        if isinstance(error, SyntaxError) and error.filename:
            place, said = Location(Path(error.filename), error.lineno), error.msg
        LOG.debug("the handlers cannot be registered", exc_info=error)
        raise HandlerFileError(f"{type(error).__name__}: {said}", location=place) from error


def _is_of_developers(frame: traceback.FrameSummary) -> bool:
    """Return whether a frame belongs neither to this module nor to Python's import system."""
    return frame.filename not in (__file__, importlib.__file__) and not frame.filename.startswith("<")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node in a file; arguments after ``--ros-args`` are for ROS."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    at = given.index("--ros-args") if "--ros-args" in given else len(given)
    parser = argparse.ArgumentParser(prog="python -m dineros.runtime.ros.node_main", description=__doc__)
    parser.add_argument("model", help="the runtime model")
    parser.add_argument("--handlers", type=Path, help="a Python file that defines configure(net)")
    parser.add_argument("--source", default="", help="the file of the system model, for the journal")
    parser.add_argument(
        "--set", dest="settings", action="append", default=[], help="the settings by which it was changed"
    )
    parser.add_argument("--lifecycle", action="store_true", help="run as a managed node")
    options = parser.parse_args(given[:at])
    try:
        model = load_runtime_model(options.model)
    except DinerosError as error:
        print(error, file=sys.stderr)
        return 2

    @functools.cache
    def handlers() -> HandlerFile:
        return load_handler_file(options.handlers)

    def register(net: Net) -> None:
        """Load the handlers once logging is set up."""
        if options.handlers is not None:
            handlers().configure(net)

    return run_node(
        model,
        register,
        given[at:],
        source=options.source or options.model,
        settings=options.settings,
        lifecycle=options.lifecycle,
    )


if __name__ == "__main__":
    sys.exit(main())
