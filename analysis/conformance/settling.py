"""Steps that still wait for other nodes when nothing more can be replayed."""

from __future__ import annotations

from dineros.analysis.conformance.merging import Merger
from dineros.analysis.conformance.reasons import step_words
from dineros.analysis.conformance.verdict import Deviation, Verdict


def settle_waiting(merger: Merger, verdict: Verdict) -> None:
    """Report for each waiting step whether its message is known never to come.

    This is unknown if a node has no trace, or one that ends without a stop: the node may have done more than
    is recorded. Steps that wait only because of another reported step are left out.
    """
    for node, (record, waiting) in merger.waiting.items():
        step, doubt = step_words(record), _doubt(merger, node)
        if doubt is not None:
            verdict.unknown.append(Deviation(record, step, f"{waiting.reason}: {doubt}"))
        elif _is_to_blame(merger, node):
            reason = f"{waiting.reason}: {waiting.outside}" if waiting.outside else waiting.reason
            verdict.violations.append(Deviation(record, step, reason))


def _senders(merger: Merger, node: str) -> list[str]:
    return [sender for sender in merger.waiting[node][1].senders if sender != node]


def _doubt(merger: Merger, node: str) -> str | None:
    """Return why the step that a node waits for may have happened without a record."""
    for sender in _senders(merger, node):
        feed = merger.feeds.get(sender)
        if feed is None:
            return f"there is no trace of node {sender}"
        if feed.head() is None and not feed.has_stopped:
            where = f" ({feed.last.location})" if feed.last is not None and feed.last.location else ""
            return f"the trace of {sender} ends{where} without a stop"
    if merger.is_unclear(node):
        return "the messages have no ids; in another order the step may be allowed"
    return None


def _is_to_blame(merger: Merger, node: str) -> bool:
    """Return whether a node waits for a step that never happens, not only for other waiting nodes."""
    awaited: list[str] = []
    pending = [node]
    while pending:
        for sender in _senders(merger, pending.pop()):
            if sender in merger.failed:
                return False
            if sender in merger.waiting and sender not in awaited:
                if _doubt(merger, sender) is not None:
                    return False
                awaited.append(sender)
                pending.append(sender)
    return node in awaited or not awaited
