"""Recordings of rosbag2: topics, their types and qualities of service, and the messages one by one."""

from dineros.observation.recordings.calls import Calls, Observed
from dineros.observation.recordings.reading import RecordedMessage, Recording, RecordingError

__all__ = ["Calls", "Observed", "RecordedMessage", "Recording", "RecordingError"]
