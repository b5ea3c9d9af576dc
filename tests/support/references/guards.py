"""Models with guards, and an interpreter that gives every token its data, to compare flattened nets with."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from itertools import combinations, product
from typing import NamedTuple

from dineros.metamodel import pn, pnm, sym
from dineros.metamodel.build import node_net, place, read, step
from dineros.metamodel.elements import arcs, find, places, transitions
from dineros.transformations.flattening.flatten import Flattened, flatten
from tests.support.references.messages import ALL, Data, State, frozen, handed, is_message

MOST_STATES = 3_000


class Guard(NamedTuple):
    """A guard of one token: its text for a place, and what it means."""

    text: str
    holds: Callable[[Data], bool]


GUARDS = (
    Guard("{0}.ok = true", lambda data: data[0]),
    Guard("{0}.ok <> TRUE", lambda data: not data[0]),
    Guard("{0}.level = 'LOW'", lambda data: data[1] == 0),
    Guard("{0}.level >= 1 and not {0}.ok = false", lambda data: data[1] >= 1 and data[0]),
    Guard("({0}.level between 1 and 2 or {0}.ok = true)", lambda data: data[1] >= 1 or data[0]),
    Guard("{0}.level NOT BETWEEN 0 AND 1", lambda data: data[1] == 2),
    Guard("{0}.ok = false or {0}.level <> {0}.level", lambda data: not data[0]),
)


class Choice(NamedTuple):
    """What a transition asks of a token that it takes or reads, and what it assigns on its first place."""

    takes: tuple[int, ...]
    puts: tuple[int, ...]
    reads: int | None
    guard: int | None
    ok: bool | None
    copied: bool


class Rules(NamedTuple):
    """The same as the interpreter reads it: by id of a place the guard; what is assigned on a place."""

    guard: dict[str, Callable[[Data], bool]]
    ok: dict[str, bool]
    copied: dict[str, str]
    level: Mapping[str, int] = {}


class Topic(NamedTuple):
    """A topic: how often a node sends, what it may assign, and limits of its queue and of its readers."""

    messages: int
    sends: tuple[tuple[bool | None, int | None], ...]
    limit: int
    readers: tuple[tuple[int, int], ...]


def modelled(
    choices: list[Choice], data: list[Data], *, topic: Topic | None = None
) -> tuple[sym.SystemModel, dict[str, Rules]]:
    """Return a model whose first place has tokens, and what its guards mean."""
    token = sym.TokenType(
        id="Token",
        fields=[
            sym.TokenField(name="ok", kind="boolean"),
            sym.TokenField(name="level", kind="integer", values="LOW=0, MIDDLE=1, HIGH=2"),
        ],
    )
    model = sym.SystemModel(id="m", tokenType=token, middleware="ros2")
    node = node_net(model, "node")
    own = [place(node, f"P{number}") for number in range(4)]
    own[0].tokens = len(data)
    for ok, level in data:
        own[0].balloons.append(sym.BalloonToken(data=f'{{"ok": {str(ok).lower()}, "level": {level}}}'))
    meanings = {}
    for number, choice in enumerate(choices):
        puts = [own[each] for each in choice.puts]
        made = step(node, f"T{number}", [own[each] for each in choice.takes], puts)
        asked = own[choice.takes[0]]
        if choice.reads is not None and choice.reads not in choice.takes:
            asked = own[choice.reads]
            read(asked, made)
        rules = Rules({}, {}, {})
        if choice.guard is not None:
            made.guard = GUARDS[choice.guard].text.format(asked.id)
            rules.guard[asked.id] = GUARDS[choice.guard].holds
        if puts and choice.ok is not None:
            made.assigns = f"{puts[0].id}.ok := {str(choice.ok).lower()}"
            rules.ok[puts[0].id] = choice.ok
        elif puts and choice.copied:
            made.assigns = f"{puts[0].id}.level := {asked.id}.level"
            rules.copied[puts[0].id] = asked.id
        meanings[made.id] = rules
    if topic is not None:
        sender = node_net(model, "sender")
        out = place(sender, "Out")
        left = place(sender, "Left", tokens=topic.messages)
        for number, sent in enumerate(topic.sends):
            made = step(sender, f"Send{number}", [left], [out])
            assigned = [] if sent[0] is None else [f"ok := {str(sent[0]).lower()}"]
            assigned += [] if sent[1] is None else [f"Out.level := {sent[1]}"]
            made.assigns = ", ".join(assigned) or None
            meanings[made.id] = Rules(
                {},
                {} if sent[0] is None else {"Out": sent[0]},
                {},
                {} if sent[1] is None else {"Out": sent[1]},
            )
        ports = [sym.SubscriberPort(place=own[number], limit=limit) for number, limit in topic.readers]
        model.channels.append(
            sym.TopicChannel(
                id="c",
                topic="/c",
                publishers=[sym.PublisherPort(place=out, limit=topic.limit)],
                subscribers=ports,
            )
        )
    return model, meanings


def interpreted(
    model: sym.SystemModel, meanings: dict[str, Rules], most: int = MOST_STATES
) -> set[tuple[object, frozenset[str]]] | None:
    """Return the markings that can be reached, each with what is enabled; None: too many.

    It fires the net that has no guards, with data for each token of a place of the model; others carry none.
    """
    bare = flatten(without_guards(model))
    names: dict[str, str] = {}
    for link in bare.trace:
        if link.maker is None:
            names[link.target.id] = link.sources[0].id  # type: ignore[attr-defined]
    ids = {each.id for each in places(model)}
    own = {each.id for each in places(bare.net) if names.get(each.id) in ids or is_message(each.id)}
    start = {each.id: ((False, 0),) * each.tokens for each in places(bare.net)}
    first = find(model, "P0", sym.Place)
    if first.balloons:
        start["P0"] = tuple(sorted(_read(each.data) for each in first.balloons))
    moves = [(each.id, _sides(each, bare.net)) for each in transitions(bare.net)]
    todo, seen = [frozen(start)], {frozen(start)}
    found: set[tuple[object, frozenset[str]]] = set()
    while todo:
        state = dict(todo.pop())
        enabled: set[str] = set()
        for id, (takes, reads, puts, inhibits) in moves:
            if any(len(state[p]) >= n for p, n in inhibits.items()):
                continue
            rules = meanings.get(names.get(id, id), Rules({}, {}, {}))
            if id in names:
                fired = _fired(state, takes, reads, puts, rules, own, names)
            else:
                fired = handed(id, state, takes, reads, puts, own)
            for after in fired:
                enabled.add(names.get(id, id))
                if after not in seen:
                    if len(seen) > most:
                        return None
                    seen.add(after)
                    todo.append(after)
        found.add((_counted({p: len(tokens) for p, tokens in state.items()}), frozenset(enabled)))
    return found


def data_states(model: sym.SystemModel, meanings: dict[str, Rules]) -> dict[State, set[str]]:
    """Return what the tokens of a model of one node can carry, each with what is enabled then."""
    bare = flatten(without_guards(model)).net
    own = {each.id for each in places(bare)}
    moves = [(each.id, _sides(each, bare)) for each in transitions(bare)]
    start = {each.id: ((False, 0),) * each.tokens for each in places(bare)}
    first = find(model, "P0", sym.Place)
    if first.balloons:
        start["P0"] = tuple(sorted(_read(each.data) for each in first.balloons))
    found: dict[State, set[str]] = {}
    todo = [frozen(start)]
    while todo:
        state = todo.pop()
        if state in found:
            continue
        found[state] = set()
        for id, (takes, reads, puts, _) in moves:
            for after in _fired(dict(state), takes, reads, puts, meanings[id], own, {p: p for p in own}):
                found[state].add(id)
                todo.append(after)
    return found


def _fired(
    state: dict[str, tuple[Data, ...]],
    takes: Counter[str],
    reads: Counter[str],
    puts: Counter[str],
    rules: Rules,
    own: set[str],
    names: dict[str, str],
) -> Iterator[State]:
    for count in (takes, reads):
        if any(len(state[p]) < n for p, n in count.items()):
            return
    # A read arc and a normal arc of one place together need the sum; these models have none.
    chosen = [set(combinations(state[p], n)) for p, n in (takes + reads).items()]
    for tokens in product(*chosen):
        seen = dict(zip(takes + reads, tokens, strict=True))
        there = {names.get(p, p): data for p, data in seen.items()}
        if not all(holds(there[p][0]) for p, holds in rules.guard.items()):
            continue
        made = []
        for p, n in puts.items():
            values = [
                data
                for data in (ALL if p in own else [(False, 0)])
                if (names.get(p) not in rules.ok or data[0] == rules.ok[names[p]])
                and (names.get(p) not in rules.level or data[1] == rules.level[names[p]])
                and (names.get(p) not in rules.copied or data[1] == there[rules.copied[names[p]]][0][1])
            ]
            made.append([(p, each) for each in product(values, repeat=n)])
        for new in product(*made):
            after = {p: list(each) for p, each in state.items()}
            for p in takes:
                for data in seen[p]:
                    after[p].remove(data)
            for p, each in new:
                after[p].extend(each)
            yield frozen({p: tuple(each) for p, each in after.items()})


def _sides(transition: pn.Transition, net: pnm.PetriNetModel) -> tuple[Counter[str], ...]:
    """Return what a transition takes, reads, puts and is inhibited by."""
    return tuple(_side(transition, net, kind) for kind in ("takes", "reads", "puts", "inhibits"))


def _side(transition: pn.Transition, net: pnm.PetriNetModel, kind: str) -> Counter[str]:
    found: Counter[str] = Counter()
    kinds = {"takes": "normal", "reads": "read", "inhibits": "inhibitor"}
    for arc in arcs(net):
        if kind == "puts" and arc.source is transition:
            found[arc.target.id] += arc.weight
        elif kind != "puts" and arc.target is transition and str(arc.kind) == kinds[kind]:
            found[arc.source.id] += arc.weight
    return found


def _read(text: str) -> Data:
    return "true" in text, int(text.rstrip("}")[-1])


def _counted(marking: dict[str, int]) -> tuple[tuple[str, int], ...]:
    return tuple(sorted(marking.items()))


def without_guards(model: sym.SystemModel) -> sym.SystemModel:
    from dineros.transformations.language.copying import deep_copy

    copied, _ = deep_copy(model)
    assert isinstance(copied, sym.SystemModel)
    for each in transitions(copied):
        assert isinstance(each, sym.Transition)
        each.guard = each.assigns = None
    return copied


def unfolded(flattened: Flattened, bare: Flattened) -> set[tuple[object, frozenset[str]]]:
    """Return the markings of the net's own places that can be reached, each with what is enabled.

    Variants of a transition have the name that it has in the net without guards.
    """
    known = {each.id for each in transitions(bare.net)}
    links = {link.target: link for link in flattened.trace}
    colours = {each.id for each in places(flattened.net) if links[each].rule == "Guard"}
    moves = []
    for each in transitions(flattened.net):
        link = links[each]
        if link.maker is None:
            name = link.sources[0].id  # type: ignore[attr-defined]
        else:
            name = max((id for id in known if each.id == id or each.id.startswith(f"{id}[")), key=len)
        moves.append((name, _sides(each, flattened.net)))
    start = _counted({each.id: each.tokens for each in places(flattened.net)})
    todo, seen = [start], {start}
    found: set[tuple[object, frozenset[str]]] = set()
    while todo:
        marking = dict(todo.pop())
        enabled: set[str] = set()
        for name, (takes, reads, puts, inhibits) in moves:
            if any(marking[p] < n for p, n in (takes + reads).items()):
                continue
            if any(marking[p] >= n for p, n in inhibits.items()):
                continue
            enabled.add(name)
            after = Counter(marking)
            after.subtract(takes)
            after.update(puts)
            key = _counted(dict(after))
            if key not in seen:
                seen.add(key)
                todo.append(key)
        own = {p: n for p, n in marking.items() if p not in colours}
        found.add((_counted(own), frozenset(enabled)))
    return found
