"""Checks with times: against the regions of random nets, and of models with faults of time."""

from __future__ import annotations

import re
from pathlib import Path
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.stages import Share
from dineros.analysis.checks.check import FAULTS, check
from dineros.analysis.timed.growth import growing_loop
from dineros.analysis.timed.nets import compile_timed_net
from dineros.analysis.timed.timed_subject import signals_matter
from dineros.analysis.timed_checks import boundedness
from dineros.analysis.timed_checks.faults import TIMED_FAULTS
from dineros.analysis.timed_checks.faults_of_time import NO_LOOP
from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.analysis.witnesses.findings import Finding, Report
from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow, inhibit, node_net, place, read, step
from dineros.metamodel.elements import find, node_net_of
from dineros.metamodel.errors import DinerosError
from tests.analysis.timed.time_nets import RandomNet, lively_net
from tests.support.systems.talker import talker


def model_of(net: RandomNet) -> pn.Net:
    """Return a random net as a model; its unit of time is one."""
    places = [pn.Place(id=f"p{p}", tokens=tokens) for p, tokens in enumerate(net.initial)]
    page = pn.Page(id="page", objects=list(places))
    made = []
    for one in net.transitions:
        interval = pn.TimeInterval(
            earliest=float(one.earliest),
            latest=None if one.latest is None else float(one.latest),
            earliestExcluded=one.is_open_below,
            latestExcluded=one.is_open_above,
        )
        transition = pn.Transition(id=one.name, interval=interval)
        page.objects.append(transition)
        made.append(transition)
        for join, row in ((flow, one.take), (read, one.read), (inhibit, one.inhibitor)):
            for p, weight in row.items():
                join(places[p], transition, weight=weight)
        for p, weight in one.put.items():
            flow(transition, places[p], weight=weight)
    for high, low in net.pairs:
        made[high].overrides.append(made[low])
    return pn.Net(id="net", pages=[page])


def found(report: Report, rule: str) -> list[Finding]:
    return [each for each in report.findings if each.rule == rule]


@pytest.mark.long
@pytest.mark.parametrize("seed", range(40))
def test_answers_are_those_of_the_regions(seed: int) -> None:
    net = lively_net(Random(seed), has_priorities=seed % 3 == 0)
    regions = net.regions()
    report = check_timed(model_of(net))
    assert not report.unknown and not report.failures
    fires = {net.transitions[t].name for fired in regions.fires.values() for t, _ in fired}
    enabled = {net.transitions[t].name for _, clocks in regions.fires for t, _, _ in clocks}
    all_of_it = {one.name for one in net.transitions}
    assert {each for one in found(report, "never-in-time") for each in one.elements} == enabled - fires
    assert {each for one in found(report, "dead-transition") for each in one.elements} == all_of_it - enabled
    ends = {marking for marking, clocks in regions.fires if not clocks}
    assert bool(found(report, "deadlock")) == bool(ends)
    assert bool(found(report, "time-stops")) == has_loop_at_once(net)
    crowded = any(tokens > 1 for marking in regions.markings for tokens in marking)
    assert bool(found(report, "not-one-safe")) == crowded
    for finding in report.findings:
        if finding.witness is not None:
            assert all(step.time is not None for step in finding.witness.steps)


def has_loop_at_once(net: RandomNet) -> bool:
    """Whether regions repeat by firings of transitions that fire at once, by depth-first search."""
    at_once = {t for t, one in enumerate(net.transitions) if one.latest == 0}
    fires = net.regions().fires
    done: set[object] = set()
    for root in fires:
        way, on_way = [(root, iter(fires[root]))], {root}
        while way:
            here, rest = way[-1]
            for t, after in rest:
                if t not in at_once or after in done:
                    continue
                if after in on_way:
                    return True
                on_way.add(after)
                way.append((after, iter(fires[after])))
                break
            else:
                way.pop()
                on_way.discard(here)
                done.add(here)
    return False


def plain_net(*steps: tuple[str, str, str, float, float | None], tokens: str) -> pn.Net:
    """Return a net of transitions: name, places it takes from and puts to, bounds; marked places."""
    names = sorted({p for _, a, b, _, _ in steps for p in (*a.split(), *b.split())})
    places = {p: pn.Place(id=p, tokens=tokens.split().count(p)) for p in names}
    page = pn.Page(id="page", objects=list(places.values()))
    for name, sources, targets, earliest, latest in steps:
        transition = pn.Transition(id=name, interval=pn.TimeInterval(earliest=earliest, latest=latest))
        page.objects.append(transition)
        for p in sources.split():
            flow(places[p], transition)
        for p in targets.split():
            flow(transition, places[p])
    return pn.Net(id="net", pages=[page])


def test_tokens_that_grow_for_ever_are_found_with_a_loop_that_has_a_schedule() -> None:
    slow = plain_net(
        ("tick", "clock", "clock queue", 10, 10), ("take", "queue busy", "busy", 20, 30), tokens="clock busy"
    )
    report = check_timed(slow)
    (finding,) = found(report, "unbounded")
    assert finding.elements == ("queue",)
    assert finding.witness is not None and finding.witness.loop is not None
    quick = plain_net(
        ("tick", "clock", "clock queue", 10, 10), ("take", "queue busy", "busy", 2, 3), tokens="clock busy"
    )
    assert found(check(quick), "unbounded")
    report = check_timed(quick)
    assert not found(report, "unbounded") and not report.unknown
    assert "the net is bounded with its times: 2 markings, at most 1 token in a place" in report.proved


def test_a_loop_that_further_tokens_change_is_not_taken_for_growth() -> None:
    # Three tokens in p let stop fire at once, which ends the loop.
    net = plain_net(("make", "run", "run p", 5, 5), ("stop", "p run", "end", 0, 0), tokens="run")
    for arc in net.pages[0].arcs:
        if (arc.source.id, arc.target.id) == ("p", "stop"):
            arc.weight = 3
    report = check_timed(net)
    assert not found(report, "unbounded")
    assert not report.unknown


def test_growth_needs_tokens_that_change_nothing() -> None:
    ticking = compile_timed_net(plain_net(("tick", "clock", "clock queue", 1, 2), tokens="clock"))
    loop = growing_loop(ticking, [0, 0])
    assert loop is not None and (loop.prefix, loop.suffix) == ((), (0,))
    assert growing_loop(ticking, []) is None


def test_what_has_not_ended_is_unknown_with_its_reason() -> None:
    """Transition ``late`` is always too late, which only classes tell."""
    steps = ("a", "p", "q", 1, 2), ("b", "q", "p", 1, 2), ("c", "r", "s", 9, 10), ("late", "r", "s", 11, 12)
    report = check_timed(plain_net(*steps, tokens="p r"), Budget(memory_bytes=1))
    assert [each.question for each in report.unknown if each.may_be_fault] == [
        "whether these can ever be used: late"
    ]
    assert "no deadlock" in report.proved and NO_LOOP in report.proved
    assert all("memory ran out" in each.reason for each in report.unknown)


def test_a_check_without_a_limit_ends_if_there_are_too_many_classes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Twelve timers whose periods have no common divisor have more classes than can be built."""
    monkeypatch.setattr(boundedness, "FIRST", Share(time=0.1, most_seconds=0.2))
    monkeypatch.setattr(boundedness, "ALL_SECONDS", 4.0)
    monkeypatch.setattr(boundedness, "part_of_firing", lambda *_: None)
    periods = (7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47)
    steps = [(f"t{period}", f"p{period}", f"p{period}", period, period + 1) for period in periods]
    late = ("on", "r", "s", 9, 10), ("late", "r", "s", 11, 12)
    tokens = " ".join(["r", *(f"p{period}" for period in periods)])
    report = check_timed(plain_net(*steps, *late, tokens=tokens))
    assert "no deadlock" in report.proved
    assert [each.question for each in report.unknown if each.may_be_fault] == [
        "whether these can ever be used: late"
    ]
    assert all("time ran out" in each.reason for each in report.unknown)


def test_time_stops_in_a_loop_of_firings_at_once() -> None:
    net = plain_net(("start", "s", "p", 2, 3), ("a", "p", "q", 0, 0), ("b", "q", "p", 0, 0), tokens="s")
    (finding,) = found(check_timed(net), "time-stops")
    assert finding.elements == ("a", "b")
    assert finding.witness is not None
    assert [step.transition for step in finding.witness.steps] == ["start", "a", "b"]
    assert finding.witness.loop == 1
    may_wait = plain_net(("start", "s", "p", 2, 3), ("a", "p", "q", 0, 0), ("b", "q", "p", 0, 1), tokens="s")
    report = check_timed(may_wait)
    assert not found(report, "time-stops")
    assert "no loop of firings happens in no time" not in report.proved  # it can, if nothing waits
    assert NO_LOOP in report.proved


@pytest.mark.parametrize(
    ("back", "is_noted"), [((0, 1), True), ((0, 0.5), True), ((0.5, 1), False), ((0, None), False)]
)
def test_a_loop_that_may_take_no_time_is_a_note(back: tuple[float, float | None], is_noted: bool) -> None:
    net = plain_net(
        ("start", "s", "p", 2, 3),
        ("a", "p", "q", 0, 0),
        ("b", "q", "p", *back),
        ("end", "z", "", 9, 9),
        tokens="s z",
    )
    report = check_timed(net)
    notes = found(report, "loop-in-no-time")
    assert bool(notes) == is_noted and not found(report, "time-stops") and NO_LOOP in report.proved
    for note in notes:
        assert (note.severity, note.elements) == ("note", ("a", "b"))
        assert note.witness is not None and note.witness.loop == 1
        assert {step.time and step.time.at for step in note.witness.steps} == {2.0}


def test_a_loop_of_open_intervals_takes_time() -> None:
    net = plain_net(("a", "p", "q", 0, 0), ("b", "q", "p", 0, 1), tokens="p")
    find(net, "b", pn.Transition).interval.earliestExcluded = True  # type: ignore[union-attr]
    report = check_timed(net)
    assert not found(report, "loop-in-no-time") and not found(report, "time-stops")


def test_a_system_model_has_no_such_note() -> None:
    model = sym.SystemModel(id="robot")
    node = node_net(model, "node")
    p, q = place(node, "p", tokens=1), place(node, "q")
    for name, source, target in (("a", p, q), ("b", q, p)):
        step(node, name, [source], [target]).interval = pn.TimeInterval(earliest=0.0, latest=1.0)
    report = check_timed(model)
    assert NO_LOOP in report.proved and not found(report, "loop-in-no-time")


def held(*higher: str, loop: tuple[float, float | None] = (0, None)) -> pn.Net:
    """Return a net in which `work` has to fire within 1, and a loop of two others has priority over it."""
    net = plain_net(
        ("start", "s", "r p", 2, 3),
        ("a", "p", "q", *loop),
        ("b", "q", "p", *loop),
        ("work", "r", "s2", 1, 1),
        tokens="s",
    )
    for name in higher:
        find(net, name, pn.Transition).overrides.append(find(net, "work", pn.Transition))
    return net


def test_priorities_that_keep_time_from_going_on() -> None:
    (finding,) = found(check_timed(held("a", "b")), "time-stops")
    assert sorted(finding.elements) == ["a", "b", "work"]
    assert "keep work from firing, which has to fire" in finding.message
    assert finding.witness is not None and finding.witness.loop is not None
    repeated = finding.witness.steps[finding.witness.loop :]
    assert {step.transition for step in repeated} == {"a", "b"}


@pytest.mark.parametrize(
    "net", [held("a"), held(), held("a", "b", loop=(0.5, None)), held("a", "b", loop=(0.25, 2))]
)
def test_priorities_that_give_others_their_turn(net: pn.Net) -> None:
    report = check_timed(net)
    assert not found(report, "time-stops") and not report.unknown


def test_classes_are_built_only_for_loops_that_may_take_no_time(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise AssertionError("a graph is built")

    monkeypatch.setattr("dineros.analysis.timed_checks.standing_time.timed_graph", refuse)
    report = check_timed(held("a", "b", loop=(0.5, None)))
    assert not report.unknown and not report.failures
    assert check_timed(held("a", "b")).failures


def test_tokens_that_grow_at_once_stop_time_too() -> None:
    net = plain_net(("burst", "on", "on heap", 0, 0), tokens="on")
    report = check_timed(net)
    assert found(report, "time-stops") and found(report, "unbounded")


def test_priorities_in_a_circle_end_time() -> None:
    net = plain_net(("a", "p", "q", 1, 1), ("b", "p", "q", 1, 1), tokens="p")
    a, b = (node for node in net.pages[0].objects if isinstance(node, pn.Transition))
    a.overrides.append(b)
    b.overrides.append(a)
    (finding,) = found(check_timed(net), "time-lock")
    assert set(finding.elements) == {"a", "b"}


def test_without_intervals_a_check_answers_as_without_times() -> None:
    for model in (talker(), plain_net(("a", "p", "q", 0, None), tokens="p")):
        plain, timed = check(model), check_timed(model)
        assert (plain.findings, plain.proved, plain.unknown) == (timed.findings, timed.proved, timed.unknown)
        assert timed.times is None


def test_with_signals_the_end_of_a_scenario_is_no_fault_and_what_waits_is() -> None:
    """At the start only a signal can change. This is not a deadlock: the transition waits for the signal."""
    model = talker()
    find(model, "Say", sym.Transition).interval = pn.TimeInterval(earliest=2, latest=3)
    assert signals_matter(model)
    (rest,) = found(check_timed(model), "deadlock")
    assert rest.severity == "note"
    assert rest.witness is not None and len(rest.witness.steps) > 3

    listen = find(model, "Listen", sym.Transition)
    missing = sym.Place(id="Missing")
    assert listen.page is not None
    listen.page.objects.append(missing)
    flow(missing, listen)
    waits = found(check_timed(model), "deadlock")
    assert [each.severity for each in waits if "Listen" in each.message] == ["warning"]


def test_findings_about_models_have_schedules() -> None:
    model = talker()
    model.channels[0].publishers[0].limit = 1  # type: ignore[attr-defined]
    say = find(model, "Say", sym.Transition)
    say.interval = pn.TimeInterval(earliest=2, latest=3)
    assert signals_matter(model)
    report = check_timed(model)
    (overflow, *_) = found(report, "queue-overflow")
    assert overflow.witness is not None
    steps = overflow.witness.steps
    assert sum(step.transition.startswith("Say") for step in steps) >= 2
    assert [step.time.earliest for step in steps if step.time is not None][-1] == 4
    assert report.times is not None and report.times.count == 1


def test_a_part_that_always_comes_too_late_is_never_used() -> None:
    model = talker()
    say = find(model, "Say", sym.Transition)
    node, words = node_net_of(say), find(model, "Words", sym.Place)
    words.tokens = 1
    assert node is not None
    say.clause = None
    say.interval = pn.TimeInterval(earliest=2, latest=3)
    forget = sym.Transition(id="Forget", interval=pn.TimeInterval(earliest=0, latest=1))
    node.objects.append(forget)
    flow(words, forget)
    assert not found(check(model), "unused-topic")
    report = check_timed(model)
    assert found(report, "unused-topic")
    (late,) = found(report, "never-in-time")
    assert late.elements == ("Say",)
    assert not [one for one in found(report, "dead-transition") if "Say" in one.elements]


@pytest.mark.parametrize(
    ("text", "expected", "rule"),
    [
        ("never Noted >= 1", True, "property-violated"),
        ("never Noted >= 9", True, None),
        ("Noted >= 9 is possible", True, "property-violated"),
        ("Noted >= 1 is possible", True, None),
        ("fired(Say) leads to Noted >= 1", True, "property-violated"),
    ],
)
def test_stored_properties(text: str, expected: bool, rule: str | None) -> None:
    model = talker()
    find(model, "Say", sym.Transition).interval = pn.TimeInterval(earliest=1, latest=1)
    model.properties.append(sym.Property(id="asked", text=text, expected=expected))
    report = check_timed(model)
    rules = [each.rule for each in report.findings if each.rule.startswith("property")]
    assert rules == ([] if rule is None else [rule])
    assert bool(rule) != any("property asked" in line for line in report.proved)


def test_what_fairness_decides_is_left_open() -> None:
    model = talker()
    find(model, "Say", sym.Transition).interval = pn.TimeInterval(earliest=1, latest=1)
    model.properties.append(sym.Property(id="asked", text="Noted >= 1 happens"))
    model.assumptions.append(sym.Fairness(id="fair", of="all"))
    report = check_timed(model)
    (unknown,) = [each for each in report.unknown if "asked" in each.question]
    assert "fair" in unknown.reason


def test_an_empty_interval_is_refused() -> None:
    net = plain_net(("a", "p", "q", 3, 2), tokens="p")
    with pytest.raises(DinerosError, match="transition a"):
        check_timed(net)


def test_the_guide_lists_the_rules_of_time() -> None:
    page = (Path(__file__).parents[3] / "docs" / "time.md").read_text()
    listed = dict(re.findall(r"^\| `([a-z-]+)` \| (error|warning|note) \|", page, re.MULTILINE))
    own = {rule: fault.severity for rule, fault in TIMED_FAULTS.items() if rule not in FAULTS}
    assert listed == own
