"""The journal of a node: its state can be rebuilt at any record, and a killed node continues from it."""

from dineros.runtime.journal.rebuilding import rebuild, rebuild_at
from dineros.runtime.journal.recorder import JournalError, JournalRecorder, resume_journal
from dineros.runtime.journal.state import JournalState

__all__ = ["JournalError", "JournalRecorder", "JournalState", "rebuild", "rebuild_at", "resume_journal"]
