"""Whether callbacks always end, decided on parts of a net, is what all its markings say."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings

from dineros.analysis.answers.budget import Budget
from dineros.analysis.callbacks import refining
from dineros.analysis.callbacks.blocking import without
from dineros.analysis.callbacks.refining import Ending, Endings, Running
from dineros.analysis.callbacks.waiting import Callback, Waiting
from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.syntax import Constant
from dineros.analysis.model.subject import Subject, base_subject
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.witness import replay
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.symbolic.levels import UnknownBoundError
from dineros.metamodel import sym
from dineros.metamodel.elements import transitions
from dineros.metamodel.errors import DinerosError
from examples.callbacks.models import PROGRAMS, program
from tests.support.ros2_systems.executor_cases import FIGURES, Case, case_model
from tests.support.ros2_systems.executor_models import executor_models


def both(subject: Subject, waiting: Waiting) -> Iterator[tuple[Callback, str, str]]:
    """Yield each callback with what parts say of it, whose runs are replayed, and what all markings say."""
    space = symbolic_state_space(subject.net)
    sets = SymbolicSets(space, BoundAtoms(subject.net, Constant(True), subject.names))
    endings = Endings(subject.net)
    for callback in waiting.callbacks.values():
        doomed = sets.complement(sets.some_until(sets.everything, without(sets, callback.places)))
        ending = endings.of(callback.places, Budget(seconds=60).begun())
        if ending.status == "waits":
            assert sets.contains(doomed, tuple(replay(subject.net, ending.trace)[-1]))
        yield callback, ending.status, "waits" if doomed else "ends"


@pytest.mark.long
@pytest.mark.parametrize("name", PROGRAMS)
def test_programs(name: str) -> None:
    subject = base_subject(program(name))
    for callback, found, expected in both(subject, Waiting(subject)):
        assert found == expected, callback.waiter.text


@pytest.mark.long
@pytest.mark.parametrize("case", [case for case, _ in FIGURES], ids=str)
def test_cases(case: Case) -> None:
    subject = base_subject(case_model(case))
    for callback, found, expected in both(subject, Waiting(subject)):
        assert found == expected, callback.waiter.text


@pytest.mark.long
def test_generated_models() -> None:
    """What is decided is right, and more is decided than not."""
    answers: Counter[str] = Counter()

    @settings(
        max_examples=3,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow],
    )
    @given(executor_models())
    def compare(model: sym.SystemModel) -> None:
        for transition in transitions(model):
            transition.overrides.clear()  # priorities are not analysed
        try:
            subject = base_subject(model)
            compared = list(both(subject, Waiting(subject)))
        except (DinerosError, UnknownBoundError):  # without bounds, there is nothing to compare with
            assume(False)
        for callback, found, expected in compared:
            answers[found] += 1
            assert found in (expected, "unknown"), callback.waiter.text

    compare()
    assert answers["ends"] + answers["waits"] > answers["unknown"], answers


def test_what_nothing_bounds_is_not_known_where_it_counts() -> None:
    """The end takes from a heap: whether there is something on it, no part says."""
    net = CompiledNet.build(
        {"runs": 0, "rests": 1, "heap": 0},
        [
            Transition("begin", {"rests": 1}, {"runs": 1}),
            Transition("end", {"runs": 1, "heap": 1}, {"rests": 1}),
            Transition("more", {}, {"heap": 1}),
        ],
    )
    assert Endings(net).of((0,), Budget().begun()).status == "unknown"
    assert Endings(net).of((2,), Budget().begun()).status == "unknown"


def test_an_inhibitor_arc_is_asked_like_an_input() -> None:
    """The end waits until a flag is down, which is never taken down once it is up."""
    net = CompiledNet.build(
        {"runs": 0, "rests": 1, "down": 1, "up": 0},
        [
            Transition("begin", {"rests": 1}, {"runs": 1}),
            Transition("end", {"runs": 1}, {"rests": 1}, {"up": 1}),
            Transition("raise", {"down": 1}, {"up": 1}),
        ],
    )
    ending = Endings(net).of((0,), Budget().begun())
    assert ending.status == "waits"
    assert replay(net, ending.trace)[-1] == [1, 0, 0, 1]


class _Costly(Endings):
    """Says that the first callback needs more than half of all the time, and others need none."""

    def of(self, running: Running, budget: Budget, work: int = 0) -> Ending:
        assert budget.left is not None
        is_enough = running != (0,) or budget.left > 50
        return Ending("ends") if is_enough else Ending("unknown", is_limited=True)


def test_time_that_others_do_not_need_is_divided_again() -> None:
    net = CompiledNet.build({f"runs{number}": 0 for number in range(20)}, [])
    asked = [(place,) for place in range(20)]
    found = _Costly(net).of_all(asked, Budget(seconds=90))
    assert {ending.status for ending in found.values()} == {"ends"}
    assert list(found) == asked


def test_what_needs_too_much_time_ends_the_passes() -> None:
    net = CompiledNet.build({"runs": 0, "other": 0}, [])
    found = _Costly(net).of_all([(0,), (1,)], Budget(seconds=40))
    assert [found[0,].status, found[1,].status] == ["unknown", "ends"]


def test_a_second_callback_begins_with_the_part_of_the_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each of some switches can only be turned on while the next one is on, and so on."""
    size = 8
    places = {"rests": 1, "one": 0, "other": 0}
    rows = [
        Transition("begin one", {"rests": 1}, {"one": 1}),
        Transition("begin other", {"rests": 1}, {"other": 1}),
        Transition("end one", {"one": 1}, {"rests": 1}, reads={"on0": 1}),
        Transition("end other", {"other": 1}, {"rests": 1}, reads={"on0": 1}),
    ]
    for number in range(size):
        places |= {f"on{number}": 0, f"off{number}": 1}
        reads = {f"on{number + 1}": 1} if number + 1 < size else {}
        rows += [
            Transition(f"on {number}", {f"off{number}": 1}, {f"on{number}": 1}, reads=reads),
            Transition(f"off {number}", {f"on{number}": 1}, {f"off{number}": 1}),
        ]
    made = 0

    class Counted(refining._RefinedPart):
        def __init__(self, *arguments: Any) -> None:
            nonlocal made
            made += 1
            super().__init__(*arguments)

    monkeypatch.setattr(refining, "_RefinedPart", Counted)
    endings = Endings(CompiledNet.build(places, rows))
    assert endings.of((1,), Budget().begun()).status == "ends"
    assert made > size
    made = 0
    assert endings.of((2,), Budget().begun()).status == "ends"
    assert made == 2
