"""Certificates of nets with times: right ones are valid, and none of a wrong answer or another net is."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from random import Random
from typing import Any

import pytest

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.evidence.certificate import difference, sealed
from dineros.analysis.evidence.proving import Asked
from dineros.analysis.evidence.timed_checker import timed_refutation
from dineros.analysis.evidence.timed_proving import timed_certificate
from dineros.analysis.logic.language.syntax import Enabled, Name
from dineros.analysis.nets.witness import WitnessError
from dineros.analysis.questions.engines import Timed
from dineros.analysis.questions.net_questions import Branching, Linear, Marking, Question
from dineros.analysis.questions.net_questions import Enabled as Firing
from dineros.analysis.timed.nets import Interval
from dineros.analysis.timed.schedules import check_times
from dineros.analysis.timed.timed_subject import TimedSubject, timed_subject_of
from tests.analysis.timed.time_nets import RandomNet, lively_net
from tests.analysis.timed_checks.test_timed_check import model_of, plain_net

Case = tuple[Asked, Outcome]


def subject_of(net: RandomNet) -> TimedSubject:
    return timed_subject_of(model_of(net))


def cases(subject: TimedSubject, random: Random) -> Iterator[Case]:
    """Yield questions that certificates know, with their answers."""
    plain, names = subject.net, subject.names
    place, other = (random.choice(plain.places) for _ in range(2))
    fires, bound = random.choice(plain.transitions), random.randint(1, 3)
    tokens, enabled = f"{place} + {other} >= {bound}", str(Enabled(Name(fires)))
    asked: list[tuple[str, str, Question]] = [
        ("enabled", fires, Firing(plain, names, fires)),
        ("marking", tokens, Marking(plain, names, tokens)),
        ("marking", f"{enabled} & {tokens}", Marking(plain, names, f"{enabled} & {tokens}")),
        ("ltl", f"G !fired({fires})", Linear(plain, names, f"G !fired({fires})")),
        ("ltl", f"G !({tokens})", Linear(plain, names, f"G !({tokens})")),
        ("ctl", f"AG !({tokens})", Branching(plain, names, f"AG !({tokens})")),
        ("ctl", f"EF ({tokens})", Branching(plain, names, f"EF ({tokens})")),
    ]
    if not subject.timed.has_priorities:
        asked.append(
            ("marking", f"deadlock & {place} >= 1", Marking(plain, names, f"deadlock & {place} >= 1"))
        )
    for kind, text, question in asked:
        yield Asked(subject, kind, text), Timed(subject.timed).answer(question, Budget())


OPPOSITE = {"reachable": "unreachable", "unreachable": "reachable", "holds": "violated", "violated": "holds"}


@pytest.mark.long
@pytest.mark.parametrize("part", range(2))
def test_right_answers_have_certificates_and_wrong_ones_none(part: int) -> None:
    seen: set[tuple[str, str]] = set()
    for seed in range(part, 60, 2):
        net = lively_net(Random(9_000 + seed), has_priorities=seed % 4 == 3, most=600)
        subject = subject_of(net)
        for asked, answer in cases(subject, Random(seed)):
            certificate = timed_certificate(asked, answer)
            if certificate is None:
                assert subject.timed.has_priorities, (seed, asked.text)
                continue
            assert difference(certificate, subject) == ""
            assert timed_refutation(certificate, subject) == ""
            seen.add((asked.kind, answer.status))
            lie = sealed({**certificate, "answer": OPPOSITE[answer.status]})
            assert timed_refutation(lie, subject)
            if not answer.stem:
                wrong = replace(answer, status=OPPOSITE[answer.status])
                assert timed_certificate(asked, wrong) is None
    assert len(seen) == 8


@pytest.mark.long
def test_classes_that_lack_something_are_refuted() -> None:
    """Dropping a class, a token, or any part of the times of a class is noticed, whoever seals it again."""
    changes = 0
    for seed in range(25):
        subject = subject_of(lively_net(Random(9_500 + seed), most=400))
        asked = Asked(subject, "marking", "p0 >= 100")
        certificate = timed_certificate(asked, Outcome("unreachable"))
        assert certificate is not None
        for changed in damaged(certificate):
            assert difference(changed, subject) == "it was changed after it was written"
            assert timed_refutation(sealed(changed), subject), seed
            changes += 1
    assert changes > 1_000


def damaged(certificate: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield certificates whose classes hold fewer states, each in another way."""

    def without(number: int) -> tuple[dict[str, Any], dict[str, Any]]:
        changed = copy.deepcopy(certificate)
        return changed, changed["classes"][number]

    for number, one in enumerate(certificate["classes"]):
        changed, _ = without(number)
        del changed["classes"][number]
        yield changed
        for place in one["marking"]:
            changed, parts = without(number)
            parts["marking"][place] += 1
            yield changed
        for name, text in one["times"].items():
            low, high = text[1:-1].split(",")
            narrower = [f"{text[0]}{Fraction(low) + Fraction(1, 1000)},{high}{text[-1]}"]
            if text[0] == "[":
                narrower.append(f"]{low},{high}{text[-1]}")
            if high == "w":
                narrower.append(f"{text[0]}{low},1000]")
            else:
                narrower.append(f"{text[0]}{low},{Fraction(high) - Fraction(1, 1000)}{text[-1]}")
                if text[-1] == "]":
                    narrower.append(f"{text[0]}{low},{high}[")
            for each in narrower:
                changed, parts = without(number)
                parts["times"][name] = each
                yield changed
        for at, bound in enumerate(one["differences"]):
            changed, parts = without(number)
            parts["differences"][at]["most"] = str(Fraction(bound["most"]) - Fraction(1, 1000))
            yield changed
            if not bound["strict"]:
                changed, parts = without(number)
                parts["differences"][at]["strict"] = True
                yield changed


@pytest.mark.long
def test_what_passes_of_another_net_is_true_of_it() -> None:
    """A certificate of a net whose intervals differ is refused; forged, it proves only what is true."""
    refuted = passed = 0
    for seed in range(60):
        net = lively_net(Random(9_900 + seed), most=400)
        subject, random = subject_of(net), Random(seed)
        one = random.randrange(len(net.transitions))
        given = net.transitions[one]
        latest = None if given.latest is None or random.random() < 0.2 else given.latest + 1
        net.transitions[one] = replace(given, earliest=max(0, given.earliest - 1), latest=latest)
        other = subject_of(net)
        try:
            regions = net.regions(5_000)
        except OverflowError:
            continue
        fires = {net.transitions[t].name for fired in regions.fires.values() for t, _ in fired}
        for transition in subject.net.transitions:
            asked = Asked(subject, "enabled", transition)
            answer = Timed(subject.timed).answer(Firing(subject.net, subject.names, transition), Budget())
            certificate = timed_certificate(asked, answer)
            assert certificate is not None
            is_same = subject.timed.intervals == other.timed.intervals
            assert (difference(certificate, other) == "it belongs to another net") != is_same
            if timed_refutation(certificate, other):
                refuted += 1
            else:
                passed += 1
                assert (answer.status == "reachable") == (transition in fires), seed
    assert refuted > 20 and passed > 20


@pytest.mark.long
def test_schedules_are_replayed_as_the_other_computation_does() -> None:
    """A replay with clocks and the differences of times accept the same schedules, right and wrong."""
    accepted = refused = 0
    for seed in range(150):
        subject = subject_of(lively_net(Random(10_000 + seed), has_priorities=seed % 2 == 0, most=400))
        random = Random(seed)
        for asked, answer in cases(subject, random):
            if not answer.stem or asked.kind not in ("marking", "enabled"):
                continue
            certificate = timed_certificate(asked, answer)
            assert certificate is not None
            steps = certificate["schedule"]
            for _ in range(6):
                at = random.randrange(len(steps))
                shift = Fraction(random.choice((-2, -1, 1, 2)), random.choice((1, 2)))
                moved = [Fraction(one["at"]) + shift * (n >= at) for n, one in enumerate(steps)]
                trace = [subject.transition_index[one["fires"]] for one in steps]
                if random.random() < 0.2:
                    trace[at] = random.randrange(len(subject.net.transitions))
                try:
                    check_times(subject.timed, trace, moved)
                    is_right = True
                except WitnessError:
                    is_right = False
                names = subject.net.transitions
                rows = [{"fires": names[t], "at": str(time)} for t, time in zip(trace, moved, strict=True)]
                wrong = timed_refutation(sealed({**certificate, "schedule": rows}), subject)
                if is_right:
                    accepted += 1
                    assert wrong in ("", "the schedule does not reach the goal"), (seed, wrong)
                else:
                    refused += 1
                    assert wrong and wrong != "the schedule does not reach the goal", seed
    assert accepted > 100 and refused > 100


def two_steps() -> TimedSubject:
    return timed_subject_of(plain_net(("a", "p", "q", 1, 2), ("b", "q", "r", 0, 1), tokens="p"))


def test_wider_classes_may_prove_the_same() -> None:
    subject = two_steps()
    certificate = timed_certificate(Asked(subject, "marking", "p + q + r >= 2"), Outcome("unreachable"))
    assert certificate is not None
    certificate["classes"][0]["times"]["a"] = "[0,5]"
    assert difference(certificate, subject)
    assert timed_refutation(sealed(certificate), subject) == ""


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"marking": {"x": 1}}, "names 'x'"),
        ({"marking": {"p": -1}}, "negative number of tokens"),
        ({"times": {"b": "[0,1]"}}, "names 'b'"),
        ({"times": {"a": "[2,1]"}}, "holds no state"),
        ({"times": {"a": "1"}}, "not an interval"),
        ({"times": {"a": "[0,1e999999999]"}}, "not an interval"),
        ({"differences": [{"first": "a", "second": "a", "most": "-1", "strict": False}]}, "holds no state"),
        ({"differences": [{"first": "a", "second": "a", "most": "nan", "strict": False}]}, "not a time"),
    ],
)
def test_parts_that_say_nothing_of_the_net_are_refuted(change: dict[str, Any], words: str) -> None:
    subject = two_steps()
    certificate = timed_certificate(Asked(subject, "marking", "q >= 2"), Outcome("unreachable"))
    assert certificate is not None
    certificate["classes"][0] |= change
    assert words in timed_refutation(sealed(certificate), subject)


def test_no_classes_prove_nothing() -> None:
    subject = two_steps()
    certificate = timed_certificate(Asked(subject, "marking", "q >= 2"), Outcome("unreachable"))
    assert certificate is not None
    assert "no class" in timed_refutation(sealed({**certificate, "classes": []}), subject)


@pytest.mark.parametrize(
    ("kind", "text", "status"),
    [
        ("ltl", "F r >= 1", "holds"),
        ("ltl", "F q >= 9", "violated"),
        ("ltl", "G (q >= 1 -> F r >= 1)", "holds"),
        ("ltl", "G (q >= 1 -> F[<=1] r >= 1)", "holds"),
        ("ctl", "AG EF r >= 1", "holds"),
        ("ctl", "AF r >= 1", "holds"),
    ],
)
def test_answers_about_several_moments_have_none(kind: str, text: str, status: str) -> None:
    assert timed_certificate(Asked(two_steps(), kind, text), Outcome(status)) is None


def test_ends_of_nets_with_priorities_have_none() -> None:
    net = plain_net(("a", "p", "q", 1, 2), ("b", "p", "r", 0, 1), tokens="p")
    transitions = {one.id: one for one in net.pages[0].objects}
    transitions["a"].overrides.append(transitions["b"])  # type: ignore[attr-defined]
    subject = timed_subject_of(net)
    assert timed_certificate(Asked(subject, "marking", "deadlock & p >= 1"), Outcome("unreachable")) is None
    assert timed_certificate(Asked(subject, "marking", "p >= 2"), Outcome("unreachable")) is not None


def test_time_that_runs_out_is_told() -> None:
    asked = Asked(two_steps(), "marking", "q >= 2")
    with pytest.raises(BudgetExceededError):
        timed_certificate(asked, Outcome("unreachable"), Budget(seconds=0.0))


def test_intervals_are_part_of_a_net() -> None:
    subject = two_steps()
    certificate = timed_certificate(Asked(subject, "marking", "q >= 2"), Outcome("unreachable"))
    assert certificate is not None
    changed = replace(subject.timed, intervals=(Interval(), *subject.timed.intervals[1:]))
    assert difference(certificate, replace(subject, timed=changed)) == "it belongs to another net"
