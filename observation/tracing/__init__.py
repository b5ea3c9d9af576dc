"""Tracing files of ROS 2 (ros2_tracing, LTTng): which callback was running when a message was published."""

from dineros.observation.tracing.attributing import Callback, Publication, Run, Sent, Uncertain, runs
from dineros.observation.tracing.errors import TracingError
from dineros.observation.tracing.reading import Tracing

__all__ = ["Callback", "Publication", "Run", "Sent", "Tracing", "TracingError", "Uncertain", "runs"]
