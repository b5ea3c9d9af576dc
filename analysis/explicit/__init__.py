"""Explicit engine: exact state spaces and witnesses by search over packed markings.

Importing this package does not import Numba; the first search does.
"""

from dineros.analysis.answers.budget import Budget, Progress
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.explicit.answers import ExplicitStateSpace, Options, Order
from dineros.analysis.explicit.engine import explore, find, find_all
from dineros.analysis.explicit.goals import Comparison, Goal

__all__ = [
    "Budget",
    "Comparison",
    "ExplicitStateSpace",
    "Goal",
    "Options",
    "Order",
    "Outcome",
    "Progress",
    "explore",
    "find",
    "find_all",
]
