"""Stored properties that random runs decide, where there are too many state classes."""

from __future__ import annotations

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.requirements.stored import Asked, asked
from dineros.analysis.timed.schedules import schedule
from dineros.analysis.timed.timed_subject import TimedSubject, timed_base_subject
from dineros.analysis.timed_checks.shown_by_runs import shown_by_runs
from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.analysis.timed_checks.timed_walks import walk_in_time
from dineros.metamodel import sym
from dineros.metamodel.build import callback, here, node_net, place, seconds, step

FEW = Budget(seconds=60, states=40)
"""So few state classes that they tell nothing."""


def fusing(*properties: str) -> sym.SystemModel:
    """Return a camera, and a node that fuses an image and a depth; callbacks are slow."""
    model = sym.SystemModel(id="sync", middleware="ros2", times=sym.DefaultTimes(latency=seconds(0, 0.002)))
    camera = node_net(model, "camera", execution="callbacks")
    frame = callback(camera, "OnFrame", "timer", 0.03)
    frame.duration = seconds(0, 0.005)
    outs = [place(frame, f"{name}Out") for name in ("Image", "Depth")]
    step(frame, "Grab", [], outs)
    fusion = node_net(model, "fusion", execution="callbacks")
    held = []
    for name, out in zip(("Image", "Depth"), outs, strict=True):
        page = callback(fusion, f"On{name}")
        page.duration = seconds(0, 0.045)
        came = place(page, f"{name}In")
        room, here_ = place(fusion, f"{name}Room", tokens=2), place(fusion, f"{name}Held")
        step(page, f"Keep{name}", [came, here(room, page)], [here(here_, page)])
        held.append((room, here_))
        topic = sym.TopicChannel(id=name, topic=f"/{name.lower()}", model=model)
        topic.publishers.append(sym.PublisherPort(place=out, limit=10))
        topic.subscribers.append(sym.SubscriberPort(place=came, limit=2))
    step(fusion, "Fuse", [each for _, each in held], [each for each, _ in held])
    for number, text in enumerate(properties):
        model.properties.append(sym.Property(id=f"P{number}", text=text))
    return model


def question(text: str, language: str = "words") -> tuple[Asked, TimedSubject]:
    model = fusing(text)
    model.properties[0].language = language
    subject = timed_base_subject(model)
    return asked(model.properties[0], subject), subject


@pytest.mark.parametrize(
    ("text", "status"),
    [
        ("fired(Fuse) is possible", "holds"),
        ("ImageHeld >= 1 and DepthHeld >= 1 is possible", "holds"),
        ("never fired(Fuse)", "violated"),
        ("always ImageHeld = 0", "violated"),
        ("always ImageHeld <= 2", None),
        ("ImageHeld >= 3 is possible", None),
        ("fired(Fuse) leads to fired(Grab)", None),
    ],
)
def test_what_a_run_meets(text: str, status: str | None) -> None:
    ask, subject = question(text)
    runs = walk_in_time(subject.timed, Budget(), runs=4, steps=500).runs
    found = shown_by_runs(ask, runs)
    assert (None if found is None else found.status) == status
    if found is not None:
        assert found.trace is not None
        assert len(schedule(subject.timed, found.trace)) == len(found.trace)


@pytest.mark.parametrize(
    ("formula", "status"),
    [("EF (ImageHeld >= 1)", "holds"), ("AG (ImageHeld = 0)", "violated"), ("AF (ImageHeld >= 1)", None)],
)
def test_branching_time(formula: str, status: str | None) -> None:
    ask, subject = question(formula, "ctl")
    found = shown_by_runs(ask, walk_in_time(subject.timed, Budget(), runs=4, steps=500).runs)
    assert (None if found is None else found.status) == status


def test_what_fires_after_the_end_of_a_run_is_not_known() -> None:
    """The last marking may be left by the firing that the condition asks for."""
    ask, subject = question("always ImageHeld = 0 or fired(Fuse)")
    names = subject.timed.untimed.transitions
    run = next(run for run in walk_in_time(subject.timed, Budget(), runs=4, steps=500).runs)
    index = next(i for i in range(len(run)) if names[run[i]].startswith("Fuse"))
    kept = next(i for i in range(index) if names[run[i]].startswith("Keep"))
    assert shown_by_runs(ask, [run[:kept]]) is None


def test_a_check_without_all_classes_answers_them() -> None:
    model = fusing("fired(Fuse) is possible", "never fired(Fuse)", "always ImageHeld <= 2")
    report = check_timed(model, FEW)
    assert any("P0 holds" in each for each in report.proved)
    (found,) = [each for each in report.findings if each.elements == ("P1",)]
    assert found.rule == "property-violated" and found.witness is not None
    assert not [each for each in report.unknown if "P0" in each.question or "P1" in each.question]


def test_fair_runs_are_not_looked_at() -> None:
    model = fusing("never fired(Fuse)")
    model.assumptions.append(sym.Fairness(of="Fuse"))
    subject = timed_base_subject(model)
    ask = asked(model.properties[0], subject)
    assert shown_by_runs(ask, walk_in_time(subject.timed, Budget(), runs=2, steps=300).runs) is None
