"""Answers many properties of one net: the net is prepared once, and cheap methods come first."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.names import Names
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.portfolio.known import Known, known_of
from dineros.analysis.portfolio.methods.bounds import PlaceBounds
from dineros.analysis.portfolio.methods.diagrams import DecisionDiagrams
from dineros.analysis.portfolio.methods.explicit_search import ExplicitSearch
from dineros.analysis.portfolio.methods.induction import Induction
from dineros.analysis.portfolio.methods.markings import FarMarkings, StoredMarkings
from dineros.analysis.portfolio.methods.on_the_fly import AutomatonOnTheFly
from dineros.analysis.portfolio.methods.reduced_net import ReducedNet
from dineros.analysis.portfolio.methods.state_equation import StateEquationAndTraps
from dineros.analysis.portfolio.methods.stubborn_sets import StubbornSets
from dineros.analysis.portfolio.methods.walks import RandomWalks
from dineros.analysis.portfolio.scheduler import SheetStage, Turn, answer_sheet
from dineros.analysis.portfolio.sheet import Sheet
from dineros.analysis.properties.property import Property, PropertyAnswer

FEW_STATES = 20_000
"""Number of markings of the first part of the graph."""

SECONDS = 30.0
"""Default time for a question."""


def _always(known: Known) -> bool:
    return True


def _has_no_diagram(known: Known) -> bool:
    return known.has_all_markings or known.space is None


def _has_diagram(known: Known) -> bool:
    return known.space is not None and not known.has_all_markings


ALONE = (
    Turn(Induction(), time=0.25),
    Turn(ExplicitSearch(), time=0.6),
    Turn(RandomWalks()),
)
"""Plan for one question on its reduced net."""


def stages() -> tuple[SheetStage, ...]:
    """Return the plan of property files: each method with its share of the time of all questions."""
    all_markings = StoredMarkings(None, memory=0.5)
    return (
        SheetStage("the first markings", StoredMarkings(FEW_STATES, memory=0.25), 0.02),
        SheetStage("random walks", RandomWalks(), 0.03),
        SheetStage("bounds of places", PlaceBounds(), 0.05),
        SheetStage("the state equation", StateEquationAndTraps(), 0.08),
        SheetStage("many markings", all_markings, 0.08, _always),
        SheetStage("markings far away", FarMarkings(), 0.05),
        SheetStage("induction", Induction(), 0.1),
        SheetStage("decision diagrams", DecisionDiagrams(), 0.25),
        SheetStage("a deadlock", StubbornSets(), 1.0, _always),
        SheetStage("each question on a smaller net", ReducedNet(ALONE, "reduced net"), 0.5, _always),
        SheetStage("each question alone", AutomatonOnTheFly(), 1.0, _always),
        SheetStage("what is left", all_markings, 1.0, _has_no_diagram),
        SheetStage("what is left", DecisionDiagrams(), 1.0, _has_diagram),
    )


def answer_properties(
    net: CompiledNet,
    names: Names,
    properties: Sequence[Property],
    seconds: float = SECONDS,
    memory: int = 2 << 30,
    answered: Callable[[PropertyAnswer], None] = lambda answer: None,
    stage: Callable[[str], None] = lambda name: None,
) -> list[PropertyAnswer]:
    """Answer properties of a net.

    Parameters
    ----------
    seconds : float
        Time for each question; time that a question does not use is available to the others.
    memory : int
        Memory for searches, in bytes.
    answered : callable
        Called with each answer as soon as it is known.
    stage : callable
        Called with the name of each stage of the work.

    Returns
    -------
    list of PropertyAnswer
        In the order of the properties.
    """
    budget = Budget(memory, seconds=seconds * len(properties), stages=stage).begun()
    sheet, known = Sheet(net, names, properties, answered, budget, seconds), known_of(net)
    try:
        answer_sheet(sheet, stages())
    finally:
        known.forget()
    unknown = "time or memory did not suffice"
    return [
        sheet.answers.get(one.id) or PropertyAnswer(one.id, None, sheet.seconds, reason=unknown)
        for one in properties
    ]
