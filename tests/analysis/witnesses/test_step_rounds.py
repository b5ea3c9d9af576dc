"""Steps in rounds say, together with their times, what all steps in order say."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from dineros.analysis.model.subject import FiringTime
from dineros.analysis.witnesses.step_rounds import StepRound, step_rounds


def steady(times: list[float]) -> list[FiringTime]:
    return [FiringTime(at, at, at) for at in times]


def test_a_timer_that_ticks_is_listed_once() -> None:
    times = steady([round(0.1 * n, 9) for n in range(1, 9) for _ in range(2)])
    (rounds,) = step_rounds(["tick", "send"] * 8, times)
    assert rounds == StepRound(1, ("tick, at 0.1", "send, at 0.1"), 8, "0.1")
    assert rounds.heading == "the next 2 steps 8 times, 0.1 later each time, up to step 16:"


def test_a_timer_that_becomes_slower_is_no_round() -> None:
    times = steady([0.1 * n * n for n in range(8)])
    assert [each.times for each in step_rounds(["tick"] * 8, times)] == [1] * 8


def test_what_repeats_at_one_time_is_not_later() -> None:
    (found,) = step_rounds(["pass", "take"] * 5, steady([3] * 10))
    assert (found.times, found.later) == (5, "")
    assert found.heading == "the next 2 steps 5 times, up to step 10:"


def test_two_periods_in_one_round_are_named_by_step() -> None:
    # A callback of 36 ms and a timer of 33 ms: in each round, it ends 3 ms later after the tick.
    times = steady(
        [at for n in range(6) for at in (0.033 * n, 0.033 * n, 0.009 + 0.036 * n, 0.009 + 0.036 * n)]
    )
    (found,) = step_rounds(["tick", "send", "end", "begin"] * 6, times)
    assert found.heading == "the next 4 steps 6 times, up to step 24:"
    assert found.steps == (
        "tick, at 0, 0.033 later each time",
        "send, at 0, 0.033 later each time",
        "end, at 0.009, 0.036 later each time",
        "begin, at 0.009, 0.036 later each time",
    )


def test_schedules_that_drift_apart_say_so() -> None:
    times = [FiringTime(2 * n, n, 3 * n) for n in range(8)]
    assert step_rounds(["tick"] * 8, times)[-1].later == "2 (the earliest time 1, the latest 3)"
    times = [FiringTime(n, n, None) for n in range(8)]
    assert step_rounds(["tick"] * 8, times)[-1].later == "1"


def test_without_times_the_words_alone_repeat() -> None:
    (found,) = step_rounds(["ask", "answer"] * 5, before=3)
    assert found == StepRound(4, ("ask", "answer"), 5)
    assert found.heading == "the next 2 steps 5 times, up to step 13:"


@given(st.lists(st.tuples(st.sampled_from("ab"), st.integers(0, 2)), max_size=40), st.booleans())
def test_rounds_tell_all_steps(steps: list[tuple[str, int]], is_timed: bool) -> None:
    texts, at, times = [text for text, _ in steps], 0, list[FiringTime]()
    for _, later in steps:
        at += later
        times.append(FiringTime(at, at, at))
    told, number = [], 1
    for found in step_rounds(texts, times if is_timed else ()):
        assert found.first == number
        for round in range(found.times):
            for step in found.steps:
                text, _, when = step.partition(", at ")
                when, _, own = when.removesuffix(" later each time").partition(", ")
                told.append((text, int(when) + round * int(own or found.later or 0) if is_timed else None))
        number = found.last + 1
    assert told == [(text, time.at if is_timed else None) for text, time in zip(texts, times, strict=True)]
