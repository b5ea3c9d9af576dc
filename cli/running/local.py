"""Runs an application in this process: on threads in real time, or step by step in simulated time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from dineros.cli.running.watching import Ending, Wanted, observe_all, watch
from dineros.metamodel.clauses import SignalSetting
from dineros.runtime.application.observer import FolderObserver

if TYPE_CHECKING:
    from dineros.cli.running.applications import Application
    from dineros.runtime.application.simulation import LocalApplication
    from dineros.runtime.journal.recording import Recorder
    from dineros.runtime.journal.saved import SavedState
    from dineros.runtime.nets.ports import Ports
    from dineros.views.live import Steering


class CountingRecorder:
    """Forwards records, and updates marking and signals of a node.

    Parameters
    ----------
    recorder : Recorder
        Stores the records.
    marking, signals : dict
        The current values, shared by all nodes.
    """

    def __init__(
        self, recorder: Recorder, marking: dict[str, int], signals: dict[str, SignalSetting]
    ) -> None:
        self._recorder = recorder
        self._marking = marking
        self._signals = signals

    def open(self, ports: Ports, checkpoint: Callable[[], SavedState]) -> None:
        """Prepare."""
        self._recorder.open(ports, checkpoint)
        state = checkpoint()
        self._marking.update({place: len(tokens) for place, tokens in state["marking"].items()})
        self._signals.update(state["signals"])

    def record(self, event: str, **fields: object) -> None:
        """Store a record."""
        change = fields.get("change")
        if isinstance(change, Mapping):
            for place, tokens in change.items():
                self._marking[place] = self._marking.get(place, 0) + tokens
        if event == "signal":
            self._signals[str(fields["signal"])] = bool(fields["value"])
        self._recorder.record(event, **fields)

    def close(self) -> None:
        """Close the records."""
        self._recorder.close()


def run_in_process(
    what: Application,
    wanted: Wanted,
    observer: FolderObserver,
    steering: Steering | None = None,
) -> Ending:
    """Run all nodes in this process: on threads, or step by step in simulated time.

    `steering`: gets the nodes, for pages that steer them.

    Raises
    ------
    DinerosError
        A model cannot run, a handler cannot be registered, a journal cannot be written.
    """
    from dineros.runtime.application.handler_files import load_handler_file
    from dineros.runtime.application.simulation import LocalApplication
    from dineros.runtime.journal import JournalRecorder, resume_journal
    from dineros.runtime.nodes.steering import SteeredNet

    options = wanted.options
    marking: dict[str, int] = {}
    signals: dict[str, SignalSetting] = {}
    recorders: dict[str, Recorder] = {}
    resumed: dict[str, SavedState] = {}
    origin: dict[str, Any] = {"source": str(what.source), "settings": what.settings}
    if options.is_simulated:
        origin["simulated"] = True
    for model in what.models:
        node = model.node.id
        if options.is_resumed:
            recorders[node], checkpoint = resume_journal(wanted.folder, node, **origin)
            if checkpoint is not None:
                resumed[node] = checkpoint
        else:
            recorders[node] = JournalRecorder(wanted.folder, node, **origin)
    application = LocalApplication(
        what.models,
        seed=options.seed,
        recorder=lambda node: CountingRecorder(recorders[node], marking, signals),
        resume=resumed,
        simulated_time=options.is_simulated,
    )
    for node, expected in what.expected.items():
        for signal, expectation in expected.items():
            application.nets[node].signal(signal).stale_after(expectation.seconds, expectation.then)
    if options.watchdog is not None:
        for net in application.nets.values():
            net.watchdog = options.watchdog or None
    handlers = load_handler_file(what.handlers) if what.handlers is not None else None
    if handlers is not None:
        handlers.simulate(application)
        for net in application.nets.values():
            handlers.configure(net)
    if steering is not None:
        steering.take({node: SteeredNet(net) for node, net in application.nets.items()})
    if not options.is_simulated:
        with application:
            ending: Ending = watch(wanted, observer, _Threads(application))
        return ending if observe_all(wanted, observer) else "deviated"
    until = wanted.until
    with application:
        try:
            ending = application.run(
                lambda _: wanted.interrupted.is_set() or (until is not None and until(marking, signals)),
                options.timeout,
                options.speed,
            )
            if wanted.interrupted.is_set():
                ending = "interrupted"
        except KeyboardInterrupt:
            ending = "interrupted"
    return ending if observe_all(wanted, observer) else "deviated"


class _Threads:
    """The nodes of an application that runs on threads."""

    descriptors: Sequence[int] = ()
    longest = 1.0

    def __init__(self, application: LocalApplication) -> None:
        self._nodes = application.nodes

    def poll(self) -> bool:
        """Raise the error that ended a node."""
        for node in self._nodes.values():
            if node.failure is not None:
                raise node.failure
        return True
