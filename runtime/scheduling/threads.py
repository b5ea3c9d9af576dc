"""Waits for threads to end."""

from __future__ import annotations

import threading


def join(thread: threading.Thread | None, timeout: float | None = None) -> None:
    """Wait until a thread has ended, if there is one and its start was not interrupted by Ctrl-C.

    Parameters
    ----------
    thread : threading.Thread or None
        Not the current one.
    timeout : float, optional
        Maximum waiting time, in seconds.
    """
    if thread is not None and thread.is_alive():
        thread.join(timeout)
