"""Which addresses the sockets of a process are bound to, as the Linux kernel tells in /proc."""

from __future__ import annotations

import contextlib
import ipaddress
from pathlib import Path


def bound_addresses(process: int) -> set[str]:
    """Return the local addresses of the UDP and TCP sockets that a process has open."""
    own = set()
    for link in Path(f"/proc/{process}/fd").glob("*"):
        with contextlib.suppress(OSError):
            target = str(link.readlink())
            if target.startswith("socket:["):
                own.add(target[8:-1])
    found = set()
    for table in ("udp", "udp6", "tcp", "tcp6"):
        for line in Path(f"/proc/{process}/net/{table}").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[9] in own:
                found.add(_address(fields[1].partition(":")[0]))
    return found


def _address(text: str) -> str:
    """Read an address as /proc shows it: groups of four bytes, each in the machine's order."""
    groups = [bytes.fromhex(text[at : at + 8])[::-1] for at in range(0, len(text), 8)]
    return str(ipaddress.ip_address(b"".join(groups)))
