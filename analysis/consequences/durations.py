"""Overflows in models of source code: whether they happen depends on how long callbacks take.

A model of source code lets a callback take any time, as the code does not say how long it works. Then each
queue between nodes can overflow that is not bounded otherwise. Such a finding does not apply to the code: it
is a note. If writer and reader are in one node net, they share an executor. Then it stays an error if the
callbacks of this executor that write, each run once, write more than the queue holds: however quick the
reader is, it may come after them.

It stays an error, too, if the code itself says that the reader is too slow: each run takes longer than the
period of a timer of another node that publishes each time.

With times, it stays an error if the model gives all times that it depends on: those of the callbacks of its
nodes and of all that send them messages, and of the messages between them. In models of any source, an
overflow and an open question name the first of these times that is missing.

Ticks of timers are lost only with times. Whether they are is a note as long as a time is missing that it
depends on, unless the callback takes longer than its period in any case.

The search for such an overflow may not end. Then it could only be a note, too, and the question is left to
the durations. With times, that is so where the callback that reads has no greatest duration.
"""

from __future__ import annotations

from dataclasses import replace

from dineros.analysis.answers.budget import RAN_OUT
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.checks.overflow import Overflow
from dineros.analysis.consequences.missing_times import missing_times, missing_times_of, nodes_around
from dineros.analysis.model.channels import ends_of
from dineros.analysis.timed_checks.faults import LOSES_TICKS
from dineros.analysis.witnesses.findings import Finding, Report
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import callback_page_of, runs_callbacks
from dineros.metamodel.calls import HISTORY_DEPTH
from dineros.metamodel.elements import is_unseen, label, node_net_of
from dineros.metamodel.matching import are_matched
from dineros.metamodel.times.given import duration_of, period_of, runs_at_once, says_times
from dineros.metamodel.times.handlers import handled_for, handled_until
from dineros.metamodel.times.runs import least_put, most_put, only_put_by

WHY = "if callbacks take long enough; the code does not say how long they take"
OPEN = "depends on how long callbacks take, which the code does not say; `takes` in given.toml says it"


def left_to_durations(model: pn.Net, report: Report) -> Report:
    """Return a report in which overflows that depend on durations missing in the code are notes."""
    if not isinstance(model, sym.SystemModel):
        return report
    channels = {channel.id: channel for channel in model.channels}
    timers: dict[str, sym.CallbackPage] = {}
    if LOSES_TICKS.rule in {
        *(each.rule for each in report.findings),
        *(each.rule for each in report.unknown),
    }:
        timers = {page.id: page for page in model.eAllContents() if isinstance(page, sym.CallbackPage)}
    findings = []
    for finding in report.findings:
        if finding.rule == LOSES_TICKS.rule:
            findings.append(_tick_with_missing(finding, timers[finding.elements[0]]))
            continue
        channel = channels.get(next(iter(finding.elements), ""))
        is_open = finding.rule == Overflow.LOSES.rule and _depends(channel)
        if is_open and channel is not None and report.times is not None:
            is_open = not _has_all_times(channel)
        too_slow = _too_slow(channel, finding) if is_open else ""
        if too_slow:
            findings.append(replace(finding, message=f"{finding.message}: {too_slow}"))
        else:
            findings.append(
                finding.as_note(f", {WHY}") if is_open else _with_missing(finding, channel, report)
            )
    unknown = []
    for each in report.unknown:
        channel = channels.get(next(iter(each.elements), ""))
        is_open = each.rule == Overflow.LOSES.rule and _depends(channel)
        if each.rule == LOSES_TICKS.rule and (missing := _missing_of(timers[each.elements[0]])):
            findings.append(
                Finding(each.rule, "note", each.elements, f"{each.question} is not known; {missing}")
            )
        elif is_open and (report.times is None or _reads_for_any_time(channel)):
            findings.append(_open_note(each))
        else:
            unknown.append(_open_with_missing(each, channel, model, report))
    return replace(report, findings=findings, unknown=unknown)


def _too_slow(channel: sym.Channel | None, finding: Finding) -> str:
    """Return in words that a reader takes longer than the period of a publisher; empty if it may not."""
    if finding.rule != Overflow.LOSES.rule or not isinstance(channel, sym.TopicChannel):
        return ""
    readers = [port for port in channel.subscribers if port.place.id in finding.elements]
    for reader in readers:
        page = callback_page_of(reader.place)
        takes = None if page is None or runs_at_once(page) > 1 else duration_of(page)
        if takes is None:
            continue
        for writer in channel.publishers:
            if node_net_of(writer.place) is node_net_of(reader.place) or not are_matched(writer, reader):
                continue
            for sender in only_put_by(writer.place) or ():
                period = period_of(sender)
                if period is not None and takes.earliest > period and least_put(sender, writer.place):
                    least = f"its callback takes at least {takes.earliest:g} s"
                    return f"{least}, and {label(sender)} publishes each {period:g} s"
    return ""


def _with_missing(finding: Finding, channel: sym.Channel | None, report: Report) -> Finding:
    """Name in a finding of an overflow a time that the model does not give, and that can prevent it."""
    if finding.rule != Overflow.LOSES.rule or channel is None or report.times is None:
        return finding
    missing = next(missing_times(channel), "")
    return replace(finding, message=f"{finding.message}; {missing}") if missing else finding


def _tick_with_missing(finding: Finding, page: sym.CallbackPage) -> Finding:
    """Return a lost tick as a note that names a time which the model does not give, if there is one."""
    missing = _missing_of(page)
    return finding.as_note(f"; {missing}") if missing else finding


def _missing_of(page: sym.CallbackPage) -> str:
    """Return a time that is missing and decides whether a timer loses ticks; empty if there is none."""
    takes, period, node = duration_of(page), period_of(page), node_net_of(page)
    is_too_slow = takes is not None and period is not None and takes.earliest > period
    if node is None or (is_too_slow and runs_callbacks(node)):
        return ""
    for move in Body(page).beginnings() if not runs_callbacks(node) else ():
        if handled_for(move) is not None and handled_until(node, move) is None:
            return f"the duration of the handler of transition {label(move)} is not used"
    return next(missing_times_of([node]), "")


def _open_with_missing(
    unknown: Outcome, channel: sym.Channel | None, model: sym.SystemModel, report: Report
) -> Outcome:
    """Name in an open question with times a time that the model does not give."""
    if report.times is None or not says_times(model) or not _is_of_limit(unknown.reason):
        return unknown
    about = model.channels if channel is None else [channel]
    missing = next((each for one in about for each in missing_times(one)), "")
    return replace(unknown, reason=f"{unknown.reason}; {missing}") if missing else unknown


def _is_of_limit(reason: str) -> bool:
    return reason.startswith((*RAN_OUT.values(), "there are too many"))


def _open_note(unknown: Outcome) -> Finding:
    return Finding(Overflow.LOSES.rule, "note", unknown.elements, f"{unknown.question} {OPEN}")


def _reads_for_any_time(channel: sym.Channel | None) -> bool:
    """Return whether each callback that reads a channel may take any time."""
    pages = [callback_page_of(place) for place in ends_of(channel)[1]]
    return bool(pages) and all(
        page is not None and ((given := duration_of(page)) is None or given.latest is None) for page in pages
    )


def _has_all_times(channel: sym.Channel) -> bool:
    """Return whether the model gives all times on which the load of a channel depends."""
    is_of_callbacks = all(runs_callbacks(node) for node in nodes_around(channel))
    return is_of_callbacks and next(missing_times(channel), None) is None


def _depends(channel: sym.Channel | None) -> bool:
    ends = [[node_net_of(place) for place in places] for places in ends_of(channel)]
    nodes = [node for end in ends for node in end]
    if not nodes or not all(_is_of_code(node) for node in nodes):
        return False
    writers, readers = ({id(node) for node in end} for end in ends)
    return not writers & readers or _fits(channel)


def _fits(channel: sym.Channel | None) -> bool:
    """Return whether a queue has room for what the callbacks of its readers' executors write, each once."""
    room: int
    writers, readers = ends_of(channel)
    shared = {id(node_net_of(place)) for place in readers}
    match channel:
        case sym.TopicChannel():
            room = min(port.limit for port in (*channel.publishers, *channel.subscribers))
        case sym.ServiceChannel():
            room = channel.depth
        case _:
            room = HISTORY_DEPTH
    written = 0
    for place in (each for each in writers if id(node_net_of(each)) in shared):
        for page in only_put_by(place) or (None,):
            most = None if page is None else most_put(page, place)
            if most is None:
                return False
            written += most
    return written <= room


def _is_of_code(node: sym.NodeNet | None) -> bool:
    """Return whether a node is of source code, or stands for other nodes that may use its channels."""
    return node is not None and (bool(node.sourceLine) or is_unseen(node))
