"""Structural reductions: a smaller net with the same answer; traces are translated (paper, Algorithm 4)."""

from dineros.analysis.reductions.net import Arcs, Change, Marking, MutableNet
from dineros.analysis.reductions.reduction import (
    PROOFS_OF_DEATH,
    RULES,
    Reduction,
    ReductionError,
    reduce,
    replay,
    ways_to_share,
)
from dineros.analysis.reductions.rule import PlaceEquation, Property, Question, Rule, Step

__all__ = [
    "PROOFS_OF_DEATH",
    "RULES",
    "Arcs",
    "Change",
    "Marking",
    "MutableNet",
    "PlaceEquation",
    "Property",
    "Question",
    "Reduction",
    "ReductionError",
    "Rule",
    "Step",
    "reduce",
    "replay",
    "ways_to_share",
]
