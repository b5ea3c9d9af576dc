"""Memory of the explicit engine: large arrays that cost nothing until they are touched."""

from __future__ import annotations

import mmap
import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Int64Array = NDArray[np.int64]

#: Part of the free memory that a search may take unless told otherwise.
DEFAULT_SHARE = 0.7
#: Bytes from which huge pages are asked for: fewer misses of the address cache, more touched at once.
LEAST_FOR_HUGE_PAGES = 1 << 26


def free_memory() -> int:
    """Bytes that can be had without swapping, as far as the system tells."""
    try:
        for line in Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    except OSError:
        pass
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2


def lazy_zeros(rows: int, columns: int | None = None) -> NDArray[np.int64]:
    """Zeroed int64 array of ``rows`` or ``rows x columns`` whose pages are taken when first touched."""
    shape = (rows,) if columns is None else (rows, columns)
    size = 8 * int(np.prod(shape))
    if size == 0 or not hasattr(mmap, "MAP_ANONYMOUS"):
        return np.zeros(shape, dtype=np.int64)
    # Without a reserve, the system promises more than it has; the budget keeps what is touched below that.
    no_reserve = getattr(mmap, "MAP_NORESERVE", 0x4000 if os.uname().sysname == "Linux" else 0)
    pages = mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | no_reserve)
    if size >= LEAST_FOR_HUGE_PAGES and hasattr(mmap, "MADV_HUGEPAGE"):
        pages.madvise(mmap.MADV_HUGEPAGE)
    return np.frombuffer(pages, dtype=np.int64).reshape(shape)


def new_boxes(workers: int, rows: int, words: int) -> list[list[tuple[Int64Array, Int64Array, Int64Array]]]:
    """Boxes for markings on their way: by phase and sender, the markings, parents and sizes by receiver."""
    return [
        [
            (
                lazy_zeros(workers * rows, words).reshape(workers, rows, words),
                lazy_zeros(workers, rows),
                np.zeros(workers, dtype=np.int64),
            )
            for _ in range(workers)
        ]
        for _ in range(2)
    ]
