"""Building nets in Python: arcs that read like the flow they describe, and whole steps.

>>> from dineros.metamodel import pn
>>> from dineros.metamodel.build import flow
>>> page = pn.Page(id="page")
>>> idle, start, busy = pn.Place(id="idle", tokens=1), pn.Transition(id="start"), pn.Place(id="busy")
>>> page.objects.extend([idle, start, busy])
>>> [arc.id for arc in flow(idle, start, busy)]
['idle-start', 'start-busy']

A step of a system model names what it takes and what it puts; the places may be on any pages:

>>> from dineros.metamodel import sym
>>> from dineros.metamodel.build import callback, node_net, place, step
>>> dock = node_net(sym.SystemModel(id="yard"), "dock", ["Open"])
>>> free = place(dock, "Free", tokens=1)
>>> on_ship = callback(dock, "OnShip")
>>> ship, moored = place(on_ship, "Ship"), place(on_ship, "Moored")
>>> moor = step(on_ship, "Moor", [ship, free], [moored], clause="Open")
>>> [arc.id for arc in [*moor.incoming, *moor.outgoing]]
['Ship-Moor', 'Free@OnShip-Moor', 'Moor-Moored']
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

from dineros.metamodel import pn, sym
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.errors import DinerosError


def flow(*nodes: pn.Node, weight: int = 1) -> list[pn.Arc]:
    """Join nodes of one page by a chain of normal arcs, in the order given.

    Raises
    ------
    DinerosError
        Two neighbours are not on the same page.
    """
    return [_arc(source, target, weight, "normal") for source, target in pairwise(nodes)]


def read(place: pn.PlaceNode, transition: pn.TransitionNode, weight: int = 1) -> pn.Arc:
    """Let a transition test a place for `weight` tokens without taking them."""
    return _arc(place, transition, weight, "read")


def inhibit(place: pn.PlaceNode, transition: pn.TransitionNode, weight: int = 1) -> pn.Arc:
    """Let a transition be enabled only while a place holds fewer than `weight` tokens."""
    return _arc(place, transition, weight, "inhibitor")


def _arc(source: pn.Node, target: pn.Node, weight: int, kind: str) -> pn.Arc:
    page = source.page
    if page is None or page is not target.page:
        raise DinerosError(
            f"{source.id} and {target.id} are not on the same page",
            element=source.id,
            hint="use a reference place or a reference transition",
        )
    suffix = "" if kind == "normal" else f"-{kind}"
    return pn.Arc(
        id=f"{source.id}-{target.id}{suffix}",
        source=source,
        target=target,
        weight=weight,
        kind=kind,
        page=page,
    )


def node_net(
    model: sym.SystemModel,
    id: str,
    signals: Iterable[str] | Mapping[str, Sequence[str]] = (),
    package: str | None = None,
    *,
    namespace: str | None = None,
    execution: sym.Execution | str = "net",
    threads: int = 1,
    lifecycle: sym.Lifecycle | None = None,
    order: sym.CallbackOrder | str = "any",
    reaction: pn.TimeInterval | None = None,
) -> sym.NodeNet:
    """Add a node net with its signals to a model.

    Parameters
    ----------
    model : sym.SystemModel
        The model.
    id : str
        Id and name of the node.
    signals : iterable of str, or mapping of str to sequence of str
        Ids of its input signals. A mapping gives the values of each, the first of them at the start; a signal
        without values is false at the start.
    package : str, optional
        The ROS package that it becomes.
    namespace : str, optional
        Its absolute ROS namespace.
    execution : {"net", "callbacks"}
        Whether the net interleaves its callbacks, or an executor and callback groups do.
    threads : int
        Threads of its executor; more than one make it multi-threaded.
    lifecycle : sym.Lifecycle, optional
        What may happen to it as a managed node; without one it is not managed.
    order : {"any", "rclcpp", "rclpy"}
        Which callback that is ready its executor takes.
    reaction : pn.TimeInterval, optional
        What the engine of the execution net takes to fire; see `seconds`.
    """
    made = sym.NodeNet(
        id=id,
        name=id,
        package=package,
        namespace=namespace,
        execution=execution,
        executor="multi" if threads > 1 else "single",
        threads=threads,
        lifecycle=lifecycle,
        order=order,
        reaction=reaction,
        net=model,
    )
    valued = signals if isinstance(signals, Mapping) else dict.fromkeys(signals, ())
    for signal, values in valued.items():
        sym.InputSignal(
            id=signal, name=signal, node=made, values=[sym.SignalValue(name=value) for value in values]
        )
    return made


def callback(
    net: sym.NodeNet,
    id: str,
    kind: sym.CallbackKind | str = "subscriber",
    timer: float | None = None,
    *,
    duration: pn.TimeInterval | None = None,
    offset: pn.TimeInterval | None = None,
    jitter: float | None = None,
) -> sym.CallbackPage:
    """Add the page of a callback to a node net.

    Parameters
    ----------
    net : sym.NodeNet
        The node net.
    id : str
        Id and name of the page.
    kind : {"timer", "subscriber", "server", "client", "goal"}
        What calls it.
    timer : float, optional
        The period of a timer, in seconds.
    duration : pn.TimeInterval, optional
        Processor time of one run, without what it waits for; see `seconds`.
    offset, jitter : pn.TimeInterval, float, optional
        Of a timer: when it strikes first, and how late a single strike may be.
    """
    return sym.CallbackPage(
        id=id, name=id, kind=kind, timer=timer, duration=duration, offset=offset, jitter=jitter, page=net
    )


def seconds(earliest: float, latest: float | None) -> pn.TimeInterval:
    """Return an interval of seconds with its bounds; without a latest one, it has no end.

    Examples
    --------
    >>> seconds(0.005, 0.02).latest
    0.02
    """
    return pn.TimeInterval(earliest=earliest, latest=latest)


def place(page: pn.Page, id: str, tokens: int = 0, type: sym.TokenType | None = None) -> sym.Place:
    """Add a place to a page; `type` is the type of its tokens, if it differs from that of its model."""
    return sym.Place(id=id, name=id, tokens=tokens, tokenType=type, page=page)


def step(
    page: pn.Page,
    id: str,
    takes: Iterable[pn.PlaceNode] = (),
    puts: Iterable[pn.PlaceNode] = (),
    clause: str | None = None,
) -> sym.Transition:
    """Add a transition to a page: it takes a token of some places and puts one on others.

    Those that are on other pages are referred to. `clause` is a boolean expression over signals.

    Raises
    ------
    ClauseError
        As for `dineros.metamodel.clauses.set_clause`.
    """
    made = sym.Transition(id=id, name=id, page=page)
    for before in takes:
        flow(here(before, page), made)
    for after in puts:
        flow(made, here(after, page))
    if clause is not None:
        set_clause(made, clause)
    return made


def suppress(element: pn.Element, rule: str, reason: str, until: str | None = None) -> pn.Suppression:
    """Accept the findings of a rule about an element and what it contains; see `docs/ci.md`.

    Parameters
    ----------
    element : pn.Element
        The element, such as a channel, a place, a node net or the whole model.
    rule : str
        The rule, such as ``queue-overflow``.
    reason : str
        Why the finding is accepted; shown in every report.
    until : str, optional
        The last day on which it is accepted, such as ``2027-03-31``.
    """
    made = pn.Suppression(rule=rule, reason=reason, until=until)
    element.suppressions.append(made)
    return made


def here(place: pn.PlaceNode, page: pn.Page) -> pn.PlaceNode:
    """Return a place that is on a page; for one of another page, the reference to it, made if need be."""
    if place.page is page:
        return place
    for known in page.objects:
        if isinstance(known, pn.ReferencePlace) and known.target is place:
            return known
    return pn.ReferencePlace(id=f"{place.id}@{page.id}", name=place.name, target=place, page=page)
