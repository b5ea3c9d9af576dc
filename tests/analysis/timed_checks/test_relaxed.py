"""What is proved of nets in which only time keeps a place from filling up, against their regions."""

from __future__ import annotations

from dataclasses import replace
from random import Random

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.nets.bounds import flows_and_bounds
from dineros.analysis.questions.engines import Timed
from dineros.analysis.questions.net_questions import Branching, Linear, Marking, Question
from dineros.analysis.questions.relaxed import relaxed
from dineros.analysis.timed.timed_subject import timed_subject_of
from dineros.analysis.timed_checks.without_times import without_times
from tests.analysis.timed.time_nets import RandomNet, random_net
from tests.analysis.timed_checks.test_timed_check import model_of
from tests.support.references.regions import TimedTransition

ONE_CLASS = Budget(seconds=60, states=1)


def striking_net(random: Random) -> RandomNet:
    """Return a random net with a timer, whose strikes are taken at once, or are lost, or gather."""
    while True:
        base = random_net(random)
        places = len(base.initial)
        clock, struck, used = places, places + 1, random.randrange(places)
        period, late = random.randint(0, 3), random.choice((0, 0, 0, 0, 1, None))

        def made(
            name: str, take: dict[int, int], put: dict[int, int], first: int, last: int | None, *no: int
        ) -> TimedTransition:
            return TimedTransition(
                name, take, put, {}, dict.fromkeys(no, 1), first, last, False, False, frozenset()
            )

        steps = [
            *(replace(each, name=f"t{n}") for n, each in enumerate(base.transitions)),
            made("strike", {clock: 1}, {clock: 1, struck: 1}, period, period),
            made("take", {struck: 1, used: 1}, {random.randrange(places): 1}, 0, late),
        ]
        if random.random() < 0.8:
            steps.append(made("miss", {struck: 1}, {}, 0, 0, used))
        if random.random() < 0.5:
            steps.append(made("stop", {clock: 1}, {}, 0, period))
        steps = [replace(each, name=f"t{n}") for n, each in enumerate(steps)]
        net = RandomNet((*base.initial, 1, 0), steps, ())
        try:
            net.regions(3_000)
        except OverflowError:
            continue
        _, bounds = net.net.untimed.once(flows_and_bounds)
        if bounds[struck] is None:
            return net


def test_nothing_is_proved_that_regions_deny() -> None:
    bounded = lively = never = denied = 0
    for seed in range(24):
        net = striking_net(Random(seed))
        regions, names = net.regions(), [each.name for each in net.transitions]
        fires = {names[t] for fired in regions.fires.values() for t, _ in fired}
        ends = any(not clocks for _, clocks in regions.fires)
        proof = without_times(timed_subject_of(model_of(net)), Budget(seconds=60))
        assert not proof.dead & fires
        if proof.most is not None:
            assert max(max(marking) for marking in regions.markings) <= proof.most
        assert not (proof.has_no_deadlock and ends)
        bounded += proof.most is not None
        lively += proof.has_no_deadlock
        never += bool(proof.dead)
        denied += ends
    assert min(bounded, lively, never, denied) >= 2, (bounded, lively, never, denied)


def test_what_may_gather_has_no_bound() -> None:
    """Strikes without a period, and strikes that nothing has to take."""
    for period, late, expected in ((2, 0, 1), (0, 0, None), (2, 1, None), (2, None, None)):
        one = TimedTransition("t0", {0: 1}, {0: 1, 1: 1}, {}, {}, period, period, False, False, frozenset())
        two = TimedTransition("t1", {1: 1}, {}, {}, {}, 0, late, False, False, frozenset())
        subject = timed_subject_of(model_of(RandomNet((1, 0), [one, two], ())))
        assert without_times(subject, Budget(seconds=60)).most == expected


def test_questions_have_the_answers_of_regions() -> None:
    proved = 0
    for seed in range(24):
        random = Random(seed)
        made = striking_net(random)
        net, regions = made.net, made.regions()
        assert relaxed(net.untimed).places
        names, p, t = NetNames(net.untimed), random.randrange(len(made.initial) - 2), random.randrange(3)
        some = {marking for marking, _ in regions.fires if marking[p] >= 2}
        steps = {marking for (marking, _), fired in regions.fires.items() for u, _ in fired if u == t}
        struck = {marking for marking, _ in regions.fires if marking[-1] >= 2}
        asked: list[tuple[Question, bool]] = [
            (Marking(net.untimed, names, f"p{p} >= 2"), not some),
            (Branching(net.untimed, names, f"AG !(p{p} >= 2)"), not some),
            (Linear(net.untimed, names, f"G !fired(t{t})"), not steps),
            (Marking(net.untimed, names, f"p{len(made.initial) - 1} >= 2"), not struck),
        ]
        for question, never in asked:
            status = Timed(net).answer(question, ONE_CLASS).status
            assert status not in ("reachable", "violated"), question
            assert never or status == "unknown", question
            proved += status != "unknown"
    assert proved >= 10


def test_strikes_that_wait_for_other_strikes_may_gather() -> None:
    """Two timers; what takes their strikes at once may need a strike of both, or none of the other."""
    bounded = gathering = 0
    for seed in range(30):
        random = Random(seed)
        clocks = [
            TimedTransition(
                f"t{n}", {n: 1}, {n: 1, n + 2: 1}, {}, {}, period, period, False, False, frozenset()
            )
            for n, period in enumerate(random.choices((1, 2), k=2))
        ]
        takers = []
        for n in range(2, 2 + random.randint(1, 3)):
            taken = random.choice(([2], [3], [2, 3]))
            without = random.choice(({}, {}, {random.choice((2, 3)): random.randint(1, 2)}))
            inhibitor = {p: weight for p, weight in without.items() if p not in taken or weight > 1}
            takers.append(
                TimedTransition(
                    f"t{n}", dict.fromkeys(taken, 1), {}, {}, inhibitor, 0, 0, False, False, frozenset()
                )
            )
        net = RandomNet((1, 1, 0, 0), [*clocks, *takers], ())
        proof = without_times(timed_subject_of(model_of(net)), Budget(seconds=60))
        try:
            most = max(max(marking) for marking in net.regions(3_000).markings)
        except OverflowError:
            gathering += 1
            assert proof.most is None, seed
            continue
        bounded += proof.most is not None
        assert proof.most is None or most <= proof.most, seed
    assert min(bounded, gathering) >= 3, (bounded, gathering)


def test_an_inhibitor_arc_limits_what_gathers() -> None:
    for weight, expected in ((1, 2), (3, 4)):
        one = TimedTransition("t0", {0: 1}, {0: 1, 1: 2}, {}, {1: weight}, 0, None, False, False, frozenset())
        two = TimedTransition("t1", {1: 1}, {}, {}, {}, 0, None, False, False, frozenset())
        net = RandomNet((1, 0), [one, two], ())
        assert max(max(marking) for marking in net.regions().markings) == expected
        assert without_times(timed_subject_of(model_of(net)), Budget(seconds=60)).most == expected


def chained_net(random: Random) -> RandomNet:
    """Return timers whose strikes pass through places, mostly at once; the last place is emptied."""
    timers, length = random.randint(1, 2), random.randint(2, 3)
    steps: list[TimedTransition] = []
    last = timers + length - 1

    def made(take: dict[int, int], put: dict[int, int], first: int, latest: int | None) -> None:
        name = f"t{len(steps)}"
        steps.append(TimedTransition(name, take, put, {}, {}, first, latest, False, False, frozenset()))

    for clock in range(timers):
        period = random.randint(1, 2)
        made({clock: 1}, {clock: 1, timers: 1}, period, period)
    for place in range(timers, last):
        made({place: 1}, {place + 1: random.randint(1, 2)}, 0, random.choice((0, 0, 0, 0, 1)))
    made({last: 1}, {}, 0, random.choice((0, 0, 0, None)))
    if random.random() < 0.2:
        made({last: 1}, {timers: 1}, 0, 0)
    return RandomNet((*[1] * timers, *[0] * length), steps, ())


def test_what_passes_on_at_once_is_bounded_as_what_it_comes_from() -> None:
    bounded = gathering = 0
    for seed in range(40):
        net = chained_net(Random(seed))
        subject = timed_subject_of(model_of(net))
        most = without_times(subject, Budget(seconds=60)).most
        alone = without_times(subject, Budget(seconds=60, states=1)).most
        try:
            held = max(max(marking) for marking in net.regions(2_000).markings)
        except OverflowError:
            gathering += 1
            assert most is None and alone is None, seed
            continue
        assert all(each is None or held <= each for each in (most, alone)), seed
        bounded += most is not None
    assert min(bounded, gathering) >= 8, (bounded, gathering)
