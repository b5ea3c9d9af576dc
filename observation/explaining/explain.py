"""Decides whether a model has a run that shows the messages of a recording, in their order."""

from __future__ import annotations

import gc
from collections.abc import Callable, Collection, Iterable
from dataclasses import replace

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.witnesses.first_cause import blocked_cause
from dineros.analysis.witnesses.witness import Witness
from dineros.metamodel import sym
from dineros.metamodel.errors import BudgetError
from dineros.observation.explaining.following import Follower
from dineros.observation.explaining.midway import follower_midway, untold
from dineros.observation.explaining.ordering import Ordering, SeenMessage
from dineros.observation.explaining.parts import ASSUMED
from dineros.observation.explaining.runs import run_of
from dineros.observation.explaining.shown import shown_net
from dineros.observation.explaining.silences import Rhythm, Silence, unexpected
from dineros.observation.explaining.verdict import RecordingVerdict, Unexplained
from dineros.observation.systems import RecordedTopic, full_name, is_house_topic, is_of_action

TOLERANCE = 0.001
"""Seconds within which a recorder may have received messages of different topics in another order."""

COLLECT_EVERY = 200_000
"""Objects created between two garbage collections: the caches are large and rarely become garbage."""

TELL_EVERY = 1 << 14
"""Messages between two calls of `progress`."""


class Explainer:
    """Searches for a run of a model that shows messages, one at a time, in bounded memory.

    Parameters
    ----------
    recorded : collection of RecordedTopic
        The recorded topics; other topics of the model may have any messages.
    tolerance : float
        Seconds: messages of different topics that are no farther apart may have been published in any order.
    midway : bool
        Whether the nodes may have run before the first message.
    budget : Budget, optional
        The budget of the sets of markings.

    Raises
    ------
    DinerosError
        No topic of the model was recorded.
    BudgetError
        The model has too many markings.
    """

    def __init__(
        self,
        model: sym.SystemModel,
        recorded: Collection[RecordedTopic],
        *,
        tolerance: float = TOLERANCE,
        midway: bool = False,
        budget: Budget = UNLIMITED,
    ) -> None:
        self._net = shown_net(model, {topic.name for topic in recorded})
        budget = budget.begun()
        self._follower = follower_midway(self._net, budget) if midway else Follower(self._net, budget)
        self._start = self._follower.start(midway)
        self._midway = midway
        self._ordering = Ordering(self._follower, self._start, round(tolerance * 1e9))
        self._count = 0
        self._first = self._last = 0
        self._rhythms: dict[str, Rhythm] = {}
        self._others = tuple(
            sorted(
                topic.name
                for topic in recorded
                if topic.name not in self._net.shown
                and not is_house_topic(topic.name, topic.type)
                and not is_of_action(topic.name)
            )
        )

    @property
    def topics(self) -> Collection[str]:
        """Full names of the topics whose messages count."""
        return self._net.shown.keys()

    def add(self, topic: str, time: int) -> Unexplained | None:
        """Process the next message; return the first one that no run shows, None if there is none yet.

        Raises
        ------
        BudgetError
            There are too many explanations of the messages.
        """
        if not self._count:
            self._first = time
        self._last = max(self._last, time)
        self._count += 1
        rhythm = self._rhythms.get(topic)
        if rhythm is None:
            self._rhythms[topic] = Rhythm(time, time)
        else:
            rhythm.add(time)
        return self._named(self._ordering.add(SeenMessage(self._count, topic, self._last)))

    def finish(self) -> Unexplained | None:
        """Process the end of the recording; return the first message that no run shows, or None."""
        return self._named(self._ordering.finish())

    def silences(self, end: int) -> tuple[Silence, ...]:
        """Return the topics that fell silent although the model must continue; call it after `finish`.

        `end`: when the recording ends, in nanoseconds.

        Raises
        ------
        BudgetError
            The memory does not suffice to decide.
        """
        found = [each for topic, rhythm in self._rhythms.items() if (each := rhythm.silence(topic, end))]
        if not found or len(found) == len(self._rhythms):
            return ()
        return unexpected(self._follower, self._ordering.last, found)

    @property
    def explained(self) -> int:
        """The number of explained messages."""
        return self._count - len(self._ordering.open)

    @property
    def is_certain(self) -> bool:
        """Whether the absence of an explanation is exact, and not due to a limit."""
        return self._follower.is_certain

    def run(self) -> tuple[Witness, bool]:
        """Return a run that shows the last explained messages, and whether it begins at the start."""
        start, topics, is_whole = self._ordering.trail()
        is_beginning = is_whole and not self._midway
        return run_of(self._follower, start, topics, is_beginning=is_beginning), is_beginning

    def verdict(self, unexplained: Unexplained | None = None) -> RecordingVerdict:
        """Return the result so far."""
        found = RecordingVerdict(
            "conforms",
            self.explained,
            unexplained,
            hidden=self._net.hidden,
            others=self._others,
            untold=untold(self._follower) if self._midway else (),
        )
        if unexplained is None:
            return found
        found = replace(found, messages=unexplained.number - 1)
        if not self.is_certain:
            return replace(
                found,
                status="unknown",
                reason=f"{unexplained}, if no place holds more than {ASSUMED} tokens more than at the start; "
                "some places are unbounded",
            )
        run, _ = self.run()
        publishing = self._net.shown[unexplained.topic]
        names = run.subject.net.transitions if run.subject is not None else ()
        causes = (blocked_cause(run, names[transition]) for transition in publishing)
        return replace(found, status="violated", run=run, cause=next((one for one in causes if one), None))

    def _named(self, seen: SeenMessage | None) -> Unexplained | None:
        if seen is None:
            return None
        return Unexplained(
            seen.number,
            seen.topic,
            seen.time,
            (seen.time - self._first) / 1e9,
            tuple(sorted(self._ordering.possible())),
            self._net.nodes_of(seen.topic),
        )


def explain(
    model: sym.SystemModel,
    recorded: Collection[RecordedTopic],
    messages: Iterable[tuple[str, int]],
    *,
    tolerance: float = TOLERANCE,
    midway: bool = False,
    budget: Budget = UNLIMITED,
    progress: Callable[[int], None] | None = None,
) -> RecordingVerdict:
    """Decide whether a model has a run that shows messages, in their order.

    Parameters
    ----------
    model, recorded, tolerance, midway, budget
        As for `Explainer`.
    messages : iterable of (str, int)
        Full name of the topic and time in nanoseconds of each message, in order of their times.
    progress : callable, optional
        Called from time to time with the number of messages read.

    Raises
    ------
    DinerosError
        No topic of the model was recorded, or the messages cannot be read.
    """
    names = {topic.name for topic in recorded}
    explainer = None
    thresholds = gc.get_threshold()
    gc.set_threshold(COLLECT_EVERY, *thresholds[1:])
    try:
        explainer = Explainer(model, recorded, tolerance=tolerance, midway=midway, budget=budget)
        counted, add = explainer.topics, explainer.add
        end = 0
        for number, (topic, time) in enumerate(messages):
            end = max(end, time)
            if topic in counted:
                unexplained = add(topic, time)
                if unexplained is not None:
                    return explainer.verdict(unexplained)
            if progress is not None and not number % TELL_EVERY:
                progress(number)
        unexplained = explainer.finish()
        if unexplained is not None:
            return explainer.verdict(unexplained)
        silences = explainer.silences(end)
        return replace(explainer.verdict(), status="violated" if silences else "conforms", silences=silences)
    except BudgetError as error:
        reason = str(error)
        if explainer is None:
            return RecordingVerdict("unknown", reason=reason, hidden=_hidden(model, names))
        return replace(explainer.verdict(), status="unknown", reason=reason)
    finally:
        gc.set_threshold(*thresholds)


def _hidden(model: sym.SystemModel, recorded: Collection[str]) -> tuple[str, ...]:
    topics = {full_name(each.topic) for each in model.channels if isinstance(each, sym.TopicChannel)}
    return tuple(sorted(topics - set(recorded)))
