"""Explains in terms of the model why a transition is not enabled."""

from __future__ import annotations

from collections.abc import Sequence

from dineros.analysis.conformance.net import ConformanceNet
from dineros.metamodel import sym
from dineros.metamodel.clauses import setting_text
from dineros.metamodel.errors import counted
from dineros.metamodel.records import Checkpoint, Drop, Fire, GoalStep, Lifecycle, Record, Signal, Start
from dineros.metamodel.records.schema import ChannelStep


def why_not(net: ConformanceNet, transition: int, marking: Sequence[int]) -> str:
    """Return why a transition is not enabled: missing tokens, inhibitors, false clauses."""
    reasons = []
    for place, weight in net.pre[transition]:
        if marking[place] >= weight:
            continue
        if place in net.disjunctions:
            reasons.append(_clause(net.disjunctions[place]))
        else:
            reasons.append(f"{_name(net, place)} holds {_tokens(marking[place])}, {weight} needed")
    for place, weight in net.inhibitor[transition]:
        if marking[place] >= weight:
            reasons.append(
                f"{_name(net, place)} holds {_tokens(marking[place])}, which inhibits it from {weight} on"
            )
    return "; ".join(reasons)


def step_words(record: Record) -> str:
    """Describe the recorded step."""
    match record:
        case Fire():
            return f"{record.transition} fires"
        case Signal():
            return f"signal {record.signal} becomes {setting_text(record.value)}"
        case Lifecycle():
            return f"it is asked to {record.label}, and is {record.state} then"
        case Drop(queue="inactive"):
            return f"{record.place} publishes while the node is inactive ({record.channel})"
        case Drop(queue="request"):
            return f"the request history of {record.channel} loses {record.message or 'a request'}"
        case Drop():
            return f"the {record.queue} queue of {record.channel} drops {counted(record.count, 'message')}"
        case ChannelStep():
            return f"{record.place} {record.declared.words(record)} ({record.channel})"
        case GoalStep():
            return f"{record.declared.words(record)} ({record.channel})"
        case Checkpoint():
            return "checkpoint"
        case Start():
            return "the node resumes" if record.resumed else "the node starts"
    return record.declared.words(record) or record.event


def _clause(disjunction: sym.Disjunction) -> str:
    literals = ", ".join(f"{literal.signal.id} is {_missed(literal)}" for literal in disjunction.literals)
    clause = disjunction.eContainer()
    name = getattr(clause, "name", None) or "clause"
    return f"its clause {name} is false: {literals}"


def _missed(literal: sym.Literal) -> str:
    """Return what a signal is while a literal about it is false."""
    if literal.value is not None:
        return literal.value if literal.negated else f"not {literal.value}"
    return "true" if literal.negated else "false"


def _name(net: ConformanceNet, place: int) -> str:
    return net.subject.place_text(place)


def _tokens(number: int) -> str:
    return counted(number, "token") if number else "no token"
