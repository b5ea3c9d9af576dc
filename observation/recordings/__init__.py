"""Recordings of rosbag2: topics, their types and qualities of service, and the messages one by one."""

from dineros.observation.recordings.reading import RecordedMessage, Recording, RecordingError

__all__ = ["RecordedMessage", "Recording", "RecordingError"]
