"""The verdict on a recording: whether the model has a run that shows its messages."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

from dineros.analysis.witnesses.first_cause import Cause
from dineros.analysis.witnesses.witness import Witness
from dineros.observation.explaining.silences import Silence


@dataclass(frozen=True)
class Unexplained:
    """The first message that no run shows."""

    number: int
    """Of the recorded messages on topics of the model, from 1."""
    topic: str
    """Full name of its topic."""
    time: int
    """When it was received, in nanoseconds."""
    seconds: float
    """The same, since the first message on a topic of the model."""
    possible: tuple[str, ...]
    """Topics on which the model could have shown a message then."""
    publishers: tuple[str, ...]
    """Node nets that publish on its topic."""

    def __str__(self) -> str:
        if not self.publishers:
            reason = "no node of the model publishes on it"
        elif self.possible:
            reason = f"the next message could only be on {_or(self.possible)}"
        else:
            reason = "no further message was possible"
        where = f"message {self.number:,}, on {self.topic}, {self.seconds:.3f} s after the first"
        return f"{where}: no run of the model explains it; {reason}"


@dataclass(frozen=True)
class RecordingVerdict:
    """Whether a model explains a recording."""

    status: Literal["conforms", "violated", "unknown"]
    """The answer."""
    messages: int = 0
    """The number of explained messages on topics of the model."""
    unexplained: Unexplained | None = None
    """The first that has none."""
    reason: str = ""
    """Why the answer is unknown."""
    hidden: tuple[str, ...] = ()
    """Topics of the model that were not recorded: their messages may come at any time."""
    others: tuple[str, ...] = ()
    """Recorded topics that the model does not have: they are left out."""
    silences: tuple[Silence, ...] = ()
    """Topics that fell silent although the model must continue, if all messages have an explanation."""
    untold: tuple[str, ...] = ()
    """If the nodes may have run before the recorder: topics and events over which parts of the model depend
    on each other that were taken to begin independently. Then more may conform than the model allows. Empty
    if the run begins in a state that the model can reach.
    """
    run: Witness | None = None
    """A run that shows the last messages with an explanation."""
    cause: Cause | None = None
    """Where it may have begun that the next message could not come after this run."""

    def to_dict(self, model: str) -> dict[str, Any]:
        """Return the verdict for JSON."""
        first = self.unexplained
        return {
            "model": model,
            "status": self.status,
            "messages": self.messages,
            "unexplained": first
            and {
                "number": first.number,
                "topic": first.topic,
                "time": first.time,
                "seconds": first.seconds,
                "possible": list(first.possible),
                "publishers": list(first.publishers),
            },
            "reason": self.reason,
            "hidden": list(self.hidden),
            "others": list(self.others),
            "silences": [asdict(each) for each in self.silences],
            "untold": list(self.untold),
        }


def _or(names: tuple[str, ...]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} or {names[-1]}"
