"""Whether the net is bounded, the state space that others are asked of, and what places may hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import RAN_OUT, Budget, BudgetExceededError
from dineros.analysis.answers.stages import Share, Stage, run_stages
from dineros.analysis.checks.blocking import Callbacks
from dineros.analysis.checks.overflow import Overflow
from dineros.analysis.checks.question import Checked, Question
from dineros.analysis.checks.remedies import remedy_text
from dineros.analysis.nets.bounds import flows_and_bounds, place_bounds
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError
from dineros.analysis.witnesses.findings import Fault
from dineros.analysis.witnesses.witness import pumping_witness
from dineros.metamodel import sym
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.analysis.nets.coverability import Pumping

# Of most models, all places have bounds: what is about tokens that grow is imported where it is needed.

FIRST_SHARE = 4_000_000
"""Cache misses of saturation, a few seconds, that the state space may cost before a smaller net is asked."""

GROWS = "it is not known that all places are bounded"

PLACES = Share(time=0.05, seconds_if_unlimited=0.3)
"""Share for bounds of places without a state space."""

PARTS_ANSWER = "parts of the net answer the questions"


class _RecurrentError(Exception):
    """A smaller net answers what the state space was made for."""


class _KnownByPartsError(Exception):
    """Parts of the net answer what the state space was made for."""


@dataclass
class _SpaceSearch:
    """The search for the state space, or for a proof that there is none."""

    checked: Checked
    reason: str = RAN_OUT["time"]
    """Why the state space could not be made; empty if it is there."""
    error: Exception | None = None
    """An error that ended the search, other than an exceeded budget."""
    pumpings: Sequence[Pumping] = ()
    """Proofs that places grow without bound."""

    @property
    def can_recur(self) -> bool:
        """Whether a smaller net may answer."""
        return not self.pumpings and (self.error is None or isinstance(self.error, LevelSizeError))

    @property
    def has_unknown_bound(self) -> bool:
        """Whether the bound of a place is missing."""
        return isinstance(self.error, UnknownBoundError)

    @property
    def may_grow(self) -> bool:
        """Whether a place has no simple bound."""
        return any(bound is None for bound in self.checked.subject.net.once(flows_and_bounds)[1])

    def look_near(self, budget: Budget) -> None:
        """Look for growth near the initial marking, and along walks."""
        from dineros.analysis.covering.growth import near_growth

        self._note(near_growth(self.checked.subject.net, budget))

    def make_space(self, budget: Budget) -> None:
        """Make the state space."""
        try:
            self.reason = self._space(budget)
        except UnknownBoundError as error:
            self.reason, self.error = GROWS, error
        except LevelSizeError as error:
            self.reason, self.error = error.message, error
        except Exception as error:
            self.reason, self.error = self.checked.failed(error), error

    def look_far(self, budget: Budget) -> None:
        """Look for growth by all methods."""
        from dineros.analysis.covering.growth import growth_of

        pumping = growth_of(self.checked.subject.net, budget)
        self._note([] if pumping is None else [pumping])

    def _note(self, pumpings: Sequence[Pumping]) -> None:
        self.pumpings = pumpings
        self.reason = GROWS if pumpings else self.reason

    def _space(self, budget: Budget) -> str:
        """Make the state space; return the reason if it could not be made, else an empty text."""
        checked = self.checked
        net, between = checked.subject.net, partial(_look_elsewhere, checked)
        facts = net.once(flows_and_bounds)
        try:
            space = symbolic_state_space(net, budget, orders=checked.orders, between=between, facts=facts)
        except _RecurrentError:
            return "decided on a smaller net"
        except _KnownByPartsError:
            return PARTS_ANSWER
        except BudgetExceededError as limit:
            return str(limit)
        if not space.complete:
            return RAN_OUT[space.reason]
        checked.known.space = checked.report.space = space
        checked.report.by = "decision diagrams: all markings, made once for all questions"
        checked.report.proved.append(
            f"the net is bounded: {space.markings} markings without signals, "
            f"at most {counted(max(space.largest_place(), default=0), 'token')} in a place"
        )
        return ""


def _look_elsewhere(checked: Checked, work: int) -> None:
    """End the search of a large state space if a smaller net, or parts of the net, give the answers.

    Otherwise the search continues. Questions that need no state space are answered before that.
    """
    if work >= FIRST_SHARE:
        if checked.recurrence is not None:
            raise _RecurrentError
        known = checked.by_parts
        Callbacks.ask_early(checked)
        is_open = any(map(known.is_open, range(len(checked.subject.net.transitions))))
        ends = checked.callbacks_known or not checked.waiting.callbacks
        if (
            isinstance(checked.model, sym.SystemModel)
            and all(bound is not None for bound in place_bounds(checked.subject.net))
            and (known.has_no_deadlock and ends and not is_open)
        ):
            raise _KnownByPartsError
        Overflow.ask_early(checked)


PLAN = (
    Stage(_SpaceSearch.look_near, lambda search: search.may_grow, time=0.2, name="whether tokens grow"),
    Stage(_SpaceSearch.make_space, lambda search: not search.pumpings, time=0.6),
    Stage(
        _SpaceSearch.look_far, lambda search: search.has_unknown_bound, time=0.3, name="whether tokens grow"
    ),
)
"""How the state space is made, or growth is proved; the rest of the time is for answers without it."""


def _ask_callbacks(checked: Checked, budget: Budget) -> None:
    Callbacks.ask_early(checked)


def _ask_firings(checked: Checked, budget: Budget) -> None:
    from dineros.analysis.covering.firings import firings

    checked.firings = firings(checked.subject.net, budget, known=checked.firings)


WITHOUT_SPACE = (
    Stage(_ask_callbacks),
    Stage(_ask_firings, time=0.6, name="other questions about the unbounded net"),
)
"""What can be known without a state space."""


class Boundedness(Question):
    """Whether the net is bounded: if so, its state space is what further questions are asked of."""

    UNBOUNDED = Fault(
        "unbounded", "error", "Tokens can grow without bound.", "tokens grow without bound: {places}"
    )
    faults = (UNBOUNDED,)
    asks = "all questions on the state space"
    is_basis = True

    def leave_open(self, checked: Checked, reason: str) -> None:
        """End the search here, as the other questions need the state space."""
        checked.close(self.asks, reason)

    def ask(self, checked: Checked) -> None:
        """Make the state space, or find out what is known without it."""
        search = run_stages(_SpaceSearch(checked), PLAN, checked.budget, given_up=())
        if not search.reason or (search.can_recur and self._recurs(checked)):
            return
        if isinstance(search.error, LevelSizeError):
            checked.close(self.asks, search.reason)
            return
        if not search.pumpings:
            self._without_space(checked, search)
        self._grow(checked, search.pumpings)
        checked.firings = checked.by_parts
        run_stages(checked, WITHOUT_SPACE, checked.budget, given_up=())
        checked.firings.is_late |= checked.budget.is_over
        checked.report.by = f"searches forward and backward, and coverability: {search.reason}"
        if search.reason == PARTS_ANSWER:
            checked.report.by = "parts of the net, each with the places that a question needs"

    @staticmethod
    def _without_space(checked: Checked, search: _SpaceSearch) -> None:
        """Put into the report whether bounds of all places are proved without a state space."""
        if isinstance(search.error, UnknownBoundError):
            checked.leave_open("whether the net is bounded", str(search.error))
            return
        _, bounds = checked.subject.net.once(flows_and_bounds)
        values = [bound.value for bound in bounds if bound is not None]
        if len(values) < len(bounds):
            checked.leave_open("whether the net is bounded", search.reason)
            return
        checked.report.proved.append(
            f"the net is bounded: no place ever holds more than {max(values, default=0)} tokens; "
            f"its markings are not counted: {search.reason}"
        )

    @staticmethod
    def _recurs(checked: Checked) -> bool:
        """Whether a smaller net gives the answer; if so, store its result about firings."""
        proof = checked.recurrence
        if proof is None:
            return False
        checked.report.proved.append(
            f"the net is bounded: no place ever holds more than {max(proof.bounds, default=0)} tokens; "
            "its markings are not counted, because that takes too long"
        )
        checked.report.by = (
            "a smaller net, which always returns to its initial marking; counting all markings takes too long"
        )
        # Lost messages never come back: where the net does, no queue overflows.
        from dineros.analysis.covering.firings import Firings

        possible = frozenset(range(len(checked.subject.net.transitions))) - proof.dead
        checked.recurs = True
        checked.firings = Firings(
            possible=possible, dead=set(proof.dead), has_no_deadlock=True, is_complete=True
        )
        return True

    def _grow(self, checked: Checked, pumpings: Sequence[Pumping]) -> None:
        """Put into the report what grows, and what would end it."""
        subject, report = checked.subject, checked.report
        for pumping in pumpings:
            grown = tuple(subject.place_text(place) for place in pumping.places)
            way = pumping_witness(subject, pumping)
            report.findings.append(self.UNBOUNDED.found(*grown, witness=way, places=", ".join(grown)))
        if not pumpings:
            return
        from dineros.analysis.covering.growth import remedy_of

        remedy = remedy_of(subject.net)
        if remedy is not None:
            preposition = "with " if remedy.weights else ""
            report.proved.append(f"the net would be bounded {preposition}{remedy_text(subject, remedy)}")


class Places(Question):
    """Whether a place/transition net is one-safe, and its marking stable: what the contest asks of nets.

    A marking is *stable* if some place always holds the tokens that it begins with. Of system models, the
    questions about queues and unused parts say more.
    """

    NOT_ONE_SAFE = Fault(
        "not-one-safe",
        "note",
        "A place of a place/transition net can hold more than one token.",
        "the net is not one-safe: more than one token can be at {places}",
    )
    STABLE = Fault(
        "stable-marking",
        "note",
        "The tokens of a place of a place/transition net never change.",
        "the marking is stable: the tokens never change at {places}",
    )
    faults = (NOT_ONE_SAFE, STABLE)
    asks = "whether the net is one-safe, whether a marking is stable"

    def leave_open(self, checked: Checked, reason: str) -> None:
        """Leave it undecided, which is not a fault; of system models it is not asked."""
        if isinstance(checked.model, sym.SystemModel):
            return
        checked.leave_open(self.asks, reason, may_be_fault=False)

    def ask(self, checked: Checked) -> None:
        """Explore all markings; without a state space, use the methods for nets of the contest."""
        if isinstance(checked.model, sym.SystemModel):
            return
        if checked.firings is None:
            initial, largest = checked.subject.net.initial.tolist(), checked.space.largest_place()
            crowded = [p for p, most in enumerate(largest) if most > 1]
            still = [p for p, most in enumerate(largest) if most == initial[p]]
            self._say(checked, self.NOT_ONE_SAFE, crowded)
            self._say(checked, self.STABLE, [p for p in still if checked.space.is_stable(p)])
            return
        from dineros.analysis.portfolio.answering import answer_properties
        from dineros.analysis.properties.property import Property

        asked = [Property(each, "global", examination=each) for each in ("OneSafe", "StableMarking")]
        subject, share = checked.subject, PLACES.share(checked.budget)
        answers = answer_properties(subject.net, subject.names, asked, share.left or 0.0, share.memory)
        one_safe, stable = (answer.value for answer in answers)
        if one_safe is None or stable is None:
            self.leave_open(checked, next(answer.reason for answer in answers if answer.value is None))
        if one_safe is not None:
            self._say(checked, self.NOT_ONE_SAFE, None if one_safe is False else [])
        if stable is not None:
            self._say(checked, self.STABLE, None if stable is True else [])

    def _say(self, checked: Checked, fault: Fault, places: list[int] | None) -> None:
        """Say where it is so; None: somewhere."""
        if places == []:
            checked.report.proved.append(PROVED[fault.rule])
            return
        names = [checked.subject.place_text(place) for place in places or []]
        checked.report.findings.append(fault.found(*names, places=", ".join(names) or "some place"))


PROVED = {
    Places.NOT_ONE_SAFE.rule: "the net is one-safe: no place ever holds more than one token",
    Places.STABLE.rule: "no marking is stable: the tokens of every place can change",
}
