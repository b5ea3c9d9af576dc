"""Firing sequences that show findings: their steps, and how they are found and checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from dineros.analysis.answers.outcome import FiredAt
from dineros.analysis.model.subject import FiringTime, Subject
from dineros.analysis.nets.coverability import Pumping
from dineros.analysis.nets.shortening import way_before
from dineros.analysis.nets.witness import WitnessError, last_marking
from dineros.analysis.witnesses.folding import in_rounds
from dineros.analysis.witnesses.order import disorder
from dineros.analysis.witnesses.rounds import MOST_TRIED, repeating_way


@dataclass(frozen=True)
class Step:
    """One firing of a witness.

    Attributes
    ----------
    transition : str
        Id of the transition in the flattened net.
    text : str
        What it means, in the words of the model.
    change : dict of str to int
        Tokens gained or lost, by id of the place.
    time : FiringTime or None
        When it fires, where the net has times.
    """

    transition: str
    text: str
    change: dict[str, int]
    time: FiringTime | None = None

    @property
    def shown(self) -> str:
        """The words, and when it fires where the net has times."""
        return self.text if self.time is None else f"{self.text}, {self.time}"

    def to_dict(self) -> dict[str, Any]:
        """Return the step for JSON; without a time, it has no such field."""
        return {name: value for name, value in asdict(self).items() if name != "time" or value is not None}


@dataclass(frozen=True)
class Witness:
    """A firing sequence from the initial marking, replayed by the plain firing rule.

    Attributes
    ----------
    loop : int or None
        Index of the first step that repeats forever; None for a finite sequence.
    disorder : str
        The queue that a message leaves before an older one, in words, if there is one: see
        `dineros.analysis.witnesses.order`.
    subject : Subject or None
        The net that it is a sequence of.
    """

    steps: tuple[Step, ...]
    loop: int | None = None
    disorder: str = ""
    subject: Subject | None = field(default=None, compare=False, repr=False)

    def ends_at(self, subject: Subject) -> list[int] | None:
        """Return the marking after its steps in a net; None if they are not possible there."""
        numbers = [subject.transition_index.get(step.transition) for step in self.steps]
        trace = [number for number in numbers if number is not None]
        try:
            return last_marking(subject.net, trace) if len(trace) == len(numbers) else None
        except WitnessError:
            return None

    def to_dict(self) -> dict[str, Any]:
        """Return the witness for JSON."""
        found: dict[str, Any] = {"steps": [step.to_dict() for step in self.steps], "loop": self.loop}
        if self.disorder:
            found["disorder"] = self.disorder
        return found


def witness_of(
    subject: Subject, trace: Sequence[int], loop: int | None = None, times: Sequence[FiredAt] = ()
) -> Witness:
    """Replay a sequence of transitions and return it as a witness.

    `times`: when its transitions fire; by default, as the net says.

    Raises
    ------
    NetError
        A transition is not enabled where the sequence fires it: a fault in an engine.
    """
    net = subject.net
    marking = net.initial.tolist()
    steps = []
    chosen = [FiringTime(*time) for time in times] if times else subject.times_of(trace)
    for transition, time in zip(trace, chosen, strict=True):
        marking = net.fire(transition, marking)
        change = {net.places[place]: tokens for place, tokens in net.delta[transition].items()}
        steps.append(Step(net.transitions[transition], subject.transition_text(transition), change, time))
    return Witness(tuple(steps), loop, disorder(subject, trace), subject)


def witness_to(subject: Subject, trace: Sequence[int]) -> Witness:
    """Return a witness of the marking in which a sequence ends; other orders of its firings lead there, too.

    They are put in an order in which rounds repeat, if that is shorter to read. With times the order
    stays: another one may have no schedule.
    """
    return witness_of(subject, trace if subject.is_timed else in_rounds(subject.net, trace))


def witness_of_firing(subject: Subject, trace: Sequence[int], most_tried: int = MOST_TRIED) -> Witness:
    """Return a witness that a sequence's last transition can fire, with rounds that repeat where it is long.

    At most so many firings are tried to find rounds. With times the sequence stays as it is: another one may
    have no schedule.
    """
    if subject.is_timed or not trace:
        return witness_of(subject, trace)
    *way, last = trace
    return witness_of(subject, [*repeating_way(subject.net, way, [last], most_tried), last])


def pumping_witness(subject: Subject, pumping: Pumping) -> Witness:
    """Return the run that makes tokens grow forever; the way to what repeats is short, in an order of rounds.

    With times it stays as it is: another one may have no schedule.
    """
    prefix = pumping.prefix
    if not subject.is_timed:
        way = way_before(subject.net, prefix, pumping.suffix)
        prefix = repeating_way(subject.net, way, pumping.suffix)
    return witness_of(subject, [*prefix, *pumping.suffix], len(prefix))
