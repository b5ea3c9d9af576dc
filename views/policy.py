"""The Content Security Policy (level 3) of pages: only their own scripts run, identified by hashes."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterable


def content_policy(scripts: Iterable[str], *, connect: str = "'none'", workers: bool = False) -> str:
    """Return the policy of a self-contained page.

    Parameters
    ----------
    scripts : iterable of str
        What is in its script elements, to the letter; nothing else runs, neither a script element that
        something puts into the page, nor a handler in an attribute.
    connect : str
        Where its scripts may connect to.
    workers : bool
        Whether its scripts may start workers with what the page itself holds.
    """
    hashes = " ".join(f"'sha256-{_hash(script)}'" for script in scripts)
    return (
        f"default-src 'none'; script-src {hashes}; style-src 'unsafe-inline'; img-src data: blob:; "
        f"connect-src {connect}; base-uri 'none'; form-action 'none'"
        + ("; worker-src blob:" if workers else "")
    )


def _hash(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
