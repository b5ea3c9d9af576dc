"""Narrows open behaviour by recordings: which callback leads to which messages, with the evidence."""

from dineros.observation.narrowing.calling import verbs_of
from dineros.observation.narrowing.narrowing import Narrowed, narrowed
from dineros.observation.narrowing.proposals import Proposal, proposals
from dineros.observation.narrowing.traced import Traced, publications, traced, with_traced

__all__ = [
    "Narrowed",
    "Proposal",
    "Traced",
    "narrowed",
    "proposals",
    "publications",
    "traced",
    "verbs_of",
    "with_traced",
]
