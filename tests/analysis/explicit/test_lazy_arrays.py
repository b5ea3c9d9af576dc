"""Arrays of which a small search touches the beginning only."""

from __future__ import annotations

import gc
import os
from pathlib import Path

from dineros.analysis.explicit.lazy_arrays import HUGE_PAGE, LEAST_FOR_HUGE_PAGES, lazy_zeros


def resident() -> int:
    """Return the bytes of memory that this process uses."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_the_first_element_takes_no_huge_page() -> None:
    """Each search through state classes has some 20 such arrays: clearing 40 MiB took most of its time."""
    arrays = [lazy_zeros(LEAST_FOR_HUGE_PAGES) for _ in range(30)]
    before = resident()
    for array in arrays:
        array[0] = 1
    assert resident() - before < 30 * HUGE_PAGE // 4


def test_elements_are_zero_and_can_be_written_on_both_sides_of_the_first_huge_page() -> None:
    array = lazy_zeros(LEAST_FOR_HUGE_PAGES)
    border = HUGE_PAGE // array.itemsize
    assert not array[border - 1 : border + 1].any()
    array[border - 1 : border + 1] = 7, 8
    assert array[[0, border - 1, border, -1]].tolist() == [0, 7, 8, 0]


def test_the_address_space_of_garbage_is_used_again() -> None:
    """Commands collect garbage rarely; 20 arrays of 8 TiB are more than a process can map at once."""
    gc.disable()
    try:
        for _ in range(20):
            ring: list[object] = [lazy_zeros(1 << 40)]
            ring.append(ring)
    finally:
        gc.enable()
