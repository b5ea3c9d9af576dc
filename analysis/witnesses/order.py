"""Whether the messages of a run leave queues in the order in which they came.

If a flattened net does not keep the order of a queue whose messages guards distinguish, it may hand them
over in any order. That is safe for proofs. A run, however, may need an order that no middleware has.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from dineros.analysis.model.subject import Subject
from dineros.metamodel import pn
from dineros.transformations.flattening.coloured import RULE

_QUEUES = ("load", "requests", "responses")
"""Parts of channels that hold messages in order, by the role of their place in the rule that made it."""


def disorder(subject: Subject, firings: Sequence[int]) -> str:
    """Return the first queue that a message leaves before an older one, in words; empty: there is none.

    `firings`: transitions, from the initial marking.
    """
    queues = _unordered(subject)
    if not queues:
        return ""
    of_colour = {colour: queue for queue, colours in queues.items() for colour in colours}
    initial = subject.net.initial.tolist()
    waiting = {
        queue: deque(colour for colour in colours for _ in range(initial[colour]))
        for queue, colours in queues.items()
    }
    for transition in firings:
        for place, tokens in subject.net.pre.row(transition):
            for _ in range(tokens if place in of_colour else 0):
                if waiting[of_colour[place]].popleft() != place:
                    return subject.place_text(of_colour[place]).removesuffix(": load")
        for place, tokens in subject.net.post.row(transition):
            if place in of_colour:
                waiting[of_colour[place]].extend([place] * tokens)
    return ""


def _unordered(subject: Subject) -> dict[int, list[int]]:
    """Return the queues without an order, each with the places of the kinds of its messages."""
    links = [link for link in subject.links() if isinstance(link.target, pn.Place)]
    made = {
        link.target.id for link in links if link.maker is not None and link.role.rpartition(".")[2] in _QUEUES
    }
    colours: dict[str, list[str]] = {}
    for link in links:
        if link.rule != RULE or link.role != "colour":
            continue
        id = str(link.target.id)
        queue = next((each for each in made if id.startswith(f"{each}[")), None)
        if queue is not None:
            colours.setdefault(queue, []).append(id)
    index = subject.place_index
    return {
        index[queue]: [index[id] for id in ids]
        for queue, ids in colours.items()
        if len(ids) > 1 and not any(id.startswith(f"{queue}[oldest=") for id in ids)
    }
