"""Where outcomes may have begun: checked on random nets by leaving out all that is not in the causal past."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from dineros.analysis.logic.language.atoms import BoundAtoms, Step
from dineros.analysis.logic.language.explanation import explanation
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.model.step_roles import step_roles
from dineros.analysis.model.subject import Subject, subject_of
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import replay
from dineros.analysis.portfolio.asking import find_firing
from dineros.analysis.walks.causal_past import CausalPast, TokenNeed
from dineros.analysis.witnesses.first_cause import Cause, blocked_cause, first_cause
from dineros.analysis.witnesses.records import witness_records
from dineros.analysis.witnesses.witness import Witness, witness_of
from dineros.metamodel import pn, sym
from dineros.metamodel.records import Drop, Header, decode_record, encode_record
from tests.analysis.strategies import nets
from tests.support.systems.talker import talker

MANY = settings(
    max_examples=20,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)


@st.composite
def runs(draw: st.DrawFn, longest: int = 14) -> tuple[CompiledNet, list[int]]:
    """Draw a net and a firing sequence of it."""
    net = draw(nets())
    marking, sequence = net.initial.tolist(), []
    for _ in range(draw(st.integers(1, longest))):
        enabled = [t for t in range(len(net.transitions)) if net.is_enabled(t, marking)]
        if not enabled or max(marking) > 30:
            break
        sequence.append(draw(st.sampled_from(enabled)))
        marking = net.fire(sequence[-1], marking)
    return net, sequence


def witness(net: CompiledNet, sequence: list[int], loop: int | None = None) -> Witness:
    return witness_of(Subject(pn.Net(id="n"), net), sequence, loop)


def rest(sequence: list[int], cause: Cause) -> list[int]:
    return [sequence[step - 1] for step in cause.steps]


@MANY
@given(runs(), st.data())
def test_the_causal_past_can_be_fired_alone_and_has_what_was_needed(
    run: tuple[CompiledNet, list[int]], data: st.DataObject
) -> None:
    net, sequence = run
    markings = replay(net, sequence)
    needs = []
    for _ in range(data.draw(st.integers(1, 3))):
        position = data.draw(st.integers(0, len(sequence)))
        place = data.draw(st.integers(0, len(net.places) - 1))
        bound = data.draw(st.sampled_from(["at least", "at most"]))
        tokens = data.draw(st.none() | st.integers(0, markings[position][place]))
        needs.append(TokenNeed(place, position, bound, tokens))  # type: ignore[arg-type]
    firings = data.draw(st.sets(st.integers(0, len(sequence) - 1), max_size=2)) if sequence else set()
    past = CausalPast(net, sequence).of(needs, firings)
    assert firings <= set(past)
    alone = replay(net, [sequence[firing] for firing in past])  # refuses what is not enabled
    for need in needs:
        there = alone[sum(firing < need.position for firing in past)][need.place]
        was = markings[need.position][need.place]
        if need.bound == "at most":
            assert there <= was
        else:
            assert there >= (was if need.tokens is None else need.tokens)


@pytest.mark.parametrize("order", [1, -1])
def test_who_takes_what_is_made_for_something_else_is_needed(order: int) -> None:
    net = CompiledNet.build(
        {"start": 1, "waste": 0, "product": 0},
        [("make", {"start": 1}, {"waste": 1, "product": 1}), ("clean", {"waste": 1}, {})],
    )
    needs = [TokenNeed(1, 2, "at most"), TokenNeed(2, 2, "at least")]
    past = CausalPast(net, [0, 1])
    assert past.of(needs[::order]) == [0, 1]
    assert past.of(needs[1:]) == [0]


CONDITIONS = ["p0 >= 2", "p0 == 1", "p0 != 0", "p0 <= 1", "2*p0 - p0 > 0", "enabled(t0)", "!enabled(t0)",
              "!enabled(t0) & p0 < 2", "p0 > 0 | enabled(t0)", "!deadlock", "deadlock"]  # fmt: skip


@MANY
@given(runs(), st.sampled_from(CONDITIONS))
def test_a_marking_that_was_looked_for_is_still_reached(
    run: tuple[CompiledNet, list[int]], asked: str
) -> None:
    net, sequence = run
    condition = parse(asked, "state")
    bound = BoundAtoms(net, condition, NetNames(net))

    def holds(marking: list[int]) -> bool:
        return holds_on_lasso(condition, [], [Step(tuple(marking), None)], bound.is_true)

    markings = replay(net, sequence)
    assume(sequence and holds(markings[-1]) and asked != "enabled(t0)")
    cause = first_cause(witness(net, sequence), asked, "reachable")
    assert cause is not None
    assert holds(replay(net, rest(sequence, cause))[-1])
    for text, (since, until) in cause.decided.items():
        literal = parse(text, "state")
        atoms = BoundAtoms(net, literal, NetNames(net))
        values = [
            holds_on_lasso(literal, [], [Step(tuple(marking), None)], atoms.is_true) for marking in markings
        ]
        assert until == len(sequence)
        assert all(values[since:])
        assert since == 0 or not values[since - 1]
    sinces = [since for since, _ in cause.decided.values() if since]
    assert cause.first == min(sinces, default=0)


@pytest.mark.long
@MANY
@given(runs())
def test_a_deadlock_stays_one(run: tuple[CompiledNet, list[int]]) -> None:
    net, sequence = run
    final = replay(net, sequence)[-1]
    assume(sequence and not any(net.is_enabled(t, final) for t in range(len(net.transitions))))
    cause = first_cause(witness(net, sequence), "one marking has no enabled transition", "deadlock")
    assert cause is not None
    marking = replay(net, rest(sequence, cause))[-1]
    assert not any(net.is_enabled(t, marking) for t in range(len(net.transitions)))
    assert cause.first in (0, *cause.steps)


@MANY
@given(runs())
def test_the_last_firing_comes_last(run: tuple[CompiledNet, list[int]]) -> None:
    net, sequence = run
    final = replay(net, sequence)[-1]
    assume(sequence and any(net.is_enabled(t, final) for t in range(len(net.transitions))))
    cause = first_cause(witness(net, sequence), "a queue can overflow", "queue-overflow")
    if cause is None:  # it needs nothing
        assert not net.pre.row(sequence[-1])
        assert not net.inhibitor.row(sequence[-1])
        return
    assert cause.steps[-1] == len(sequence)
    replay(net, rest(sequence, cause))


@MANY
@given(runs())
def test_what_is_blocked_stays_so(run: tuple[CompiledNet, list[int]]) -> None:
    net, sequence = run
    final = replay(net, sequence)[-1]
    assume(sequence and not net.is_enabled(0, final))
    cause = blocked_cause(witness(net, sequence), "t0")
    assert cause is not None
    assert not net.is_enabled(0, replay(net, rest(sequence, cause))[-1])
    assert blocked_cause(witness(net, sequence), "not there") is None


FORMULAS = [
    "G (p0 >= 1 -> F p0 == 0)",
    "F p0 >= 3",
    "G F fired(t0)",
    "F G p0 <= 1",
    "(p0 <= 1) U enabled(t0)",
    "X X p0 >= 2",
    "(p0 >= 1) R (p0 <= 1)",
    "G !fired(t0)",
    "G !deadlock",
    "(p0 < 2) W fired(t0)",
]


@MANY
@given(runs(), st.sampled_from(FORMULAS))
def test_a_violated_formula(run: tuple[CompiledNet, list[int]], formula: str) -> None:
    net, sequence = run
    markings = replay(net, sequence)
    loop = next((i for i in range(len(sequence)) if markings[i] == markings[-1]), None)
    assume(sequence)
    letters = [Step(tuple(marking), t) for marking, t in zip(markings, sequence, strict=False)]
    stem, ring = (
        (letters, [Step(tuple(markings[-1]), None)]) if loop is None else (letters[:loop], letters[loop:])
    )
    asked = parse(formula)
    bound = BoundAtoms(net, asked, NetNames(net))
    violated = not holds_on_lasso(asked, stem, ring, bound.is_true)
    assert (explanation(asked, stem, ring, bound.is_true) is not None) == violated
    cause = first_cause(witness(net, sequence, loop), formula, "violated")
    assert (cause is not None) == violated
    assume(cause is not None)
    assert cause is not None
    assert cause.first in (0, *cause.steps)
    kept = rest(sequence, cause)
    alone = replay(net, kept)
    if loop is not None:
        assert set(range(loop + 1, len(sequence) + 1)) <= set(cause.steps)
        assert alone[-1] == alone[len(kept) - len(ring)]  # it can continue forever
    for text, (since, until) in cause.decided.items():
        literal = parse(text)
        atoms = BoundAtoms(net, literal, NetNames(net))
        assert 0 <= since <= until <= len(sequence)
        if "fired" not in text:  # on markings: it is true from then on, up to then, and not longer
            values = [
                holds_on_lasso(literal, [], [Step(tuple(marking), None)], atoms.is_true)
                for marking in markings
            ]
            assert all(values[since : until + 1])
            assert since == 0 or not values[since - 1]
            assert until == len(sequence) or not values[until + 1]


@MANY
@given(runs(), st.sampled_from(["F p0 >= 2", "G p0 >= 1", "F enabled(t0)"]))
def test_what_never_comes_does_not_come_in_the_causal_past_either(
    run: tuple[CompiledNet, list[int]], formula: str
) -> None:
    """Where all literals are about one place, those left out do not matter to the formula."""
    net, sequence = run
    assume(sequence)
    cause = first_cause(witness(net, sequence), formula, "violated")
    assume(cause is not None)
    assert cause is not None
    kept = rest(sequence, cause)
    alone = replay(net, kept)
    letters = [Step(tuple(marking), t) for marking, t in zip(alone, kept, strict=False)]
    asked = parse(formula)
    bound = BoundAtoms(net, asked, NetNames(net))
    assert not holds_on_lasso(asked, letters, [Step(tuple(alone[-1]), None)], bound.is_true)


def office() -> CompiledNet:
    """Return a net where a request may be lost: asked, served or forgotten, and a clock that ticks."""
    return CompiledNet.build(
        {"idle": 1, "asked": 0, "served": 0, "lost": 0, "tick": 1, "tock": 0},
        [
            ("ask", {"idle": 1}, {"asked": 1}),
            ("serve", {"asked": 1}, {"served": 1}),
            ("forget", {"asked": 1}, {"lost": 1}),
            ("again", {"served": 1}, {"idle": 1}),
            ("on", {"tick": 1}, {"tock": 1}),
            ("off", {"tock": 1}, {"tick": 1}),
        ],
    )


def named(net: CompiledNet, *names: str) -> list[int]:
    return [net.transitions.index(name) for name in names]


def test_an_answer_that_never_comes_began_with_its_request() -> None:
    net = office()
    sequence = named(net, "on", "ask", "serve", "again", "off", "ask", "on", "forget", "off", "on")
    cause = first_cause(witness(net, sequence, loop=8), "G (asked >= 1 -> F served >= 1)", "violated")
    assert cause is not None
    assert cause.first == 6  # the second request
    assert cause.decided == {"asked >= 1": (6, 7), "served < 1": (4, 10)}
    assert cause.steps == (1, 2, 3, 4, 5, 6, 7, 9, 10)  # not 8: who forgets it is no cause of its not coming


def test_a_bad_marking_began_where_the_first_of_its_conditions_came_to_stay() -> None:
    net = office()
    sequence = named(net, "on", "ask", "off", "on", "forget")
    cause = first_cause(witness(net, sequence), "lost >= 1 & tock >= 1", "reachable")
    assert cause is not None
    assert cause.first == 4
    assert cause.decided == {"tock >= 1": (4, 5), "lost >= 1": (5, 5)}
    only = first_cause(witness(net, sequence), "lost >= 1", "reachable")
    assert only is not None
    assert (only.first, only.steps) == (5, (2, 5))  # the clock has nothing to do with it


def test_an_overflow_says_since_when_the_queue_was_full() -> None:
    model = talker()
    channel = model.channels[0]
    assert isinstance(channel, sym.TopicChannel)
    channel.publishers[0].limit = 1
    subject = subject_of(model, "none")
    (drop,) = (
        name
        for name, role in step_roles(subject.links()).items()
        if role.kind is Drop and role.queue == "publisher"
    )
    answer = find_firing(subject.net, subject.transition_index[drop])
    assert answer.trace is not None
    found = witness_of(subject, answer.trace)
    cause = first_cause(found, "the publisher queue can overflow", "queue-overflow")
    assert cause is not None
    assert "takes a message" in found.steps[2].text
    full = "publisher queue of Said (topic chatter): load >= 1"
    assert cause.decided == {"Said >= 1": (1, 3), full: (3, 4)}
    assert cause.first == 1  # the earliest of what has been so ever since
    header = next(iter(witness_records(found, source="", asked="it can overflow", verdict="queue-overflow")))
    assert isinstance(header, Header)
    assert (header.cause, header.causes) == (cause.first, list(cause.steps))
    assert decode_record(encode_record(header)) == header


@pytest.mark.parametrize(
    ("asked", "verdict"),
    [("AG EF served >= 1", "violated"), ("nobody >= 1", "reachable"), ("G idle >= 0", "holds")],
)
def test_what_says_nothing_of_the_one_run_has_no_cause(asked: str, verdict: str) -> None:
    net = office()
    assert first_cause(witness(net, named(net, "ask", "forget")), asked, verdict) is None


def test_a_deadlock_began_with_the_first_of_those_who_wait() -> None:
    """Two philosophers take their left forks: since then, each waits for the other's."""
    net = CompiledNet.build(
        {"fork1": 1, "fork2": 1, "thinks1": 1, "thinks2": 1, "has1": 0, "has2": 0, "bell": 1},
        [
            ("left1", {"fork1": 1, "thinks1": 1}, {"has1": 1}),
            ("left2", {"fork2": 1, "thinks2": 1}, {"has2": 1}),
            ("eat1", {"has1": 1, "fork2": 1}, {"fork1": 1, "fork2": 1, "thinks1": 1}),
            ("eat2", {"has2": 1, "fork1": 1}, {"fork1": 1, "fork2": 1, "thinks2": 1}),
            ("ring", {"bell": 1}, {}),
        ],
    )
    sequence = named(net, "left2", "eat2", "ring", "left1", "left2")
    for asked, verdict in (("G !deadlock", "violated"), ("deadlock", "reachable"), ("none", "deadlock")):
        cause = first_cause(witness(net, sequence), asked, verdict)
        assert cause is not None
        assert cause.first == 4
        assert cause.decided == {"fork2 < 1": (5, 5), "fork1 < 1": (4, 5)}
        assert cause.steps == (1, 3, 4)  # that somebody eats in between is not needed
        assert replay(net, rest(sequence, cause))[-1] == replay(net, sequence)[-1]


def test_growth_without_bound_rests_on_no_marking() -> None:
    net = CompiledNet.build({"a": 1, "b": 0}, [("grow", {"a": 1}, {"a": 1, "b": 1})])
    assert first_cause(witness(net, [0], loop=0), "tokens grow without bound: b", "unbounded") is None


def test_branching_formulas_with_one_path() -> None:
    net = office()
    sequence = named(net, "on", "ask", "forget")
    for asked, verdict in (("AG lost < 1", "violated"), ("EF lost >= 1", "holds")):
        cause = first_cause(witness(net, sequence), asked, verdict)
        assert cause is not None
        assert (cause.first, cause.steps) == (3, (2, 3))


def test_a_case_study_witness_is_quick() -> None:
    """A long sequence is no trouble: 20 000 firings within seconds."""
    net = office()
    sequence = named(net, *["on", "off"] * 9_999, "ask", "forget")
    cause = first_cause(witness(net, sequence), "G !(lost >= 1)", "violated")
    assert cause is not None
    assert cause.steps == (19_999, 20_000)
