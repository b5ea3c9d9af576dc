"""Recordings of rosbag2: topics, their types and qualities of service, and the messages one by one."""

from dineros.observation.recordings.calls import Calls, Observed, Untaken
from dineros.observation.recordings.errors import RecordingError
from dineros.observation.recordings.reading import RecordedMessage, Recording

__all__ = ["Calls", "Observed", "RecordedMessage", "Recording", "RecordingError", "Untaken"]
