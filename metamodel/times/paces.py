"""How often the steps of a callback can put tokens on a place, by their own intervals.

A loop that publishes and sleeps has a step that takes at least the time of the sleep. A transition has one
clock, which restarts when it has fired. So two firings of it are at least its earliest time apart, in one
run or in two, and a closed window of the length w holds at most ``floor(w / earliest) + 1`` of them.

Each slot of an action has a copy of the page, with clocks of its own. If several runs share a transition,
its interval is left open (rule D3Open), so nothing follows from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from dineros.metamodel import pn, pnm, sym
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import callback_page_of, runs_callbacks
from dineros.metamodel.callbacks.under_way import goals_at_once
from dineros.metamodel.elements import node_net_of, system_model_of
from dineros.metamodel.times.given import runs_at_once
from dineros.metamodel.times.once import once
from dineros.metamodel.times.runs import ports_at, stand_for


@dataclass(frozen=True)
class Pace:
    """The pace of one step.

    Attributes
    ----------
    tokens : int
        How many tokens come at one moment at most: of all copies of the step together.
    separation : Fraction
        Seconds between two such moments, at least.
    """

    tokens: int
    separation: Fraction

    def within(self, window: Fraction) -> int:
        """Return how many tokens come in a closed window at most."""
        return self.tokens * (int(window // self.separation) + 1)


@once
def paces(page: sym.CallbackPage, place: pn.Place) -> tuple[Pace, ...] | None:
    """Return the paces of the steps of a callback that put tokens on a place; None if one has none."""
    node = node_net_of(page)
    copies = _copies(page)
    if copies is None or not runs_callbacks(node) or node is None or node.lifecycle is not None:
        return None
    if page.duration is not None:
        return None
    body = Body(page)
    # Rules take these apart, for executors. Goals and requests begin and end by their ports.
    besides = set(body.beginnings()) if page.kind == sym.CallbackKind.timer else set()
    if page.kind not in (sym.CallbackKind.goal, sym.CallbackKind.server):
        besides |= set(body.ends())
    found = []
    for each in stand_for(place):
        for arc in each.incoming:
            if isinstance(arc.page, pnm.Sheet) or callback_page_of(arc) is not page:
                continue
            step = arc.source
            if not isinstance(step, pn.Transition) or step in besides or not _has_one_clock(step):
                return None
            earliest = 0.0 if step.interval is None else step.interval.earliest or 0.0
            if earliest <= 0:
                return None
            found.append(Pace(int(arc.weight) * copies, Fraction(repr(earliest))))
    return tuple(found)


def _has_one_clock(step: pn.Transition) -> bool:
    """Return whether no rule makes several transitions of a step, and no port or handler is part of it."""
    if any(ports_at(arc.source) for arc in step.incoming if isinstance(arc.source, pn.Place)):
        return False
    if isinstance(step, sym.Transition):
        return all(each is None for each in (step.clause, step.duration, step.guard, step.assigns))
    return True


def _copies(page: sym.CallbackPage) -> int | None:
    """Return how many copies of a page there are in the net; None if runs share its transitions.

    While a model is flattened, the copies of a page for the slots are pages of their own.
    """
    if page.kind == sym.CallbackKind.goal:
        numbers = slots(page)
        return None if numbers is None else sum(numbers) if numbers else 1
    return 1 if runs_at_once(page) == 1 else None


def slots(page: sym.CallbackPage) -> list[int] | None:
    """Return how many goals of each action a callback works on at once at most; None: any number."""
    model = system_model_of(page)
    known = {} if model is None else _goals_at_once(model)
    found = [number for action, number in known.items() if action.server.page is page]
    numbers = [number for number in found if number is not None]
    return numbers if len(numbers) == len(found) else None


@once
def _goals_at_once(model: sym.SystemModel) -> dict[sym.ActionChannel, int | None]:
    return goals_at_once(model)
