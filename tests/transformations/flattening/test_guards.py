"""Guards in flattened nets, compared with an interpreter that gives every token its data."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, flow, node_net, place, read, step
from dineros.metamodel.calls import UNLIMITED
from dineros.metamodel.elements import find, places, transitions
from dineros.metamodel.errors import GuardError
from dineros.transformations.flattening.flatten import flatten
from tests.support.references.guards import (
    GUARDS,
    Choice,
    Rules,
    Topic,
    interpreted,
    modelled,
    unfolded,
    without_guards,
)
from tests.support.references.messages import ALL, Data


def _choice(takes: tuple[int, ...] | None, puts: tuple[int, ...] | None) -> st.SearchStrategy[Choice]:
    some = st.lists(st.integers(0, 3), min_size=1, max_size=2, unique=True).map(tuple)
    return st.builds(
        Choice,
        takes=some if takes is None else st.just(takes),
        puts=st.lists(st.integers(0, 3), max_size=1).map(tuple) if puts is None else st.just(puts),
        reads=st.none() | st.integers(0, 3),
        guard=st.none() | st.integers(0, len(GUARDS) - 1),
        ok=st.none() | st.booleans(),
        copied=st.booleans(),
    )


def _chosen() -> st.SearchStrategy[list[Choice]]:
    """Return transitions from each place to the next, so that data matters later, and a few others."""
    chain = st.tuples(*(_choice((number,), (number + 1,)) for number in range(3)))
    return st.builds(lambda one, two: [*one, *two], chain, st.lists(_choice(None, None), max_size=1))


def _topics(*limits: int) -> st.SearchStrategy[Topic]:
    """Return topics whose queues have one of the limits; their first reader is the second place."""
    some = st.sampled_from(limits)
    sends = st.tuples(st.booleans(), st.none() | st.integers(0, 2))
    return st.builds(
        Topic,
        messages=st.integers(1, 3),
        sends=st.lists(sends, min_size=1, max_size=2, unique=True).map(tuple),
        limit=some,
        readers=st.one_of(
            st.tuples(st.tuples(st.just(1), some)),
            st.tuples(st.tuples(st.just(1), some), st.tuples(st.just(3), some)),
        ),
    )


def _agree(model: sym.SystemModel, meanings: dict[str, Rules], most: int = 3_000) -> int:
    """Compare a model's net with the interpreter; return how many markings there are, 0: too many."""
    expected = interpreted(model, meanings, most)
    if expected is None:
        return 0
    assert unfolded(flatten(model), flatten(without_guards(model))) == expected
    return len(expected)


@settings(max_examples=40, deadline=None)
@given(_chosen(), st.lists(st.sampled_from(ALL), min_size=1, max_size=2))
def test_the_net_does_what_tokens_with_data_do(chosen: list[Choice], data: list[Data]) -> None:
    _agree(*modelled(chosen, data))


@settings(max_examples=40, deadline=None)
@given(_chosen(), _topics(1, 2))
def test_what_a_publisher_assigns_arrives(chosen: list[Choice], topic: Topic) -> None:
    _agree(*modelled(chosen, [ALL[0]], topic=topic), most=6_000)


def test_a_copy_of_a_field_that_is_only_read() -> None:
    copies = Choice((0,), (1,), 2, None, None, copied=True)
    asks = Choice((1,), (3,), None, 5, None, copied=False)
    model, meanings = modelled([copies, asks], [ALL[0]])
    read_place = find(model, "P2", sym.Place)
    read_place.tokens = 1
    found = unfolded(flatten(model), flatten(without_guards(model)))
    assert found == interpreted(model, meanings)
    assert all("T1" not in enabled for _, enabled in found)  # P2 has the level LOW, so has the copy


def test_priorities_hold_for_all_variants() -> None:
    """A transition that another one overrides waits while any variant of that is enabled."""
    asks = Choice((0,), (1,), None, 3, None, copied=False)
    other = Choice((0,), (2,), None, None, None, copied=False)
    model, _ = modelled([asks, other], [(ok, level) for ok in (False, True) for level in (0, 1)])
    find(model, "T0", sym.Transition).overrides.append(find(model, "T1", sym.Transition))
    flattened = flatten(model)
    by_name: dict[str, list[pn.Transition]] = {}
    for link in flattened.trace:
        if isinstance(link.target, pn.Transition):
            by_name.setdefault(link.sources[0].id, []).append(link.target)  # type: ignore[attr-defined]
    assert len(by_name["T1"]) == 4  # two classes of `level`, two of `ok`
    for each in by_name["T0"]:
        assert set(each.overrides) == set(by_name["T1"])
    for each in by_name["T1"]:
        assert not each.overrides


def test_limits_are_shared_by_all_values() -> None:
    """A queue of depth 1 loses a second message, whatever its values: the colours share its capacity."""
    guarded = Choice((1,), (2,), None, 0, None, copied=False)
    other = Choice((1,), (3,), None, 1, None, copied=False)
    model, _ = modelled([guarded, other], [ALL[0]], topic=Topic(1, ((None, None),), 1, ((1, 1),)))
    net = flatten(model).net
    bare = flatten(without_guards(model)).net
    own = {each.id: each.tokens for each in places(bare)}
    assert own.items() <= {each.id: each.tokens for each in places(net)}.items()
    assert len(places(net)) == len(own) + 2 * len(("Out", "writer.In", "writer.Load", "In", "Load", "P1"))


def test_a_hint_names_a_place_as_guards_do() -> None:
    model, _ = modelled([], [ALL[0]])
    node = model.pages[0]
    made = step(node, "Both", [place(node, "a"), place(node, 'say "b".c')], [])
    made.guard = "ok = true and level = 1"
    find(model, "a", sym.Place).id = "in.a"
    with pytest.raises(GuardError, match="several places have 'ok'") as error:
        flatten(model)
    hint = str(error.value.hint)
    assert hint == 'write "in.a".ok'
    made.guard = hint.removeprefix("write ") + ' = true and "say \\"b\\".c".level = 1'
    flatten(model)


def test_too_many_variants_are_refused() -> None:
    token = sym.TokenType(
        id="Token",
        fields=[sym.TokenField(name=name, kind="integer", ros="uint8") for name in ("one", "two", "three")],
    )
    model = sym.SystemModel(id="m", tokenType=token)
    node = node_net(model, "node")
    before, after = place(node, "Before", tokens=1), place(node, "After")
    step(node, "Make", [before], [after])
    for number in range(6):
        asked = " and ".join(f"{name} > {number * 7}" for name in ("one", "two", "three"))
        step(node, f"Ask{number}", [after], [before]).guard = asked
    odd = [" or ".join(f"{name} = {number}" for number in range(9, 140, 2)) for name in ("one", "two")]
    step(node, "Same", [after], [before]).guard = f"({odd[0]}) and ({odd[1]})"
    with pytest.raises(GuardError, match="more than"):
        flatten(model)


def test_variants_of_one_transition_are_refused_before_any_is_left_out() -> None:
    """Only one of 40 000 variants can fire, and it is not among the first ones."""
    token = sym.TokenType(id="Token", fields=[sym.TokenField(name="n", kind="integer", ros="uint8")])
    model = sym.SystemModel(id="m", tokenType=token)
    node = node_net(model, "node")
    one, two = place(node, "One", tokens=1), place(node, "Two", tokens=1)
    for each in (one, two):
        each.balloons.append(sym.BalloonToken(data='{"n": 199}'))
        asked = " or ".join(f"{each.id}.n = {number}" for number in range(200))
        step(node, f"Ask{each.id}", [each], []).guard = asked
    step(node, "Both", [one, two], [])
    with pytest.raises(GuardError, match="more than 20000") as error:
        flatten(model)
    assert error.value.element == "Both"


def test_models_with_guards_are_refused_where_guards_would_be_ignored() -> None:
    from dineros.analysis.latencies.answers import Latencies
    from dineros.analysis.model.subject import subject_of
    from dineros.transformations.flattening.split import split

    sends = Topic(1, ((None, None),), 1, ((1, 1),))
    model, _ = modelled([Choice((0,), (1,), None, 0, None, copied=False)], [ALL[0]], topic=sends)
    part = next(each for each in split(model) if each.node.id == "node")
    refusing: list[Callable[[], object]] = [
        lambda: subject_of(part),
        lambda: Latencies(model, Budget()),
    ]
    for refuse in refusing:
        with pytest.raises(GuardError, match="does not support") as error:
            refuse()
        assert error.value.element == "T0"


def _served(execution: str, timeout: float | None) -> tuple[sym.SystemModel, dict[str, Rules]]:
    """Return a service of two instances, with guards on its page and at one of its two clients."""
    model, _ = modelled([], [ALL[0]])
    client = model.pages[0]
    server = node_net(model, "server", execution=execution)
    ask, got, late = place(client, "Ask"), place(client, "Got"), place(client, "Late")
    step(client, "First", [find(model, "P0", sym.Place)], [ask])
    meanings = {}
    for number, guard in enumerate((0, 4)):
        made = step(client, f"Take{number}", [got], [find(model, f"P{number + 1}", sym.Place)])
        made.guard = GUARDS[guard].text.format("Got")
        meanings[made.id] = Rules({"Got": GUARDS[guard].holds}, {}, {})
    page = callback(server, "Serve", "server")
    entry, exit_, kept = place(page, "Entry"), place(page, "Exit"), place(page, "Kept")
    keep = step(page, "Keep", [entry], [kept])
    keep.guard, keep.assigns = "level >= 1", "Kept.level := Entry.level"
    meanings["Keep"] = Rules({"Entry": lambda data: data[1] >= 1}, {}, {"Kept": "Entry"})
    for number, guard in enumerate((1, 5)):
        made = step(page, f"Answer{number}", [kept], [exit_])
        made.guard = GUARDS[guard].text.format("Kept")
        meanings[made.id] = Rules({"Kept": GUARDS[guard].holds}, {}, {})
    step(page, "Low", [entry], [exit_]).guard = "Entry.level = 'LOW'"
    meanings["Low"] = Rules({"Entry": lambda data: data[1] == 0}, {}, {})
    other = node_net(model, "other")
    clients = [
        sym.ClientPort(client="c", request=ask, response=got),
        sym.ClientPort(client="d", request=place(other, "Ask2", 1), response=place(other, "Got2")),
    ]
    if timeout is not None:
        clients[0].timeout, clients[0].timedOut = timeout, late
    model.channels.append(
        sym.ServiceChannel(
            id="s",
            service="/s",
            instances=2,
            server=sym.ServerPort(page=page, entry=entry, exit=exit_),
            clients=clients,
        )
    )
    return model, meanings


@pytest.mark.parametrize("execution", ["net", "callbacks"])
@pytest.mark.parametrize("timeout", [None, 1.0])
def test_server_instances_have_tokens_of_their_own(execution: str, timeout: float | None) -> None:
    model, meanings = _served(execution, timeout)
    assert _agree(model, meanings, 100_000) > 100


def test_no_value_is_owed_to_a_fair_run() -> None:
    """Fairness to a transition says nothing about values: that would prove that each comes sometime."""
    from dineros.analysis.logic.language.errors import FormulaError
    from dineros.analysis.model.fairness import fair_transitions, unfairness
    from dineros.analysis.model.subject import base_subject

    again = Choice((0,), (0,), None, None, None, copied=False)
    leave = Choice((0,), (1,), None, 0, None, copied=False)
    model, _ = modelled([again, leave], [ALL[0]])
    subject = base_subject(model)
    for word in ("T0", "all", "node:node", subject.net.transitions[0]):
        with pytest.raises(FormulaError, match="guards distinguish its tokens"):
            fair_transitions(subject, [word])
    (loop,) = (
        t
        for t, name in enumerate(subject.net.transitions)
        if name.startswith("T0") and name.count("ok=false") == 1 and "ok=true" not in name
    )
    found = unfairness(subject, [], [loop])
    assert not found.weakly and not found.strongly


def sends_in_order(limit: int) -> tuple[sym.SystemModel, pn.Place, pn.Place]:
    """Return a node that sends true, then false; places of a subscriber that takes them in order, or not."""
    model, _ = modelled([], [ALL[0]], topic=Topic(1, ((True, None),), limit, ((1, limit),)))
    sender = find(model, "sender", sym.NodeNet)
    sent, out = place(sender, "Sent"), find(model, "Out", sym.Place)
    find(model, "Send0", sym.Transition).assigns = "Out.ok := true"
    flow(find(model, "Send0", sym.Transition), sent)
    step(sender, "Send1", [sent], [out]).assigns = "Out.ok := false"
    node = find(model, "node", sym.NodeNet)
    got = find(model, "P1", sym.Place)
    first, after, wrong = place(node, "First"), place(node, "After"), place(node, "Wrong")
    step(node, "Go", [got], [first]).guard = "P1.ok = true"
    step(node, "Stop", [got, first], [after]).guard = "P1.ok = false"
    late = step(node, "LateGo", [got], [wrong])
    late.guard = "P1.ok = true"
    read(place(node, "Stopped"), late)
    stop = step(node, "StopFirst", [got], [find(model, "Stopped", sym.Place)])
    stop.guard = "P1.ok = false"
    return model, after, wrong


def test_messages_of_a_type_that_exists_have_any_value() -> None:
    """The type may lack the field; and programs outside of the model may publish."""

    own, _, _ = sends_in_order(2)
    foreign, _, _ = sends_in_order(2)
    (topic,) = (each for each in foreign.channels if isinstance(each, sym.TopicChannel))
    topic.type = "std_msgs/msg/String"
    assert len(_marked(foreign)) > len(_marked(own))


def _marked(model: sym.SystemModel) -> list[dict[str, int]]:
    """Return the markings of a model's net."""
    markings = unfolded(flatten(model), flatten(without_guards(model)))
    return [dict(marking) for marking, _ in markings]  # type: ignore[call-overload]


@pytest.mark.parametrize("limit", [1, 2, 3, 10])
def test_messages_of_a_topic_keep_their_order(limit: int) -> None:
    """A subscriber may miss the first message, but never gets it after the second one."""
    model, after, wrong = sends_in_order(limit)
    marked = _marked(model)
    assert any(each[after.id] for each in marked)
    assert any(each["Stopped"] for each in marked)
    assert not any(each[wrong.id] for each in marked)


@pytest.mark.parametrize("listens", [False, True])
def test_goals_feedback_and_results_carry_values(listens: bool) -> None:
    model, _ = modelled([], [ALL[0], ALL[4]])
    client = model.pages[0]
    server = node_net(model, "server")
    goal, told, over = place(client, "Goal"), place(client, "Told"), place(client, "Over")
    step(client, "Ask", [find(model, "P0", sym.Place)], [goal]).assigns = "Goal.level := P0.level"
    meanings = {"Ask": Rules({}, {}, {"Goal": "P0"})}
    for number, guard in enumerate((0, 4)):
        for asked in (told, over):
            made = step(
                client, f"Take{asked.id}{number}", [asked], [find(model, f"P{number + 1}", sym.Place)]
            )
            made.guard = GUARDS[guard].text.format(asked.id)
            meanings[made.id] = Rules({asked.id: GUARDS[guard].holds}, {}, {})
    page = callback(server, "Work", "server")
    entry, busy, says, done = (place(page, name) for name in ("Entry", "Busy", "Says", "Done"))
    begin = step(page, "Begin", [entry], [busy, says])
    begin.guard, begin.assigns = "level <> 2", "Says.level := Entry.level, Busy.level := 0"
    meanings["Begin"] = Rules({"Entry": lambda data: data[1] != 2}, {}, {"Says": "Entry"}, {"Busy": 0})
    end = step(page, "End", [busy], [done])
    end.assigns = "Done.level := Busy.level, Done.ok := true"
    meanings["End"] = Rules({}, {"Done": True}, {"Done": "Busy"})
    client_port = sym.ActionClientPort(client="c", goal=goal, succeeded=over)
    if listens:
        client_port.feedback = told
    model.channels.append(
        sym.ActionChannel(
            id="a",
            action="/a",
            depth=2,
            instances=1,
            server=sym.ActionServerPort(page=page, entry=entry, feedback=says, succeeded=done),
            clients=[client_port],
        )
    )
    assert _agree(model, meanings, 30_000) > 20


@pytest.mark.parametrize("takes", [False, True])
def test_histories_of_clients_that_do_not_wait_lose_any_of_their_requests(takes: bool) -> None:
    """Two requests at a history of one: which of them is lost is open, and so it is with responses."""
    model, _ = modelled([], [ALL[0], ALL[5]])
    client = model.pages[0]
    server = node_net(model, "server")
    ask, got = place(client, "Ask"), place(client, "Got")
    step(client, "First", [find(model, "P0", sym.Place)], [ask]).assigns = "Ask.level := P0.level"
    meanings = {"First": Rules({}, {}, {"Ask": "P0"})}
    for number, guard in enumerate((2, 5)):
        made = step(client, f"Take{number}", [got], [find(model, f"P{number + 1}", sym.Place)])
        made.guard = GUARDS[guard].text.format("Got")
        meanings[made.id] = Rules({"Got": GUARDS[guard].holds}, {}, {})
    if takes:
        step(client, "Rest", [got], [])
    page = callback(server, "Serve", "server")
    entry, exit_ = place(page, "Entry"), place(page, "Exit")
    step(page, "Answer", [entry], [exit_]).assigns = "Exit.level := Entry.level"
    meanings["Answer"] = Rules({}, {}, {"Exit": "Entry"})
    port = sym.ClientPort(client="c", request=ask, response=got, outstanding=UNLIMITED)
    model.channels.append(
        sym.ServiceChannel(
            id="s",
            service="/s",
            instances=1,
            depth=1,
            server=sym.ServerPort(page=page, entry=entry, exit=exit_),
            clients=[port],
        )
    )
    assert _agree(model, meanings, 30_000) > 30


def test_only_values_that_occur_and_differ_are_told_apart() -> None:
    """A publisher that always says true needs no variants; a field that no guard asks about makes none."""
    asks = [Choice((1,), (2,), None, guard, None, copied=False) for guard in (0, 1)]
    sizes = []
    for sends in (((True, None),), ((True, None), (False, None)), ((None, 0), (None, 1))):
        model, _ = modelled(asks, [ALL[0]], topic=Topic(2, sends, 3, ((1, 3),)))
        net = flatten(model).net
        names = [each.id for each in transitions(net)]
        sizes.append(sum(name.startswith("c.reader.P1.in") for name in names))
        assert not any("level" in each.id for each in places(net))
        assert sum(name.startswith("T1") for name in names) == 1
    assert sizes == [1, 6, 6]  # a queue of three has three cells for each of two values


def test_a_queue_of_any_limit_makes_a_small_net() -> None:
    """The order of a very long queue is left open: it would need a cell for each message."""
    model, after, wrong = sends_in_order(1_000_000_000)
    net = flatten(model).net
    assert len(places(net)) < 60
    marked = _marked(model)
    assert any(each[after.id] for each in marked) and any(each[wrong.id] for each in marked)
