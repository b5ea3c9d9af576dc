"""Parts of time Petri nets: what a part proves holds in the whole net, of which other nets use its tokens."""

from __future__ import annotations

from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.stages import Share
from dineros.analysis.logic.language.bounded import read_bounded
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.nets.compiled import Transition
from dineros.analysis.questions.engines import IN_PART, Timed
from dineros.analysis.questions.net_questions import Enabled, Linear
from dineros.analysis.timed.durations.bounded_response import decide_bounded
from dineros.analysis.timed.goals import find_timed_firing
from dineros.analysis.timed.nets import Interval, TimedNet
from dineros.analysis.timed.reductions import parts
from dineros.analysis.timed.reductions.parts import part_around, part_of_firing, part_of_formula
from tests.analysis.timed.time_nets import lively_net


def two_nets(random: Random) -> tuple[TimedNet, int]:
    """Return a net and how many of its transitions come first, on which the others never decide.

    The others read tokens of the first ones, or take them and put them back.
    """
    tokens: dict[str, int] = {}
    made: list[Transition] = []
    intervals: dict[str, Interval] = {}
    first = 0
    for letter in "ab":
        net = lively_net(random, is_closed=True, most=300).net
        names = [f"{letter}{place}" for place in net.untimed.places]
        tokens |= dict(zip(names, net.untimed.initial.tolist(), strict=True))
        for t, (name, interval) in enumerate(zip(net.untimed.transitions, net.intervals, strict=True)):
            take, put, test, inhibit = (
                {names[place]: weight for place, weight in table.row(t)}
                for table in (net.take, net.put, net.untimed.pre, net.untimed.inhibitor)
            )
            reads = {place: weight - take.get(place, 0) for place, weight in test.items()}
            reads = {place: weight for place, weight in reads.items() if weight}
            place = random.choice([each for each in tokens if each.startswith("a")])
            if letter == "b" and random.random() < 0.6:
                if random.random() < 0.5:
                    take[place] = put[place] = 1
                else:
                    reads[place] = 1
            made.append(Transition(f"{letter}{name}", take, put, inhibit, reads))
            intervals[f"{letter}{name}"] = interval
        first = first or len(made)
    return TimedNet.build(tokens, made, intervals), first


@pytest.mark.long
@pytest.mark.parametrize("seed", range(60))
def test_what_a_part_proves_holds_in_the_whole_net(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "MOST", 1.0)
    random = Random(seed)
    net, first = two_nets(random)
    names = NetNames(net.untimed)
    places = [name for name in net.untimed.places if name.startswith("a")]
    for t in range(first):
        part = part_of_firing(net, t)
        assert part is not None
        name = net.untimed.transitions[t]
        if find_timed_firing(part.net, name).status == "unreachable":
            assert find_timed_firing(net, name).status == "unreachable"
        text = f"G (fired({name}) -> X F[<={random.randint(0, 6)}/7] ({random.choice(places)} >= 1))"
        formula = read_bounded(text)
        assert formula is not None
        part = part_of_formula(net, formula, names)
        assert part is not None
        if decide_bounded(part.net, formula).status == "holds":
            assert decide_bounded(net, formula).status == "holds"


@pytest.mark.long
def test_parts_prove_as_much_as_the_whole_net_where_others_only_read(monkeypatch: pytest.MonkeyPatch) -> None:
    """So the proofs above are not those of a part that can do anything."""
    monkeypatch.setattr(parts, "MOST", 1.0)
    agreed = proved = 0
    for seed in range(40):
        net, first = two_nets(Random(seed))
        for t in range(first):
            part = part_of_firing(net, t)
            name = net.untimed.transitions[t]
            assert part is not None
            answers = {find_timed_firing(each, name).status for each in (part.net, net)}
            agreed += len(answers) == 1
            proved += answers == {"unreachable"}
    assert proved >= 5
    assert agreed >= 150


def loop(shared: str = "") -> TimedNet:
    """Return a slow timer of its own next to three that are quick; one of these may take its clock."""
    made = [
        Transition("strike", {"clock": 1}, {"due": 1}, {}, {}),
        Transition("wind", {"due": 1}, {"clock": 1}),
    ]
    for number in range(3):
        made.append(Transition(f"go{number}", {f"p{number}": 1}, {f"q{number}": 1}, {}, {}))
        back = {f"q{number}": 1, **({shared: 1} if shared and not number else {})}
        made.append(Transition(f"back{number}", back, {**back, f"p{number}": 1, f"q{number}": 0}))
    made = [each._replace(outputs={p: w for p, w in each.outputs.items() if w}) for each in made]
    tokens = {"clock": 1, "due": 0, **{f"p{n}": 1 for n in range(3)}, **{f"q{n}": 0 for n in range(3)}}
    return TimedNet.build(tokens, made, {"strike": Interval(5, 5), "wind": Interval(2, 3)})  # type: ignore[arg-type]


def test_a_part_keeps_the_times_of_what_is_its_own() -> None:
    net = loop()
    part = part_around(net, [0, 1])
    assert part is not None
    assert [str(interval) for interval in part.net.intervals[:2]] == ["[5,5]", "[2,3]"]
    assert find_timed_firing(part.net, "go0").status == "unreachable"
    late, soon = (read_bounded(f"G (fired(strike) -> F[<={bound}] fired(wind))") for bound in (3, 2))
    assert late is not None and soon is not None
    assert decide_bounded(part.net, late).status == "holds"
    assert decide_bounded(part.net, soon).status == "violated"


def test_a_guest_that_puts_tokens_back_restarts_a_clock_of_the_part() -> None:
    net = loop("clock")
    part = part_around(net, [0, 1])
    assert part is not None
    formula = read_bounded("F[<=5] fired(strike)")
    assert formula is not None
    assert decide_bounded(part.net, formula).status == decide_bounded(net, formula).status == "violated"


def test_conditions_on_firings_that_may_be_outside_are_not_asked_of_a_part() -> None:
    net = loop()
    names = NetNames(net.untimed)
    for text in ("G (fired(strike) -> G[<=3] !fired(wind))", "G (!fired(strike) -> F[<=3] (due >= 1))"):
        formula = read_bounded(text)
        assert formula is not None
        assert part_of_formula(net, formula, names) is None


def test_a_part_with_all_places_is_the_whole_net() -> None:
    made = [Transition("t", {"p": 1}, {"p": 1}), *(Transition(f"idle{n}", {}, {}) for n in range(3))]
    assert part_around(TimedNet.build({"p": 1}, made, {}), [0]) is None


def test_priorities_have_no_parts() -> None:
    net = TimedNet.build(
        {"p": 1, "q": 1, "r": 1},
        [Transition("t", {"p": 1}, {}), Transition("u", {"q": 1}, {}), Transition("v", {"r": 1}, {})],
        {},
        [("u", "t")],
    )
    assert part_around(net, [0]) is None


def test_an_engine_asks_a_part_if_the_whole_net_is_too_large(monkeypatch: pytest.MonkeyPatch) -> None:
    import dineros.analysis.questions.engines as engines

    monkeypatch.setattr(engines, "FIRST", Share(time=0.0))
    net = loop()
    names = NetNames(net.untimed)
    question = Linear(net.untimed, names, "G (fired(strike) -> F[<=3] fired(wind))", (), ())
    answer = Timed(net).answer(question, Budget(seconds=60))
    assert answer.status == "holds"
    assert answer.by.endswith(IN_PART)
    firing = Timed(net).answer(Enabled(net.untimed, names, "strike"), Budget(seconds=60))
    assert firing.status == "reachable"
