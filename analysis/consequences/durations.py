"""Overflows in models of source code: whether they happen depends on how long callbacks take.

A model of source code lets a callback take any time, as the code does not say how long it works. Then each
queue between nodes can overflow that is not bounded otherwise. Such a finding says nothing about the code: it
is a note. If writer and reader are in one node net, they share an executor. Then it stays an error if the
callbacks of this executor that write, each run once, write more than the queue holds: however quick the
reader is, it may come after them.

With times, it stays an error if the model gives all times that it depends on: those of the callbacks of its
nodes and of all that send them messages, and of the messages between them.

The search for such an overflow may not end. Then it could only be a note, too, and the question is left to
the durations. With times, that is so where the callback that reads has no greatest duration.
"""

from __future__ import annotations

from dataclasses import replace

from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.checks.overflow import Overflow
from dineros.analysis.witnesses.findings import Finding, Report
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import callback_page_of, runs_callbacks
from dineros.metamodel.calls import HISTORY_DEPTH
from dineros.metamodel.elements import is_unseen, node_net_of
from dineros.metamodel.matching import are_matched
from dineros.metamodel.times.given import duration_of, latency_between, latency_of_calls, period_of
from dineros.metamodel.times.runs import most_put, only_put_by

WHY = "if callbacks take long enough; the code does not say how long they take"
OPEN = "depends on how long callbacks take, which the code does not say; `takes` in given.toml says it"


def left_to_durations(model: pn.Net, report: Report) -> Report:
    """Return a report in which overflows that depend on durations missing in the code are notes."""
    if not isinstance(model, sym.SystemModel):
        return report
    channels = {channel.id: channel for channel in model.channels}
    findings = []
    for finding in report.findings:
        channel = channels.get(next(iter(finding.elements), ""))
        is_open = finding.rule == Overflow.LOSES.rule and _depends(channel)
        if is_open and channel is not None and report.times is not None:
            is_open = not _has_all_times(channel)
        findings.append(_as_note(finding) if is_open else finding)
    unknown = []
    for each in report.unknown:
        channel = channels.get(next(iter(each.elements), ""))
        is_open = each.rule == Overflow.LOSES.rule and _depends(channel)
        if is_open and (report.times is None or _reads_for_any_time(channel)):
            findings.append(_open_note(each))
        else:
            unknown.append(each)
    return replace(report, findings=findings, unknown=unknown)


def _as_note(finding: Finding) -> Finding:
    return replace(finding, severity="note", message=f"{finding.message}, {WHY}")


def _open_note(unknown: Outcome) -> Finding:
    return Finding(Overflow.LOSES.rule, "note", unknown.elements, f"{unknown.question} {OPEN}")


def _reads_for_any_time(channel: sym.Channel | None) -> bool:
    """Return whether each callback that reads a channel may take any time."""
    pages = [callback_page_of(place) for place in _places(channel)[1]]
    return bool(pages) and all(
        page is not None and ((given := duration_of(page)) is None or given.latest is None) for page in pages
    )


def _has_all_times(channel: sym.Channel) -> bool:
    """Return whether the model gives all times on which the load of a channel depends."""
    todo, seen = _nodes_of(channel), set[sym.NodeNet]()
    while todo:
        node = todo.pop()
        if node in seen:
            continue
        seen.add(node)
        if is_unseen(node) or node.lifecycle is not None or not runs_callbacks(node):
            return False
        pages = [each for each in node.eAllContents() if isinstance(each, sym.CallbackPage)]
        if not all(map(_has_times, pages)):
            return False
        for other in channel.model.channels if channel.model is not None else ():
            is_topic = isinstance(other, sym.TopicChannel)
            places = _places(other)[1] if is_topic else [place for end in _places(other) for place in end]
            if node in map(node_net_of, places):
                if not all(map(_ends, _latencies(other, node))):
                    return False
                todo += _nodes_of(other)
    return True


def _has_times(page: sym.CallbackPage) -> bool:
    """Return whether a callback, or each of its steps, has a greatest duration, and a timer its period."""
    if page.kind == sym.CallbackKind.timer and period_of(page) is None:
        return False
    steps = [each.interval for each in Body(page).transitions]
    return _ends(duration_of(page)) or (bool(steps) and all(map(_ends, steps)))


def _ends(interval: pn.TimeInterval | None) -> bool:
    return interval is not None and interval.latest is not None


def _latencies(channel: sym.Channel, node: sym.NodeNet) -> list[pn.TimeInterval | None]:
    """Return the latencies of what a node gets from a channel; of requests and goals, of all of them."""
    if isinstance(channel, sym.TopicChannel):
        return [
            latency_between(writer, reader)
            for reader in channel.subscribers
            for writer in channel.publishers
            if node_net_of(reader.place) is node and are_matched(writer, reader)
        ]
    if isinstance(channel, sym.ServiceChannel | sym.ActionChannel):
        return [latency_of_calls(client) for client in channel.clients]
    return []


def _nodes_of(channel: sym.Channel) -> list[sym.NodeNet]:
    nodes = [node_net_of(place) for end in _places(channel) for place in end]
    return [each for each in nodes if each is not None]


def _depends(channel: sym.Channel | None) -> bool:
    ends = [[node_net_of(place) for place in places] for places in _places(channel)]
    nodes = [node for end in ends for node in end]
    if not nodes or not all(_is_of_code(node) for node in nodes):
        return False
    writers, readers = ({id(node) for node in end} for end in ends)
    return not writers & readers or _fits(channel)


def _fits(channel: sym.Channel | None) -> bool:
    """Return whether a queue has room for what the callbacks of its readers' executors write, each once."""
    room: int
    writers, readers = _places(channel)
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


def _places(channel: sym.Channel | None) -> tuple[list[pn.Place], list[pn.Place]]:
    """Return the places of those who write into a channel, and of those who read."""
    match channel:
        case sym.TopicChannel():
            return [port.place for port in channel.publishers], [port.place for port in channel.subscribers]
        case sym.ServiceChannel():
            return [port.request for port in channel.clients], [channel.server.entry]
        case sym.ActionChannel():
            return [port.goal for port in channel.clients], [channel.server.entry]
    return [], []
