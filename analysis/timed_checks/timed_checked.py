"""The model checked with times, and the facts known about it so far."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from dineros.analysis.checks.question import Checked
from dineros.analysis.timed.exploring import Explored
from dineros.analysis.timed.timed_subject import TimedSubject
from dineros.analysis.timed_checks.timed_walks import Walked
from dineros.metamodel import sym
from dineros.metamodel.guards.using import guarded


@dataclass
class TimedChecked(Checked):
    """A model under a check with times."""

    explored: Explored = field(init=False)
    """Its state classes; there once `TimedBoundedness` has been asked."""
    walked: Walked = field(default_factory=Walked)
    """What random runs met, if not all state classes were built."""
    waits: list[tuple[bool, bool]] = field(default_factory=list)
    """By callback whether it can wait forever, and whether no run stays in it forever; empty if it was not
    asked.
    """

    @cached_property
    def ending_by_bounds(self) -> set[sym.CallbackPage]:
        """Callbacks of which each run ends, as bounds of response times prove."""
        from dineros.analysis.bounds.losses import always_ending

        if guarded(self.subject.model):
            return set()
        return always_ending(self.subject, {each.page for each in self.waiting.callbacks.values()})

    @property
    def timed(self) -> TimedSubject:
        """The net with its times."""
        assert isinstance(self.subject, TimedSubject)
        return self.subject


def with_times(checked: Checked) -> TimedChecked:
    """Return what is checked as such with times; questions of a check with times ask only of those."""
    assert isinstance(checked, TimedChecked)
    return checked
