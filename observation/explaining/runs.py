"""Builds a run of the model that shows given messages, from the last message back to the first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from dineros.analysis.model.subject import Subject
from dineros.analysis.witnesses.witness import Witness, witness_of
from dineros.observation.explaining.following import Follower, State
from dineros.observation.explaining.marking_sets import MarkingSets, Vector


def run_of(follower: Follower, start: State, topics: Sequence[str], *, is_beginning: bool) -> Witness:
    """Return a run that shows messages on these topics, in this order.

    Parameters
    ----------
    follower : Follower
        The model.
    start : State
        The state before the first of them.
    topics : sequence of str
        Topics of the messages; there is such a run.
    is_beginning : bool
        Whether the run has to begin with the initial marking; else it begins with one that is possible.
    """
    states = [start]
    for topic in topics:
        states.append(follower.step(states[-1], topic))
    parts = follower.parts
    product = states[-1].products[0]
    markings = [sets.some(factor) for sets, factor in zip(parts, product, strict=True)]
    fired: list[int] = []  # backwards
    for before, topic in zip(reversed(states[:-1]), reversed(topics), strict=True):
        transition, earlier = _before(follower, before, topic, markings)
        for number, (sets, vector) in enumerate(zip(parts, earlier, strict=True)):
            if vector is not None:
                after = sets.fired(vector, transition)
                fired += reversed(sets.path(after, markings[number]))
                markings[number] = vector
        fired.append(transition)
    if is_beginning:
        for sets, vector in zip(parts, markings, strict=True):
            fired += reversed(sets.path(sets.first, vector))
    subject = follower.net.subject
    if not is_beginning:
        subject = _beginning_with(subject, parts, markings)
    return witness_of(subject, fired[::-1])


def _before(
    follower: Follower, state: State, topic: str, markings: Sequence[Vector]
) -> tuple[int, list[Vector | None]]:
    """Return a transition that can lead to these markings, and the markings before it that it changes."""
    for product in state.products:
        for transition in follower.net.shown[topic]:
            earlier: list[Vector | None] = []
            for sets, factor, vector in zip(follower.parts, product, markings, strict=True):
                if transition in sets.part.transitions:
                    found = sets.before(factor, transition, vector)
                    if found is None:
                        break
                    earlier.append(found)
                elif sets.contains(factor, vector):
                    earlier.append(None)
                else:
                    break
            else:
                return transition, earlier
    raise AssertionError("what is possible after a message was possible by one of its transitions")


def _beginning_with(subject: Subject, parts: Sequence[MarkingSets], markings: Sequence[Vector]) -> Subject:
    initial = subject.net.initial.copy()
    for sets, vector in zip(parts, markings, strict=True):
        for place, tokens in zip(sets.part.places, sets.tokens(vector), strict=False):
            initial[place] = tokens
    return replace(subject, net=replace(subject.net, initial=initial))
