"""Changes of callback groups and threads: what they are in words and as settings, and what each may fix."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

from dineros.analysis.callbacks.circles import Circle, Waiter
from dineros.analysis.callbacks.waiting import Callback, Marking
from dineros.analysis.model.channels import channel_words
from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.callbacks.groups import (
    answered_on,
    begins_answer,
    begins_callback,
    callback_page_of,
    group_or_node,
    holds_thread,
    members_of,
    threads_of,
    works_on_goals,
)
from dineros.metamodel.calls import answers
from dineros.metamodel.elements import elements, find, node_net_of
from dineros.metamodel.settings import apply
from dineros.transformations.language.copying import deep_copy

Owner = tuple[str, str]
"""Id of a callback page and no text; or id of a service or an action, and the client."""


@dataclass(frozen=True)
class Changes:
    """What is changed in a model."""

    own: frozenset[Owner] = frozenset()
    """Callback pages and clients that get a group of their own."""
    reentrant: frozenset[Owner] = frozenset()
    """Those whose own group is reentrant; and callback groups, by their id, that become so."""
    threads: tuple[tuple[str, int], ...] = ()
    """Number of further threads of node nets, by their id; negative for fewer."""
    awaiting: frozenset[str] = frozenset()
    """Callback pages, by their id, that become `async def` and await."""
    shared: frozenset[frozenset[Owner]] = frozenset()
    """Callbacks that share one new exclusive group."""

    @property
    def cost(self) -> tuple[int, int, int, int, int]:
        """How many changes there are, those that reduce concurrency counted twice.

        Of as many, those come last, then awaiting, reentrant groups, threads.
        """
        more = sum(number for _, number in self.threads if number > 0)
        less = sum(number < 0 for _, number in self.threads) + sum(len(each) - 1 for each in self.shared)
        count = len(self.own) + len(self.reentrant) + more + len(self.awaiting) + 2 * less
        return count, less, len(self.awaiting), len(self.reentrant), more

    def with_thread(self, node: str) -> Changes:
        """Return these changes and one more thread."""
        return self._with_threads(node, dict(self.threads).get(node, 0) + 1)

    def _with_threads(self, node: str, more: int) -> Changes:
        threads = {**dict(self.threads), node: more}
        return replace(self, threads=tuple(sorted((id, each) for id, each in threads.items() if each)))

    def with_fewer(self, node: sym.NodeNet, threads: int) -> Changes:
        """Return these changes and an executor of that many threads, for a node of the changed model."""
        return self._with_threads(str(node.id), self.more_of(node) + threads - threads_of(node))

    def more_of(self, node: sym.NodeNet) -> int:
        """Return how many more threads a node gets; negative for fewer."""
        return dict(self.threads).get(str(node.id), 0)

    def is_shared(self, owner: Owner) -> bool:
        """Return whether a callback shares its new group."""
        return any(owner in each for each in self.shared)

    def with_shared(self, one: Owner, other: Owner) -> Changes:
        """Return these changes and two callbacks in one exclusive group, with those that share it already."""
        joined = [each for each in self.shared if one in each or other in each]
        group = frozenset({one, other}).union(*joined)
        own, reentrant = self.own - group, self.reentrant - group
        return replace(self, own=own, reentrant=reentrant, shared=self.shared.difference(joined) | {group})

    def applied(self, model: sym.SystemModel) -> sym.SystemModel:
        """Return a copy of a model with these changes."""
        copied, _ = deep_copy(model)
        assert isinstance(copied, sym.SystemModel)
        for _, settings in self.steps(model):
            for setting in settings:
                apply(copied, setting)
        return copied

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
        for together in sorted(map(sorted, self.shared)):
            group = f"{'_'.join(id for id, _ in together)}_group"
            while group in taken:
                group += "_"
            whats = [_named(model, owner) for owner in together]
            settings = [
                f"{each}.group={group}"
                for owner, (name, _) in zip(together, whats, strict=True)
                for each in (name, *_with_client(model, owner))
            ]
            yield f"{_joined([what for _, what in whats])} in one callback group", tuple(settings)
        for group, _ in sorted(self.reentrant - self.own):
            yield f"callback group {group} reentrant", (f"{group}.kind=reentrant",)
        for id, more in self.threads:
            threads = threads_of(find(model, id, sym.NodeNet)) + more
            executor = "multi" if threads > 1 else "single"
            yield (
                f"{threads} thread{'s' if threads > 1 else ''} for node net {id}",
                (f"{id}.executor={executor}", f"{id}.threads={threads}"),
            )
        for page in sorted(self.awaiting):
            yield f"callback {page} as async def, which awaits at each step", (f"{page}.awaits=true",)


def _named(model: sym.SystemModel, owner: Owner) -> tuple[str, str]:
    """Return how settings name a callback page or a client, and how words do."""
    id, client = owner
    if not client:
        return id, f"callback {id}"
    what = channel_words(find(model, id, sym.Channel))
    return f"{id}.client.{client}", f"client {client} of {what}"


def _joined(whats: Sequence[str]) -> str:
    """Return callbacks in words, with "callbacks" once where nothing else is among them."""
    if all(what.startswith("callback ") for what in whats):
        *names, last = (what.removeprefix("callback ") for what in whats)
        return f"callbacks {', '.join(names)} and {last}"
    return " and ".join(whats)


def _with_client(model: sym.SystemModel, owner: Owner) -> Iterator[str]:
    """Yield the callback pages that a client's answers begin, if they are in the group of the client."""
    id, client = owner
    channel = find(model, id, sym.Channel) if client else None
    for port in getattr(channel, "clients", ()):
        if port.client == client:
            pages = dict.fromkeys(callback_page_of(place) for place in _begun_by(port))
            yield from (str(page.id) for page in pages if page is not None and page.group is not None)


def _begun_by(port: sym.ClientPort | sym.ActionClientPort) -> Iterator[pn.Place]:
    """Yield the places of a client whose answers begin a callback of their own."""
    if isinstance(port, sym.ClientPort):
        if begins_callback(port):
            yield port.response
        return
    heard = [*answers(port), *([] if port.feedback is None else [port.feedback])]
    yield from (place for place in heard if begins_answer(port, place))


def against_circle(changes: Changes, circle: Circle) -> Iterator[Changes]:
    """Yield additions to some changes that may break a circle: each solution has one of these.

    A thread that is waited for comes with one more of them; a group, if the waiting callback or the one that
    holds it leaves it, or if it becomes reentrant.
    """
    waiters = circle.waiters
    around = zip((waiters[-1], *waiters[:-1]), waiters, (*waiters[1:], waiters[0]), strict=True)
    for before, one, after in around:
        if one.kind == "thread":
            yield from _thread(changes, one)
        elif one.kind == "group":
            yield from _own(changes, (*_asking(before, one), after.model))
            yield from _reentrant(changes, one.model, after.model)


def _asking(waiter: Waiter, group: Waiter) -> Iterator[object]:
    """Yield who can leave the group in a wait for a group: a callback, a client, or its server."""
    yield waiter.model
    if isinstance(waiter.model, sym.ClientPort | sym.ActionClientPort) and waiter.model.channel is not None:
        page = waiter.model.channel.server.page
        if isinstance(page, sym.CallbackPage) and group_or_node(page) is group.model:
            yield page


def against_waiting(changes: Changes, resources: Iterable[Waiter]) -> Iterator[Changes]:
    """Yield additions to some changes that may free threads and groups that callbacks hold forever."""
    for resource in resources:
        if resource.kind == "thread":
            yield from _thread(changes, resource)
        else:
            yield from _free(changes, resource.model)


def against_unheard(changes: Changes, page: sym.CallbackPage) -> Iterator[Changes]:
    """Yield additions to some changes that may let a server receive cancel requests while it works."""
    node = node_net_of(page)
    if node is not None:
        yield changes.with_thread(str(node.id))
    if str(page.id) not in changes.awaiting:
        yield replace(changes, awaiting=changes.awaiting | {str(page.id)})
    group = group_or_node(page)
    if group is not None:
        yield from _free(changes, group)


def _thread(changes: Changes, waiter: Waiter) -> Iterator[Changes]:
    """Yield one more thread, unless the executor has fewer than in the model to prevent a run."""
    if dict(changes.threads).get(waiter.element, 0) >= 0:
        yield changes.with_thread(waiter.element)


def _free(changes: Changes, group: EObject) -> Iterator[Changes]:
    """Yield the changes after which one callback less needs a group, or it is reentrant."""
    members = members_of(group)
    yield from _own(changes, members)
    for member in members:
        yield from _reentrant(changes, group, member)


def against_run(
    changes: Changes, callbacks: Sequence[Callback], markings: Iterable[Marking]
) -> Iterator[Changes]:
    """Yield additions to some changes of which each prevents a run, as callbacks in it run at once.

    Those that may run twice at once get a group of their own. Those that ran at the same time share an
    exclusive group; or the executor has fewer threads than ran at once.
    """
    begun: dict[sym.CallbackPage, None] = {}
    together: dict[tuple[sym.CallbackPage, sym.CallbackPage], None] = {}
    threads: dict[sym.NodeNet, int] = {}
    for marking in markings:
        pages = list(dict.fromkeys(each.page for each in callbacks if each.has_begun(marking)))
        begun.update(dict.fromkeys(pages))
        together.update(
            dict.fromkeys(pair for pair in combinations(pages, 2) if len(set(map(node_net_of, pair))) == 1)
        )
        held: Counter[sym.NodeNet] = Counter()
        for each in callbacks:
            node = node_net_of(each.page)
            if node is not None and holds_thread(each.page):
                held[node] += int(marking[each.running])
        for node, number in held.items():
            threads[node] = max(threads.get(node, 0), number)
    reentrant = sym.CallbackGroupKind.reentrant
    yield from _own(
        changes, [each for each in begun if each.group is not None and each.group.kind == reentrant]
    )
    for node, number in threads.items():
        if number > 1 and changes.more_of(node) <= 0:
            yield changes.with_fewer(node, number - 1)
    for pair in together:
        one, other = map(_excluded, pair)
        if one is not None and other is not None and one != other:
            yield changes.with_shared(one, other)


def _excluded(page: sym.CallbackPage) -> Owner | None:
    """Return what can be put into an exclusive group so that the callback of a page waits for it."""
    if works_on_goals(page) or (page.kind == sym.CallbackKind.client and page.group is None):
        return None
    return _owner(page)


def _own(changes: Changes, models: Sequence[object]) -> Iterator[Changes]:
    for model in models:
        owner = _owner(model)
        if owner is not None and owner not in changes.own and not changes.is_shared(owner):
            yield replace(changes, own=changes.own | {owner})


def _reentrant(changes: Changes, group: object, holder: object) -> Iterator[Changes]:
    """Yield the group made reentrant; or that of the callback that holds it, if it has its own."""
    owner = _owner(holder)
    if owner is not None and changes.is_shared(owner):
        return
    if owner is not None and owner in changes.own:
        made = owner
    elif isinstance(group, sym.CallbackGroup):
        made = (str(group.id), "")
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
    if isinstance(model, sym.ClientPort | sym.ActionClientPort) and model.channel and model.client:
        return str(model.channel.id), model.client
    return None
