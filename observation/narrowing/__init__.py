"""Open behaviour narrowed by what was recorded: which callback leads to what, with the evidence."""

from dineros.observation.narrowing.calling import verbs_of
from dineros.observation.narrowing.narrowing import Narrowed, narrowed
from dineros.observation.narrowing.proposals import Proposal, proposals

__all__ = ["Narrowed", "Proposal", "narrowed", "proposals", "verbs_of"]
