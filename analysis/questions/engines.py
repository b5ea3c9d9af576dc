"""Questions about one net, and the engines that answer them; each is a class.

A question defines how the engines of DiNeROS decide it. Other engines have the same interface, and declare
which questions they support.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, ClassVar

from dineros.analysis.answers.apart import is_end
from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import Attempt, Share, first_result
from dineros.analysis.questions.net_questions import Branching, Enabled, Linear, Marking, Question

if TYPE_CHECKING:
    from dineros.analysis.timed.nets import TimedNet
    from dineros.analysis.timed.reductions.parts import NetPart


class Engine(ABC):
    """An engine that answers questions. A new one is a subclass, and is entered in `ENGINES`.

    Attributes
    ----------
    name : str
        Value of `--engine`.
    """

    name: ClassVar[str]

    @abstractmethod
    def answer(self, question: Question, budget: Budget) -> Outcome:
        """Answer a question within a budget.

        Raises
        ------
        FormulaError
            The question is invalid, or has an unknown name.
        DinerosError
            The engine is not available, failed, or does not support the question.
        """


class Own(Engine):
    """The engines of DiNeROS, chosen according to the question."""

    name = "auto"

    def answer(self, question: Question, budget: Budget) -> Outcome:
        """Let the question choose. A witness that cannot be replayed is reported as an engine's error."""
        budget = budget.begun()
        try:
            return question.decided(budget)
        except AssertionError as error:
            if is_end(error):
                raise
            reason = f"an internal error of an engine: {error} (please report it, with the model)"
            return Outcome("unknown", seconds=budget.spent, reason=reason)


class Tina(Engine):
    """TINA of LAAS, if it is on the PATH."""

    name = "tina"

    def answer(self, question: Question, budget: Budget) -> Outcome:
        """Run TINA's programs; their witnesses are replayed."""
        from dineros.analysis import tina

        match question:
            case Enabled(net, names, name, order):
                return tina.find_enabled(net, name, names, budget, order)
            case Marking(net, names, condition, order):
                return tina.find_marking(net, condition, names, budget, order)
            case Linear(net, names, formula, weak, strong):
                return tina.verify(net, formula, names, weak, strong, budget)
        raise tina.TinaError(f"TINA does not support this question: {type(question).__name__}")


FIRST = Share(time=0.1, most_seconds=5.0)
"""Share of state classes before other methods are used."""

IN_PART = ", in a part of the net"
"""Suffix of the method's name if a part of the net decided the question."""

WITHOUT_TIMES = ", without times"
"""Suffix of the method's name if the question was decided without times."""


@dataclass(frozen=True)
class Timed(Engine):
    """State classes: questions about a net with its firing intervals and priorities.

    Attributes
    ----------
    net : TimedNet
        The net; questions are asked about the same net without its times.
    """

    net: TimedNet
    name = "time"

    def answer(self, question: Question, budget: Budget) -> Outcome:
        """Build state classes; a run that shows the answer has a schedule.

        If they are not built soon, the part of the net that decides is asked, and the net without its times:
        what never happens then does not happen with times, as these only take runs away. If nothing ever has
        to fire, questions about markings are asked without times only: see `TimedNet.is_unforced`.
        """
        budget = budget.begun()
        if self.net.is_unforced and self._is_about_markings(question):
            return self._plain(question, budget)
        part, attempts = self._part(question), list[Attempt[Outcome]]()
        if part is not None:
            of_part = partial(self._of_part, part, question)
            attempts.append(Attempt(of_part, time=0.3))
        if self._holds_with_fewer_runs(question):
            attempts.append(Attempt(partial(self._proved_plainly, question), time=0.5, most_seconds=120.0))
        if attempts:
            soon = self._of_classes(question, FIRST.share(budget))
            if soon.status != "unknown":
                return soon
        found = first_result(attempts, budget)
        return self._of_classes(question, budget) if found is None else found

    def _of_part(self, part: NetPart, question: Question, budget: Budget) -> Outcome | None:
        """Ask the part of the net that decides; None if that proves nothing."""
        found = replace(self, net=part.net)._of_classes(question, budget)
        if found.status not in ("unreachable", "holds"):
            return None
        return replace(found, by=f"{found.by}{IN_PART}", evidence=None)

    def _proved_plainly(self, question: Question, budget: Budget) -> Outcome | None:
        """Ask the net without its times; None if that proves nothing."""
        found = self._plain(_relaxed(question), budget)
        return found if found.status in ("unreachable", "holds") else None

    def _part(self, question: Question) -> NetPart | None:
        """Return the part of the net that decides; None if there is none, or it is nearly the net."""
        from dineros.analysis.logic.language.bounded import read_bounded
        from dineros.analysis.logic.language.parser import parse
        from dineros.analysis.timed.reductions.parts import part_of_firing, part_of_formula

        match question:
            case Enabled(_, names, name):
                asked = names.transitions(name)
                return part_of_firing(self.net, asked[0]) if len(asked) == 1 else None
            case Marking(_, names, condition):
                return part_of_formula(self.net, parse(condition, "state"), names)
            case Linear(_, names, formula, (), ()):
                bounded = read_bounded(formula)
                return None if bounded is None else part_of_formula(self.net, bounded, names)
        return None

    @staticmethod
    def _plain(question: Question, budget: Budget) -> Outcome:
        """Ask the net without its times."""
        plain = Own().answer(question, budget)
        by = f"{plain.by or 'all markings'}{WITHOUT_TIMES}"
        return plain if plain.status == "unknown" else replace(plain, by=by, evidence=None)

    def _is_about_markings(self, question: Question) -> bool:
        """Return whether a question is only about which markings lead to which: no run has to leave one.

        Its answer is the same with times if nothing ever has to fire.
        """
        from dineros.analysis.logic.language.parser import parse
        from dineros.analysis.logic.language.syntax import (
            QUANTIFIERS,
            TEMPORAL,
            Exists,
            Finally,
            Fired,
            ForAll,
            Globally,
        )

        if not isinstance(question, Branching):
            return self._holds_with_fewer_runs(question)
        parts = list(parse(question.formula, "ctl").subformulas())
        pairs = {(ForAll, Globally), (Exists, Finally)}
        paths = [part for part in parts if isinstance(part, QUANTIFIERS)]
        return (
            all((type(part), type(part.operands[0])) in pairs for part in paths)
            and sum(isinstance(part, TEMPORAL) for part in parts) == len(paths)
            and not any(isinstance(part, Fired) for part in parts)
        )

    def _holds_with_fewer_runs(self, question: Question) -> bool:
        """Return whether a negative answer without times is also valid with times.

        With times, a run may stay in a marking in which nothing has to fire. So this is only used for
        formulas about all markings, or about all steps. Priorities affect which markings are deadlocks with
        times.
        """
        from dineros.analysis.logic.language.bounded import bounds_times
        from dineros.analysis.logic.language.parser import parse
        from dineros.analysis.logic.language.syntax import QUANTIFIERS, TEMPORAL, Deadlock, ForAll, Globally

        match question:
            case Enabled():
                return True
            case Marking(_, _, condition):
                said = parse(condition, "state")
            case Linear(_, _, formula, (), ()) if not bounds_times(formula):
                said = parse(formula)
                if not isinstance(said, Globally):
                    return False
                said = said.operands[0]
            case Branching(_, _, formula):
                said = parse(formula, "ctl")
                if not (isinstance(said, ForAll) and isinstance(said.operands[0], Globally)):
                    return False
                said = said.operands[0].operands[0]
            case _:
                return False
        parts = list(said.subformulas())
        if self.net.has_priorities and any(isinstance(part, Deadlock) for part in parts):
            return False
        return not any(isinstance(part, (*TEMPORAL, *QUANTIFIERS)) for part in parts)

    def _of_classes(self, question: Question, budget: Budget) -> Outcome:
        """Build state classes."""
        from dineros.analysis.logic.language.bounded import read_bounded
        from dineros.analysis.timed.branching_time import check_timed_ctl
        from dineros.analysis.timed.durations.bounded_response import decide_bounded
        from dineros.analysis.timed.goals import find_timed, find_timed_firing
        from dineros.analysis.timed.linear_time import verify_timed_ltl
        from dineros.metamodel.errors import DinerosError

        match question:
            case Enabled(_, names, name):
                return find_timed_firing(self.net, name, names, budget)
            case Marking(_, names, condition):
                return find_timed(self.net, condition, names, budget)
            case Linear(_, names, formula, (), ()):
                bounded = read_bounded(formula)
                if bounded is not None:
                    return decide_bounded(self.net, bounded, names, budget)
                return verify_timed_ltl(self.net, formula, names, budget)
            case Linear():
                raise DinerosError(
                    "fairness is not supported with --time", hint="latest bounds decide what must happen"
                )
            case Branching(_, names, formula):
                return check_timed_ctl(self.net, formula, names, budget)
        raise DinerosError(f"questions of this type are not supported with --time: {type(question).__name__}")


def _relaxed(question: Question) -> Question:
    """Return a question about what never happens, asked of a net that can do more and is bounded.

    See `relaxed`. It is the same question if it asks about what that net leaves out.
    """
    from dineros.analysis.logic.language import atoms
    from dineros.analysis.logic.language.parser import parse
    from dineros.analysis.questions.relaxed import relaxed

    loose = question.net.once(relaxed)
    if not loose.places:
        return question
    match question:
        case Marking(_, _, condition):
            formula = parse(condition, "state")
        case Linear(_, _, text):
            formula = parse(text)
        case Branching(_, _, text):
            formula = parse(text, "ctl")
        case _:
            return replace(question, net=loose.net)
    for asked in atoms.BoundAtoms(question.net, formula, question.names).conditions.values():
        match asked:
            case atoms.Linear(factors) if loose.places.intersection(factors):
                return question
            case atoms.SomeEnabled(needed) if needed & loose.transitions:
                return question
            case atoms.NoneEnabled():
                return question
    return replace(question, net=loose.net)


ENGINES: dict[str, Engine] = {engine.name: engine for engine in (Own(), Tina())}
"""By name."""
