"""Changes of callback groups and threads: what they are in words and as settings, and what each may mend."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from dineros.analysis.callbacks.waiting import Circle, Waiter
from dineros.metamodel import sym
from dineros.metamodel.callbacks.groups import answered_on, begins_callback, callback_page_of, threads_of
from dineros.metamodel.elements import elements, find

Owner = tuple[str, str]
"""Id of a callback page and no text; or id of a service, and the client."""


@dataclass(frozen=True)
class Changes:
    """What is changed in a model.

    Attributes
    ----------
    own : frozenset of (str, str)
        Callback pages and clients that get a group of their own.
    reentrant : frozenset of (str, str)
        Those whose own group is reentrant; and callback groups, by their id, that become so.
    threads : tuple of (str, int)
        Node nets, by their id, that get so many more threads.
    """

    own: frozenset[Owner] = frozenset()
    reentrant: frozenset[Owner] = frozenset()
    threads: tuple[tuple[str, int], ...] = ()

    @property
    def cost(self) -> tuple[int, int, int]:
        """How many changes there are; of as many, reentrant groups come last, more threads before them."""
        more = sum(number for _, number in self.threads)
        return len(self.own) + len(self.reentrant) + more, len(self.reentrant), more

    def with_thread(self, node: str) -> Changes:
        """Return these changes and one more thread."""
        threads = dict(self.threads)
        threads[node] = threads.get(node, 0) + 1
        return replace(self, threads=tuple(sorted(threads.items())))

    def steps(self, model: sym.SystemModel) -> Iterator[tuple[str, tuple[str, ...]]]:
        """Yield each change in words, and the settings that make it."""
        taken = {str(element.id) for element in elements(model)}
        for owner in sorted(self.own):
            name, what = _named(model, owner)
            kind = "reentrant callback group" if owner in self.reentrant else "callback group"
            group = f"{'_'.join(filter(None, owner))}_group"
            while group in taken:
                group += "_"
            settings = [f"{each}.group={group}" for each in (name, *_with_client(model, owner))]
            if owner in self.reentrant:
                settings.append(f"{group}.kind=reentrant")
            yield f"{what} in a {kind} of its own", tuple(settings)
        for group, _ in sorted(self.reentrant - self.own):
            yield f"callback group {group} reentrant", (f"{group}.kind=reentrant",)
        for id, more in self.threads:
            threads = threads_of(find(model, id, sym.NodeNet)) + more
            yield (
                f"{threads} threads for node net {id}",
                (f"{id}.executor=multi", f"{id}.threads={threads}"),
            )


def _named(model: sym.SystemModel, owner: Owner) -> tuple[str, str]:
    """Return how settings name a callback page or a client, and how words do."""
    id, client = owner
    if not client:
        return id, f"callback {id}"
    service = find(model, id, sym.ServiceChannel)
    return f"{id}.client.{client}", f"client {client} of service {service.service}"


def _with_client(model: sym.SystemModel, owner: Owner) -> Iterator[str]:
    """Yield the callback page that a client's responses begin, where it is in a group, as its client is."""
    id, client = owner
    ports = find(model, id, sym.ServiceChannel).clients if client else ()
    for port in ports:
        page = callback_page_of(port.response)
        if port.client == client and begins_callback(port) and page is not None and page.group is not None:
            yield str(page.id)


def against_circle(changes: Changes, circle: Circle) -> Iterator[Changes]:
    """Yield what, added to some changes, may break a circle: whatever breaks it holds one of these.

    A thread that is waited for comes with one more of them; a group, where the one that waits leaves it, or
    the one that has it, or where it becomes reentrant.
    """
    waiters = circle.waiters
    around = zip((waiters[-1], *waiters[:-1]), waiters, (*waiters[1:], waiters[0]), strict=True)
    for before, one, after in around:
        if one.kind == "thread":
            assert isinstance(one.model, sym.NodeNet)
            yield changes.with_thread(one.element)
        elif one.kind == "group":
            yield from _own(changes, (before.model, after.model))
            yield from _reentrant(changes, one, after)


def against_run(changes: Changes, begun: Iterable[sym.CallbackPage]) -> Iterator[Changes]:
    """Yield what, added to some changes, keeps callbacks that begin in a run from running twice at once."""
    reentrant = sym.CallbackGroupKind.reentrant
    twice = [page for page in begun if page.group is not None and page.group.kind == reentrant]
    yield from _own(changes, twice)


def _own(changes: Changes, models: Sequence[object]) -> Iterator[Changes]:
    for model in models:
        owner = _owner(model)
        if owner is not None and owner not in changes.own:
            yield replace(changes, own=changes.own | {owner})


def _reentrant(changes: Changes, group: Waiter, holder: Waiter) -> Iterator[Changes]:
    """Yield the group made reentrant; or that of the callback that has it, where it is its own."""
    owner = _owner(holder.model)
    if owner is not None and owner in changes.own:
        made = owner
    elif isinstance(group.model, sym.CallbackGroup):
        made = (str(group.model.id), "")
    else:
        return
    if made not in changes.reentrant:
        yield replace(changes, reentrant=changes.reentrant | {made})


def _owner(model: object) -> Owner | None:
    """Return whose group can be changed; of what a response begins, that is its client's."""
    if isinstance(model, sym.CallbackPage) and model.kind == sym.CallbackKind.client:
        model = next(iter(answered_on(model)), None)
    if isinstance(model, sym.CallbackPage):
        return str(model.id), ""
    if isinstance(model, sym.ClientPort) and model.channel is not None and model.client:
        return str(model.channel.id), model.client
    return None
