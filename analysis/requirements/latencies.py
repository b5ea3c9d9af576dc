"""Properties that bound a latency or a response time, asked of the model with its times."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import Share
from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.latencies.answers import End, Latencies, end_of
from dineros.analysis.latencies.results import Latency
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.model.subject import Subject
from dineros.analysis.requirements.latency_bounds import LatencyBound
from dineros.analysis.symbolic.order_cache import OrderCache
from dineros.analysis.timed.timed_subject import TimedSubject
from dineros.metamodel import sym
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.guards.using import guarded

NO_TIMES = "it bounds a time: use --time and a model with times"
GUARDS = "the model has guards: only safe bounds follow them, and they do not prove it"
BY = "state classes that follow each instance"
BY_BOUNDS = "bounds of response times"
EXACT = Share(time=0.5)
"""Share of the remaining time for the search of exact times."""
DECIDED = Share(time=0.1, most_seconds=10.0)
"""The same if a safe bound has proved the property: the exact time is only more precise."""


@dataclass(frozen=True)
class AskedLatency:
    """A property that bounds a latency, as a question about a model."""

    property: sym.Property
    bound: LatencyBound
    subject: Subject
    """The net, with its times if it is asked with times."""

    def answer(self, budget: Budget, _: OrderCache | None = None) -> Outcome:
        """Decide it, with the run of a longest instance if the bound does not hold.

        Raises
        ------
        FormulaError
            A name is unknown, or no data goes from one end to the other.
        """
        if not isinstance(self.subject, TimedSubject):
            return Outcome("unknown", reason=NO_TIMES)
        budget = budget.begun()
        model = self.subject.model
        assert isinstance(model, sym.SystemModel)
        if guarded(model):
            return self.by_bounds() or Outcome("unknown", reason=GUARDS)
        try:
            first, last = self._ends(model)
            safe = self._safe(first, last)
            is_decided = safe is not None and safe <= self.bound.seconds
            share = (DECIDED if is_decided else EXACT).share(budget)
            asked = Latencies(model, share, self.subject)
            if last is not None:
                found = asked.between(first, last, with_ages=False)
            else:
                assert isinstance(first, sym.CallbackPage)
                found = asked.response(first)
        except DinerosError as error:
            raise FormulaError(error.message, hint=error.hint) from None
        return self._verdict(asked, first, last, found, safe, budget)

    def by_bounds(self) -> Outcome | None:
        """Prove it by safe bounds alone, which is quick at any size; None if they do not prove it."""
        model = self.subject.model
        if not isinstance(self.subject, TimedSubject) or not isinstance(model, sym.SystemModel):
            return None
        try:
            safe = self._safe(*self._ends(model))
        except DinerosError:
            return None  # `answer` says what is wrong
        if safe is None or safe > self.bound.seconds:
            return None
        return Outcome("holds", reason=f"at most {float(safe):g} s", by=BY_BOUNDS)

    def _ends(self, model: sym.SystemModel) -> tuple[End, End | None]:
        first = end_of(model, self.bound.first)
        last = end_of(model, self.bound.last) if self.bound.last else None
        if last is None and not isinstance(first, sym.CallbackPage):
            raise DinerosError(f"{self.bound.first} is not a callback")
        return first, last

    def _safe(self, first: End, last: End | None) -> Fraction | None:
        """Return a safe bound by response-time analysis, for models of any size; None if there is none."""
        assert isinstance(self.subject.model, sym.SystemModel)
        bounds = Bounds(self.subject.model)
        if last is not None:
            found = bounds.between(first, last)
        else:
            assert isinstance(first, sym.CallbackPage)
            found = bounds.response(first)
        return None if found.greatest is None else found.greatest.value

    def _verdict(
        self,
        asked: Latencies,
        first: End,
        last: End | None,
        found: Latency,
        safe: Fraction | None,
        budget: Budget,
    ) -> Outcome:
        seconds, states = self.bound.seconds, found.states
        if found.greatest is None:
            if safe is not None and safe <= seconds:
                return Outcome(
                    "holds", reason=f"at most {float(safe):g} s", seconds=budget.spent, by=BY_BOUNDS
                )
            reason = found.reason or "no instance reaches its end"
            return Outcome("unknown", reason=reason, states=states, seconds=budget.spent)
        time = float(found.greatest.value)
        if found.greatest.value <= seconds:
            lost = "; an instance can be lost" if found.is_lost else ""
            word = "at most" if found.is_exact else "a safe bound is"
            return Outcome(
                "holds", reason=f"{word} {time:g} s{lost}", states=states, seconds=budget.spent, by=BY
            )
        if not found.is_exact:
            reason = f"only a safe bound is known, {time:g} s"
            return Outcome("unknown", reason=reason, states=states, seconds=budget.spent)
        word = "it takes up to" if found.greatest.is_reached else "it takes nearly"
        shown = asked.longest_instance(first, last, found)
        began = "" if shown is None else f", counted from {shown.began:g} s"
        return Outcome(
            "violated",
            None if shown is None else shown.trace,
            times=() if shown is None else shown.times,
            reason=f"{word} {time:g} s{began}",
            states=states,
            seconds=budget.spent,
            by=BY,
            ends_at_fault=True,
        )
