"""Conformance: are the traces of a run a behaviour of the model? See `docs/conformance.md`."""

from dineros.analysis.conformance.conform import ATTEMPTS, Trace, conform
from dineros.analysis.conformance.monitor import Monitor
from dineros.analysis.conformance.verdict import Deviation, Verdict

__all__ = ["ATTEMPTS", "Deviation", "Monitor", "Trace", "Verdict", "conform"]
