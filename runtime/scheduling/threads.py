"""Waiting for threads."""

from __future__ import annotations

import threading


def join(thread: threading.Thread | None, timeout: float | None = None) -> None:
    """Wait until a thread has ended, if there is one, and Ctrl-C has not interrupted its start.

    Parameters
    ----------
    thread : threading.Thread or None
        Not the current one.
    timeout : float, optional
        Seconds, at most.
    """
    if thread is not None and thread.is_alive():
        thread.join(timeout)
