"""Explicit engine: exact state spaces and witnesses by search over packed markings.

Importing this package does not import Numba; the first search does.
"""

from dineros.analysis.explicit.answers import (
    Answer,
    ExplicitStateSpace,
    Found,
    Options,
    Order,
    Progress,
    Unknown,
    Unreachable,
)
from dineros.analysis.explicit.engine import enabled_anywhere, explore, find, find_all
from dineros.analysis.explicit.goals import Comparison, Goal

__all__ = [
    "Answer",
    "Comparison",
    "ExplicitStateSpace",
    "Found",
    "Goal",
    "Options",
    "Order",
    "Progress",
    "Unknown",
    "Unreachable",
    "enabled_anywhere",
    "explore",
    "find",
    "find_all",
]
