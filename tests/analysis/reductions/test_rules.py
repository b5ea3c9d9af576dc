"""One small net for each rule, with what it becomes; and nets that just miss a rule's conditions."""

from __future__ import annotations

import doctest
from collections.abc import Mapping

import pytest

from dineros.analysis.nets.compiled import CompiledNet, NetError, Transition
from dineros.analysis.reductions import RULES, MutableNet, Property, Reduction, ReductionError, reduce, replay
from dineros.analysis.reductions import reduction as reduction_module
from tests.analysis.reductions.brute_force import markings_of

T = Transition


def _reduced(
    rule: str,
    places: Mapping[str, int],
    transitions: list[Transition],
    *preserve: str,
    observed: tuple[str, ...] = (),
) -> Reduction:
    net = CompiledNet.build(places, transitions)
    rules = [each for each in RULES if each.name == rule]
    assert rules, f"no rule {rule}"
    return reduce(net, preserve, observed_places=observed, rules=rules)


def test_the_example_runs() -> None:
    assert doctest.testmod(reduction_module).failed == 0


def test_constant_place() -> None:
    transitions = [T("t", {"p": 1}, {"q": 1}, reads={"c": 2})]
    assert _reduced("ConstantPlace", {"p": 1, "q": 0, "c": 2}, transitions, *Property).net.places == (
        "p",
        "q",
    )
    assert not _reduced("ConstantPlace", {"p": 1, "q": 0, "c": 1}, transitions).steps
    assert not _reduced("ConstantPlace", {"p": 1, "q": 0, "c": 2}, transitions, observed=("c",)).steps


def test_parallel_place() -> None:
    transitions = [T("t", {"p": 1, "q": 2}, {"r": 1})]
    reduction = _reduced("ParallelPlace", {"p": 2, "q": 4, "r": 0}, transitions, *Property)
    assert reduction.net.places == ("q", "r")
    assert [str(equation) for equation in reduction.equations] == ["p = 0 + 1/2 * q"]
    assert list(markings_of(reduction, {"q": 2, "r": 1})) == [{"p": 1, "q": 2, "r": 1}]


def test_implied_place() -> None:
    # `busy` is the sum of two others, as the active instances of a service are of those in use by clients.
    places = {"idle": 2, "busy": 0, "by a": 0, "by b": 0}
    transitions = [T(f"call {c}", {"idle": 1}, {"busy": 1, f"by {c}": 1}) for c in "ab"]
    transitions += [T(f"return {c}", {"busy": 1, f"by {c}": 1}, {"idle": 1}) for c in "ab"]
    reduction = _reduced("ImpliedPlace", places, transitions, *Property)
    assert reduction.net.places == ("idle", "by a", "by b")


def test_a_place_that_only_counts_is_implied_but_may_be_unbounded() -> None:
    places = {"p": 1, "q": 0, "count": 0}
    transitions = [T("t", {"p": 1}, {"q": 1, "count": 1}), T("u", {"q": 1}, {"p": 1})]
    assert _reduced("ImpliedPlace", places, transitions, "ltl_without_next").net.places == ("p", "q")
    assert not _reduced("ImpliedPlace", places, transitions, "boundedness").steps
    assert not _reduced("ImpliedPlace", places, transitions, "state_space_size").steps


def test_dead_transition() -> None:
    transitions = [T("t", {"p": 1}, {"q": 1}), T("u", {"r": 1}, {"s": 1}), T("v", {"s": 1}, {"r": 1})]
    transitions += [T("w", {"p": 1}, {"q": 1}, {"full": 1})]
    reduction = _reduced(
        "DeadTransition", {"p": 1, "q": 0, "r": 0, "s": 0, "full": 1}, transitions, "deadlocks"
    )
    assert reduction.net.transitions == ("t",)
    assert not _reduced("DeadTransition", {"p": 0, "q": 0}, transitions[:1], Property.LIVENESS).steps


def test_excluded_transition() -> None:
    transitions = [
        T("go", {"p": 1}, {"q": 1}),
        T("back", {"q": 1}, {"p": 1}),
        T("both", {"p": 1, "q": 1}, {}),
    ]
    reduction = _reduced("ExcludedTransition", {"p": 1, "q": 0}, transitions, Property.STATE_SPACE_SIZE)
    assert reduction.net.transitions == ("go", "back")


def test_duplicate_transition() -> None:
    places = {"p": 1, "q": 0, "r": 0}
    transitions = [
        T("t", {"p": 1}, {"q": 1}),
        T("u", {"p": 1}, {"q": 1}),
        T("v", {"p": 1}, {"q": 1}, {}, {"r": 1}),
    ]
    assert _reduced("DuplicateTransition", places, transitions, "deadlocks").net.transitions == ("t",)
    # v needs more than t, so it may be dead while t is live.
    assert _reduced("DuplicateTransition", places, transitions, "liveness").net.transitions == ("t", "v")


def test_composed_transition() -> None:
    transitions = [T("t", {"p": 1}, {"q": 1}), T("u", {"q": 1}, {"r": 1}), T("both", {"p": 1}, {"r": 1})]
    reduction = _reduced(
        "ComposedTransition", {"p": 1, "q": 0, "r": 0}, transitions, Property.STATE_SPACE_SIZE
    )
    assert reduction.net.transitions == ("t", "u")


def test_identity_transition_stays_where_it_prevents_a_deadlock() -> None:
    transitions = [T("look", reads={"p": 1}), T("t", {"p": 1}, {"q": 1})]
    assert _reduced("IdentityTransition", {"p": 1, "q": 0}, transitions, "deadlocks").net.transitions == (
        "t",
    )
    transitions[0] = T("look", reads={"q": 1})
    assert not _reduced("IdentityTransition", {"p": 1, "q": 0}, transitions, "deadlocks").steps
    assert _reduced("IdentityTransition", {"p": 1, "q": 0}, transitions, "kept_places").steps


def test_complementary_inhibitor() -> None:
    # An overflow queue: to drop without capacity becomes to drop when full (rules T5a and T5b).
    transitions = [T("in", {"capacity": 1}, {"load": 1}), T("out", {"load": 1}, {"capacity": 1})]
    transitions += [T("drop", {"source": 1}, {}, {"capacity": 1})]
    reduction = _reduced(
        "ComplementaryInhibitor", {"source": 1, "load": 0, "capacity": 3}, transitions, *Property
    )
    arcs = MutableNet.of(reduction.net).transitions["drop"]
    assert (arcs.inputs, arcs.outputs, arcs.inhibitors) == ({"source": 1, "load": 3}, {"load": 3}, {})


def test_implied_inhibitor() -> None:
    transitions = [T("t", {"p": 1}, {"q": 1}, {"q": 2})]
    reduction = _reduced("ImpliedInhibitor", {"p": 2, "q": 0}, transitions, *Property)
    assert not reduction.net.inhibitor.place.size
    assert not _reduced("ImpliedInhibitor", {"p": 3, "q": 0}, transitions).steps


def test_inexhaustible_place() -> None:
    transitions = [T("make", {}, {"p": 2}), T("use", {"p": 3, "q": 1}, {"r": 1})]
    reduction = _reduced("InexhaustiblePlace", {"p": 0, "q": 1, "r": 0}, transitions, "deadlocks", "liveness")
    assert reduction.net.places == ("q", "r")
    assert reduction.expand(["use"]) == ["make", "make", "use"]


def test_chain_of_places() -> None:
    places = {"a": 1, "b": 0, "c": 0}
    transitions = [T("s", {"a": 1}, {"b": 2}), T("move", {"b": 1}, {"c": 1}), T("e", {"c": 2}, {"a": 1})]
    reduction = _reduced("ChainOfPlaces", places, transitions, "kept_places", "liveness", "ltl_without_next")
    assert reduction.net.places == ("a", "b+c")
    assert reduction.kept_places == ("a",)
    assert reduction.expand(["s", "e"]) == ["s", "move", "move", "e"]


def test_loop_of_places() -> None:
    places = {"a": 1, "b": 0, "c": 0, "d": 0}
    transitions = [T("ab", {"a": 1}, {"b": 1}), T("bc", {"b": 1}, {"c": 1}), T("ca", {"c": 1}, {"a": 1})]
    transitions += [T("out", {"c": 1}, {"d": 1})]
    reduction = _reduced("LoopOfPlaces", places, transitions, "kept_places", "deadlocks", "ltl_without_next")
    assert reduction.net.places == ("d", "a+b+c")
    assert reduction.net.transitions == ("out", "idle(ab)")
    assert reduction.expand(["idle(ab)", "out"]) == ["ab", "bc", "out"]


def test_post_agglomeration() -> None:
    places = {"a": 1, "p": 0, "b": 0, "c": 0}
    transitions = [T("h", {"a": 1}, {"p": 1}), T("f", {"p": 1}, {"b": 1, "c": 1}), T("g", {"p": 1}, {"b": 2})]
    reduction = _reduced("PostAgglomeration", places, transitions, "deadlocks", "ltl_without_next")
    assert reduction.net.transitions == ("h.f", "h.g")
    assert reduction.expand(["h.g"]) == ["h", "g"]
    assert not _reduced("PostAgglomeration", places, transitions, observed=("c",)).steps


def test_pre_agglomeration() -> None:
    places = {"a": 2, "p": 0, "key": 1, "b": 0}
    transitions = [T("h", {"a": 1}, {"p": 1}), T("f", {"p": 1, "key": 1}, {"b": 1})]
    reduction = _reduced("PreAgglomeration", places, transitions, "deadlocks", "ltl_without_next")
    assert reduction.net.transitions == ("h.f",)
    assert reduction.expand(["h.f"]) == ["h", "f"]
    # One token of `a` is left, which only h can still take.
    assert reduction.expand(["h.f"], until_deadlock=True) == ["h", "f", "h"]


def test_pre_agglomeration_of_steps_that_never_meet_is_not_live() -> None:
    # The step that takes its token after h is always f, and that after i always g: "h.g" never fires.
    places = {"a": 1, "b": 0, "c": 0, "d": 0, "for h": 0, "for i": 0, "p": 0}
    transitions = [
        T("t", {"a": 1}, {"b": 1, "for h": 1}),
        T("h", {"for h": 1}, {"p": 1}),
        T("f", {"p": 1, "b": 1}, {"c": 1}),
        T("u", {"c": 1}, {"d": 1, "for i": 1}),
        T("i", {"for i": 1}, {"p": 1}),
        T("g", {"p": 1, "d": 1}, {"a": 1}),
    ]
    assert "h.g" in _reduced("PreAgglomeration", places, transitions, "deadlocks").net.transitions
    assert not _reduced("PreAgglomeration", places, transitions, "liveness").steps


SIGNAL = [T("rise", {"off": 1}, {"on": 1}), T("fall", {"on": 1}, {"off": 1})]


def test_independent_component() -> None:
    transitions = [
        *SIGNAL,
        T("t", {"p": 1}, {"q": 1}, reads={"on": 1}),
        T("u", {"q": 1}, {"p": 1}, {"on": 1}),
    ]
    reduction = _reduced("IndependentComponent", {"p": 1, "q": 0, "on": 0, "off": 1}, transitions, *Property)
    assert reduction.net.places == ("p", "q")
    assert reduction.net.transitions == ("t", "u", "idle(rise)")
    assert reduction.count_factor == 2
    assert reduction.expand(["t", "u", "t"]) == ["rise", "t", "fall", "u", "rise", "t"]
    assert len(list(markings_of(reduction, {"p": 1, "q": 0}))) == 2


def test_a_component_that_can_get_stuck_is_kept() -> None:
    # Once risen, the signal stays: whether t can fire at first depends on when.
    places = {"p": 1, "q": 0, "on": 0, "off": 1}
    assert not _reduced(
        "IndependentComponent", places, [SIGNAL[0], T("t", {"p": 1}, {"q": 1}, reads={"off": 1})]
    ).steps
    # What waits for it to rise can continue; but then not all combinations of markings occur.
    transitions = [SIGNAL[0], T("t", {"p": 1}, {"q": 1}, reads={"on": 1})]
    reduction = _reduced("IndependentComponent", places, transitions, "kept_places", "deadlocks")
    assert reduction.net.transitions == ("t",)
    assert reduction.expand([], until_deadlock=False) == []
    assert Property.STATE_SPACE_SIZE not in reduction.preserves


def test_a_component_that_may_stop_or_run_on_claims_nothing_about_runs() -> None:
    places = {"p": 1, "q": 0, "begin": 1, "on": 0, "off": 0, "end": 0}
    transitions = [*SIGNAL, T("start", {"begin": 1}, {"on": 1}), T("stop", {"begin": 1}, {"end": 1})]
    transitions += [T("t", {"p": 1}, {"q": 1})]
    counting = _reduced("IndependentComponent", places, transitions, "state_space_size", observed=("p",))
    assert counting.count_factor == 4
    for item in (Property.DEADLOCKS, Property.LTL_WITHOUT_NEXT):
        reduction = _reduced("IndependentComponent", places, transitions, item, observed=("p",))
        assert {"on", "off"} <= set(reduction.net.places)


def test_a_chain_that_is_never_filled_again_is_not_live() -> None:
    places = {"p": 1, "q": 0, "r": 0}
    transitions = [T("once", {"p": 1}, {"q": 1}), T("t", {"q": 1}, {"r": 1}), T("u", {"r": 2}, {"q": 2})]
    assert _reduced("ChainOfPlaces", places, transitions, "deadlocks").net.places == ("p+q+r",)
    assert "p" in _reduced("ChainOfPlaces", places, transitions, "liveness").net.places


def test_unreadable_transition() -> None:
    transitions = [*SIGNAL, T("t", {"p": 1}, {"q": 1}, reads={"on": 1, "off": 1})]
    reduction = _reduced(
        "UnreadableTransition", {"p": 1, "q": 0, "on": 0, "off": 1}, transitions, "kept_places"
    )
    assert reduction.net.transitions == ("rise", "fall")


def test_the_result_does_not_depend_on_chance_and_the_input_stays_as_it_was() -> None:
    net = CompiledNet.build(
        {"p": 1, "q": 0, "on": 0, "off": 1}, [*SIGNAL, T("t", {"p": 1}, {"q": 1}, reads={"on": 1})]
    )
    one, other = (reduce(net, {"kept_places"}) for _ in range(2))
    assert [str(step) for step in one.steps] == [str(step) for step in other.steps]
    assert one.net.transitions == other.net.transitions
    assert len(net.places) == 4


def test_unknown_names_are_errors() -> None:
    net = CompiledNet.build({"p": 1}, [T("t", {"p": 1}, {})])
    with pytest.raises(ReductionError, match="place 'x'"):
        reduce(net, {"deadlocks"}, observed_places=["x"])
    with pytest.raises(ReductionError, match="transition 'x'"):
        reduce(net, {"deadlocks"}, observed_transitions=["x"])
    with pytest.raises(ReductionError, match="the properties are state_space_size"):
        reduce(net, {"arcs"})
    with pytest.raises(NetError, match="unknown transition"):
        reduce(net, {"deadlocks"}).expand(["x"])
    with pytest.raises(NetError, match="not enabled"):
        replay(MutableNet.of(net), ["t", "t"])


def test_counting_is_refused_where_it_is_lost() -> None:
    net = CompiledNet.build({"p": 2, "q": 0}, [T("t", {"p": 1}, {"q": 1})])
    reduction = reduce(net, {"kept_places"})
    with pytest.raises(ReductionError, match="number of markings"):
        _ = reduction.count_factor
