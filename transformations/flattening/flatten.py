"""Flattening of SyM to PNM: the rules, then resolving references and removing pages (paper, Sect. 5.5)."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass

from dineros.metamodel import pn, pnm, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.callbacks.under_way import free_slots, goal_counts, outstanding_counts
from dineros.metamodel.calls import Served, actions, callers_first, server_pages, services, serving
from dineros.metamodel.elements import arcs, fresh_id, nodes, resolve, transitions
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.reading import collector_paused
from dineros.metamodel.guards.using import guarded
from dineros.metamodel.times.intervals import copied_interval
from dineros.metamodel.times.rates import settled
from dineros.transformations.flattening.bounding import join
from dineros.transformations.flattening.certificate import add_certificate, check_certificate
from dineros.transformations.flattening.guards import unfold_guards
from dineros.transformations.flattening.traces import Link, Trace
from dineros.transformations.language.copying import deep_copy
from dineros.transformations.language.creation import Copy, New
from dineros.transformations.language.engine import Engine, require_makers
from dineros.transformations.language.rule import Rule
from dineros.transformations.rules.catalogue import rules_of
from dineros.transformations.rules.phases import (
    MiddlewareVariant,
    OverflowVariant,
    Phase,
    SignalVariant,
    StandardRule,
)

KEPT = "kept"
"""Rule name in the trace for elements taken unchanged from the system model."""


@dataclass(frozen=True)
class Flattened:
    """A flattened model.

    Attributes
    ----------
    net : pnm.PetriNetModel
        The plain net: one page, no references.
    trace : Trace
        For each of its elements, the rule that made it and the source elements.
    """

    net: pnm.PetriNetModel
    trace: Trace


@collector_paused()
def flatten(
    model: sym.SystemModel,
    signals: SignalVariant = "input-enabled",
    overflow: OverflowVariant = "weighted",
    extra: Sequence[type[Rule]] = (),
    times: bool = False,
) -> Flattened:
    """Flatten a system model by the rules of its middleware; the model itself is not changed.

    Parameters
    ----------
    model : sym.SystemModel
        The model.
    signals : {"none", "fully-enabled", "input-enabled", "io-enabled"}
        When signals may change.
    overflow : {"weighted", "inhibitor"}
        How a full queue drops messages: T5b or T5a.
    extra : sequence of Rule
        Rules to apply after the standard ones; only the rules about capacities are applied later.
    times : bool
        Whether to model time; then the rules about times are applied, too, if the middleware is ``ros2``.

    Raises
    ------
    ReferenceCycleError
        References form a cycle.
    CallCircleError
        Services call each other in a cycle without a given number of instances.
    CertificateError
        The net lacks a place invariant that the rules guarantee.
    GuardError
        A guard or an assignment cannot be read.
    RuleError
        A rule fails.
    """
    is_ros2 = model.middleware == sym.Middleware.ros2
    middleware: MiddlewareVariant = "ros2" if is_ros2 else "ros1"
    times = times and is_ros2
    rules = rules_of(signals, overflow, middleware, times)
    instances = [rule for rule in rules if rule.phase is Phase.instances]
    standard = [rule for rule in rules if Phase.instances < rule.phase < Phase.bounds]
    last = [rule for rule in rules if rule.phase >= Phase.bounds]
    require_makers([*instances, *standard, *extra, *last])
    working, images = deep_copy(model)
    assert isinstance(working, sym.SystemModel)
    working.pages.append(pnm.Sheet(id="the rules' sheet"))
    engine = Engine(working)
    if not is_ros2:
        _block_clients(working)
    _count_what_is_under_way(working, times)
    with settled(working) if times else nullcontext():
        prototypes = _instantiate(working, engine, instances)
        _override_instances(working, engine)
        join(working, pn.ReferenceTransition)
        engine.run([*standard, *extra])
        join(working, pn.ReferencePlace)
        engine.run(last)

    if times:
        _be_prompt(engine)
    net = pnm.PetriNetModel(
        id=model.id,
        name=model.name,
        systemModel=model.id,
        signals=_literal(signals),
        overflow=overflow,
    )
    made = _plain_net(working, net, set(images.values()))
    trace = _trace(engine, {image: original for original, image in images.items()}, made)
    if guarded(model):
        trace = unfold_guards(model, net, trace)
    add_certificate(net, engine, made, middleware, times)
    check_certificate(net)
    del prototypes  # used for the links of S4
    return Flattened(net, trace)


def _be_prompt(engine: Engine) -> None:
    """Give the transitions that fire without delay the interval [0, 0]."""
    for application in engine.applications:
        for role, element in application.made.items():
            maker = application.rule.created[role]
            if isinstance(maker, New) and maker.is_prompt:
                assert isinstance(element, pn.Transition)
                element.interval = pn.TimeInterval(earliest=0.0, latest=0.0)


def _literal(variant: str) -> str:
    """Return the name of a variant in the metamodel: ``io-enabled`` is `ioEnabled`."""
    first, _, second = variant.partition("-")
    return first + second.capitalize()


def _instantiate(
    working: sym.SystemModel, engine: Engine, rules: Sequence[type[StandardRule]]
) -> list[pn.Page]:
    """Apply A6 to each action and S4 to each service, callers first; remove the originals of copies.

    So a service has the clients of all its callers' instances before its own instances are counted.
    """
    prototypes = []
    pages = server_pages(working)
    on_page: dict[pn.Page, dict[sym.ServiceChannel, list[sym.ClientPort]]] = {page: {} for page in pages}
    for called in services(working):
        for client in called.clients:
            caller = serving(client.request, pages)
            if caller is not None:
                on_page[caller.server.page].setdefault(called, []).append(client)
    channels: list[Served] = [*actions(working), *callers_first(working)]
    for channel in channels:
        page = channel.server.page
        for rule in rules:
            # Without clients on the page, only the copies of the page are needed.
            needed = on_page[page] or any(isinstance(made, Copy) for made in rule.created.values())
            if needed and rule.lhs[0].eclass is type(channel):
                engine.apply(rule, {rule.lhs[0]: channel})
        for called, clients in on_page[page].items():
            for client in clients:
                called.clients.remove(client)
                engine.extents.discard(client)
        if page.page is not None:
            page.page.objects.remove(page)
            engine.extents.discard(page)
            prototypes.append(page)
    for page in prototypes:
        for part in page.eAllContents():
            if isinstance(part, sym.Literal):
                part.signal = None  # else the signal counts as used where there are no instances
    return prototypes


def _override_instances(working: sym.SystemModel, engine: Engine) -> None:
    """Replace a transition in priorities by its instances."""
    instances: dict[EObject, list[pn.Transition]] = {}
    for images in engine.images.values():
        for original, copied in images.items():
            if isinstance(copied, pn.Transition):
                instances.setdefault(original, []).append(copied)
    for transition in transitions(working):
        for lower in list(transition.overrides):
            transition.overrides.extend(instances.get(lower, ()))


def _block_clients(working: sym.SystemModel) -> None:
    """Let each client have one request under way: calls block in ROS 1."""
    for channel in working.channels:
        for client in channel.clients if isinstance(channel, sym.ServiceChannel) else ():
            client.outstanding = 1


def _count_what_is_under_way(working: sym.SystemModel, times: bool) -> None:
    """Set the numbers of requests or goals under way of clients, and the numbers of slots of actions."""
    requests, goals = outstanding_counts(working, runs_overlap=times), goal_counts(working)
    for slots in free_slots(working, goals):
        slots.action.instances = slots.number
    for client, number in requests.items():
        client.outstanding = number
    for sender, number in goals.items():
        sender.outstanding = number


def _plain_net(
    working: sym.SystemModel, net: pnm.PetriNetModel, kept: set[EObject]
) -> dict[EObject, pn.Element]:
    """Fill the net with the places, transitions and arcs of the working model; return the image of each.

    Elements kept from the system model keep their ids.
    """
    taken = {net.id}
    taken.update(element.id for element in (*nodes(working), *arcs(working)) if element in kept)
    page = pn.Page(id=fresh_id("net", taken), net=net)

    def id_of(element: pn.Element) -> str:
        return element.id if element in kept else fresh_id(element.id, taken)

    made: dict[EObject, pn.Element] = {}
    for node in nodes(working):
        if isinstance(node, pn.Place):
            made[node] = pn.Place(id=id_of(node), name=node.name, tokens=node.tokens)
        elif isinstance(node, pn.Transition):
            made[node] = pn.Transition(
                id=id_of(node), name=node.name, interval=copied_interval(node.interval)
            )
    page.objects.extend(made.values())  # type: ignore[arg-type]
    for original, copied in list(made.items()):
        if isinstance(original, pn.Transition) and isinstance(copied, pn.Transition):
            copied.overrides.extend(
                lower for other in original.overrides if isinstance(lower := made.get(other), pn.Transition)
            )
    joined = []
    for arc in arcs(working):
        joint = pn.Arc(id=id_of(arc), weight=arc.weight, kind=arc.kind)
        joint.source = _image(arc, arc.source, made)
        joint.target = _image(arc, arc.target, made)
        made[arc] = joint
        joined.append(joint)
    page.arcs.extend(joined)
    return made


def _image(arc: pn.Arc, end: pn.Node, made: dict[EObject, pn.Element]) -> pn.Node:
    found = made.get(resolve(end))
    if not isinstance(found, pn.Node):
        raise DinerosError(
            f"arc {arc.id} ends at {end.id}, which leads into a server page from outside",
            element=arc.id,
            hint="only the elements of a server page may use its places",
        )
    return found


def _trace(engine: Engine, origins: dict[EObject, EObject], made: dict[EObject, pn.Element]) -> Trace:
    """Collect the links from elements of the system model to elements of the net."""
    links: list[Link] = []
    # Elements of server instances: copies of the elements of their page, and of its clients.
    instances: dict[EObject, tuple[EObject, int]] = {}
    copied_by: dict[EObject, str] = {}
    numbers = (len(engine.applications) + number for number in range(len(made)))
    for application in engine.applications:
        sources: dict[EObject, None] = {}
        index = client_index = None
        for source in application.sources:
            if isinstance(source, int):
                index = source
            elif source in instances:
                original, index = instances[source]
                sources[original] = None
                if isinstance(original, sym.ClientPort):
                    client_index = index
            elif source in origins:
                sources[origins[source]] = None
        rule = application.rule.__name__
        for role, element in application.elements():
            copies = engine.images.get(element)
            if isinstance(element, sym.ClientPort):
                original = next(each for each in application.sources if isinstance(each, sym.ClientPort))
                copies = {original: element}
            if copies is not None and index is not None:
                for original, copied in copies.items():
                    instances[copied] = (origins[original], index)
                    copied_by[copied] = rule
            if element in made:
                links.append(
                    Link(
                        rule,
                        role,
                        application.number,
                        tuple(sources),
                        index,
                        made[element],
                        client_index,
                        application.rule,
                    )
                )
    linked = {link.target for link in links}
    for element, target in made.items():
        if target in linked:
            continue
        original, instance = instances.get(element) or (origins[element], None)
        rule = KEPT if instance is None else copied_by[element]
        links.append(Link(rule, type(target).__name__.lower(), next(numbers), (original,), instance, target))
    return Trace(links)
