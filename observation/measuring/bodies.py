"""Maps transitions of a model to callbacks, timers and readers, for reading traces."""

from __future__ import annotations

from dataclasses import dataclass

from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.bodies import Body, calls_of, timers_of
from dineros.metamodel.callbacks.groups import runs_callbacks
from dineros.metamodel.elements import channels, node_net_of, pages


@dataclass(frozen=True)
class MeasuredCallback:
    """A callback page: ids of its transitions by which it ends, and of those by which its timer begins it."""

    id: str
    begins: frozenset[str]
    """Transitions that start it by a timer with a period."""
    ends: frozenset[str]
    """Transitions that end it."""
    period: float
    jitter: float
    """`period`, `jitter`: of its timer, in seconds; no period: 0."""
    begins_at_once: bool
    """Whether nothing but its timer and a free thread is needed for it to begin."""


class Bodies:
    """The callbacks of a model, by the transitions that their nodes record."""

    def __init__(self, model: sym.SystemModel) -> None:
        self.callbacks: dict[str, MeasuredCallback] = {}
        """By the id of a transition."""
        self.readers: dict[str, set[str]] = {}
        """Places at which messages arrive, by node."""
        calls, timers = calls_of(model), set(timers_of(model))
        for page in pages(model):
            node = node_net_of(page)
            if not isinstance(page, sym.CallbackPage) or node is None:
                continue
            if page in timers or runs_callbacks(node):
                self._add(page, Body(page, calls), page in timers, node)
        for channel in channels(model, sym.TopicChannel):
            for port in channel.subscribers:
                owner = node_net_of(port.place)
                if owner is not None:
                    self.readers.setdefault(str(owner.id), set()).add(str(port.place.id))

    def _add(self, page: sym.CallbackPage, body: Body, is_timed: bool, node: sym.NodeNet) -> None:
        begins = body.beginnings() if is_timed else []
        found = MeasuredCallback(
            str(page.id),
            frozenset(str(each.id) for each in begins),
            frozenset(str(each.id) for each in body.ends()) if runs_callbacks(node) else frozenset(),
            float(page.timer or 0) if is_timed else 0.0,
            float(page.jitter or 0),
            node.lifecycle is None and all(_is_free(each) for each in begins),
        )
        for transition in body.transitions:
            self.callbacks[str(transition.id)] = found


def _is_free(transition: pn.Transition) -> bool:
    """Return whether a transition needs no token, no room and no signal."""
    has_room = all(not getattr(arc.target, "capacity", None) for arc in transition.outgoing)
    is_needed = transition.incoming or getattr(transition, "clause", None) is not None
    return has_room and not is_needed
