"""Checks whether a model explains a recording of foreign nodes, of which only messages are known."""

from dineros.observation.explaining.explain import TOLERANCE, Explainer, explain
from dineros.observation.explaining.verdict import RecordingVerdict, Unexplained

__all__ = ["TOLERANCE", "Explainer", "RecordingVerdict", "Unexplained", "explain"]
