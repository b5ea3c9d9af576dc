"""What processes take, as Linux reports it (proc(5)): time of the processor and memory."""

from __future__ import annotations

import os
import re
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

HERE = os.getpid()


def processor_seconds(process: int) -> float:
    """Return what a process has used so far, and those that it has waited for; to a hundredth or so."""
    words = Path(f"/proc/{process}/stat").read_bytes().rpartition(b")")[2].split()
    return sum(map(int, words[11:15])) / os.sysconf("SC_CLK_TCK")


def thread_seconds(process: int) -> float:
    """Return what all threads of a process have used that it has now; exact."""
    threads = Path(f"/proc/{process}/task").iterdir()
    return sum(int((thread / "schedstat").read_text().split()[0]) for thread in threads) / 1e9


def mebibytes(process: int = HERE, name: str = "VmRSS", file: str = "status") -> float:
    """Return a part of the memory of a process, by its name in a file of its folder; what is resident."""
    text = Path(f"/proc/{process}/{file}").read_text(encoding="utf-8", errors="replace")
    return int(re.findall(rf"^{name}:\s+(\d+) kB$", text, re.MULTILINE)[0]) / 1024


def watched(messages: Iterable[tuple[str, int]], count: int) -> Iterator[tuple[str, int]]:
    """Yield messages, so many in all, and print now and then how fast they are taken, and the memory."""
    began, before = time.process_time(), 0
    print(f"{'messages':>12} {'per second':>12} {'MiB':>8}")
    for number, message in enumerate(messages, 1):
        yield message
        if number in (1000, 10_000, 100_000) or not number % max(1, count // 10):
            rate = (number - before) / max(time.process_time() - began, 1e-9)
            print(f"{number:12,} {rate:12,.0f} {mebibytes():8.1f}", flush=True)
            began, before = time.process_time(), number
