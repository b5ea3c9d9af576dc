"""Large arrays of the explicit engine that use no memory until they are touched."""

from __future__ import annotations

import gc
import mmap
import os

import numpy as np
from numpy.typing import NDArray

Int64Array = NDArray[np.int64]

#: Size in bytes from which huge pages are requested: fewer TLB misses, but more memory touched at once. The
#: first 2 MiB have small pages: a small search touches the beginning of many arrays, and clearing a huge page
#: of each takes milliseconds.
LEAST_FOR_HUGE_PAGES = 1 << 22
HUGE_PAGE = 1 << 21
#: Distance between small arrays of different threads, in elements: a shared cache line slows both down.
APART = 32


def lazy_zeros(rows: int, columns: int | None = None, is_huge: bool = True) -> Int64Array:
    """Zeroed int64 array of ``rows`` or ``rows x columns`` whose pages are allocated when first touched.

    Parameters
    ----------
    is_huge
        Whether pages of 2 MiB may be used, after the first 2 MiB.

    Raises
    ------
    MemoryError
        The address space is not sufficient.
    """
    shape = (rows,) if columns is None else (rows, columns)
    size = 8 * int(np.prod(shape))
    if size == 0 or not hasattr(mmap, "MAP_ANONYMOUS"):
        return np.zeros(shape, dtype=np.int64)
    # Without a reserve, the system may promise more than it has; the budget keeps the touched pages below
    # that.
    no_reserve = getattr(mmap, "MAP_NORESERVE", 0x4000 if os.uname().sysname == "Linux" else 0)
    flags = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | no_reserve
    try:
        pages = mmap.mmap(-1, size, flags=flags)
    except OSError:  # beyond a limit of the address space, which arrays of earlier searches may still hold
        gc.collect()
        try:
            pages = mmap.mmap(-1, size, flags=flags)
        except OSError as error:
            raise MemoryError(f"{size} bytes cannot be mapped") from error
    if is_huge and size >= LEAST_FOR_HUGE_PAGES and hasattr(mmap, "MADV_HUGEPAGE"):
        pages.madvise(mmap.MADV_NOHUGEPAGE, 0, HUGE_PAGE)
        pages.madvise(mmap.MADV_HUGEPAGE, HUGE_PAGE)
    return np.frombuffer(pages, dtype=np.int64).reshape(shape)


def zeros_apart(size: int) -> Int64Array:
    """Small zeroed array that shares no cache line with any other."""
    return np.zeros(size + 2 * APART, dtype=np.int64)[APART : APART + size]
