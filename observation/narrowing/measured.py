"""Converts times proposed by recordings or tracing files to facts given for callbacks."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from dineros.observation.importing.given import Given
from dineros.observation.measuring.proposing import TimeProposal, ticks_proposed
from dineros.observation.measuring.samples import Samples
from dineros.observation.narrowing.proposals import Proposal, timer_name
from dineros.observation.systems import ObservedSystem


def times_of_timers(proposals: Iterable[Proposal], source: str) -> list[TimeProposal]:
    """Return period and jitter of timers, from the times between their messages in a recording."""
    found = []
    for each in proposals:
        if each.kind == "timer":
            name = timer_name(each.topic)
            gaps = each.gaps if each.gaps is not None else Samples()
            ticks = ticks_proposed(f"{each.node} {name}", f"{each.node}: {name}", gaps, source)
            found += [ticks] if ticks is not None else []
    return found


def with_times(
    given: Given, system: ObservedSystem, accepted: Iterable[TimeProposal]
) -> tuple[Given, tuple[TimeProposal, ...]]:
    """Return the given facts with accepted times, and the times that callbacks now have.

    A timer has times if it has been accepted. Times that are already given are not replaced.
    """
    held = []
    nodes = dict(given.nodes)
    begun = {
        node.name: {
            *(each.topic for each in node.subscribers),
            *(each.name for each in (*node.servers, *node.action_servers)),
        }
        for node in system.nodes
    }
    for time in accepted:
        node, _, callback = time.element.partition(" ")
        said = given.node(node) if node not in nodes else nodes[node]
        before = said.callback(callback)
        if callback not in begun.get(node, ()) and callback not in (said.timers or {}):
            continue
        if time.feature == "duration" and before.takes is None:
            known = replace(before, takes=time.interval)
        elif time.feature == "period" and before.jitter is None:
            known = replace(before, jitter=time.jitter)
        else:
            continue
        held.append(time)
        known = replace(known, measured="; ".join(filter(None, (before.measured, time.origin))))
        nodes[node] = replace(said, callbacks={**said.callbacks, callback: known})
    return replace(given, nodes=nodes), tuple(held)
