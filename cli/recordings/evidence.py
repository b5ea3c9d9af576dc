"""``dineros narrow``: observations of a system, in a recording, in tracing files, or in both."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.console import warn
from dineros.cli.observing import opened
from dineros.metamodel.errors import Location, counted

if TYPE_CHECKING:
    from dineros.observation.importing.given import Given
    from dineros.observation.measuring.proposing import TimeProposal
    from dineros.observation.narrowing import Proposal, Traced
    from dineros.observation.narrowing.narrowing import Messages
    from dineros.observation.recordings import Calls, Untaken
    from dineros.observation.systems import ObservedSystem, RecordedTopic


@dataclass(frozen=True)
class Evidence:
    """Observations, with their proposals."""

    source: Path
    """The source of the messages to explain: the recording, or else the tracing files."""
    tracing: Path | None
    proposals: list[Proposal]
    """What the recording and the tracing files propose."""
    recorded: Collection[RecordedTopic]
    messages: Messages
    """`recorded`, `messages`: what is explained."""
    calls: Mapping[str, Calls]
    """What services report about their calls in the recording."""
    untaken: Sequence[Untaken]
    """Responses in the recording that no client took."""
    traced: Traced | None
    """What is counted of tracing files."""
    times: list[TimeProposal]
    """Durations, periods and jitter."""


def gathered(
    system: ObservedSystem,
    given: Given,
    bag: Path | None,
    tracing: Path | None,
    within: float,
    stage: Callable[[str], None],
    open_files: ExitStack,
) -> Evidence:
    """Read the observations of a system; warn of data missing in tracing files.

    Parameters
    ----------
    bag, tracing : Path or None
        A recording and tracing files, one of them at least.
    within : float
        Seconds after which a message is not consequence of another one any more.
    stage : callable
        Called with what is read.
    open_files : ExitStack
        Closes the recording.

    Raises
    ------
    DinerosError
        One of them cannot be read.
    """
    from dineros.observation.narrowing import proposals, publications, traced, verbs_of, with_traced
    from dineros.observation.narrowing.measured import times_of_timers
    from dineros.observation.recordings import Observed
    from dineros.observation.tracing import Tracing, TracingError

    source = bag or tracing
    if source is None:
        raise ValueError("neither a recording nor tracing files")
    counts = None
    if tracing is not None:
        stage(f"reading {tracing.name}")
        files = Tracing(tracing)
        counts = traced(system, files)
        if not counts.nodes:
            known = f"it contains {', '.join(sorted(counts.others))[:300]}" if counts.others else None
            raise TracingError(
                "it contains no data of a node of the model", location=Location(tracing), hint=known
            )
        _warn(tracing, counts)
    calls: Mapping[str, Calls] = {}
    untaken: Sequence[Untaken] = ()
    recorded: Collection[RecordedTopic]
    messages: Messages
    if bag is not None:
        recording = open_files.enter_context(opened(bag))
        observed = Observed(recording)
        recorded, messages = observed.recorded, observed.messages
        calls, untaken = observed.calls, observed.untaken
    else:
        assert tracing is not None and counts is not None
        recorded, messages = counts.recorded(), lambda: publications(system, files)
    verbs = verbs_of(system, recorded, given)
    found = proposals(system, messages(), verbs=verbs, within=within)
    if counts is not None:
        found = with_traced(found, counts)
    times = [] if bag is None else times_of_timers(found, bag.name)
    if tracing is not None and counts is not None:
        times = [*counts.times(tracing.name), *times]
    return Evidence(source, tracing, found, recorded, messages, calls, untaken, counts, times)


def _warn(tracing: Path, counts: Traced) -> None:
    """Warn of data that tracing files do not attribute, and of missing data."""
    unknown = counts.uncertain
    if counts.discarded:
        warn(f"{tracing}: the tracer's buffer was full: {counted(counts.discarded, 'event')} are missing")
    if counts.odd:
        warn(f"{tracing}: {counted(counts.odd, 'line')} ignored: not an event, or cut off")
    if unknown.callbacks or unknown.messages:
        runs, messages = counted(unknown.callbacks, "run"), counted(unknown.messages, "message")
        warn(f"{tracing}: unknown nodes of {runs} of callbacks and {messages}: they started before the trace")
    missing = [node.name for node in counts.system.nodes if node.name not in counts.nodes]
    if missing:
        shown = ", ".join(missing[:5]) + (", ..." if len(missing) > 5 else "")
        warn(f"{tracing}: it contains no data of {counted(len(missing), 'node')} of the model: {shown}")
