"""Whether a model explains a recording: the nodes were not ours, only their messages are seen."""

from dineros.observation.explaining.explain import TOLERANCE, Explainer, explain
from dineros.observation.explaining.verdict import RecordingVerdict, Unexplained

__all__ = ["TOLERANCE", "Explainer", "RecordingVerdict", "Unexplained", "explain"]
