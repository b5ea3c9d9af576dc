"""Traces for other tools: MCAP (Foxglove, Lichtblick, ROS), and CSV.

If a trace has no times, as in witnesses, one firing lasts a millisecond.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import cast

from dineros.views.traces.building import TraceBuilder

EXPORTS = {".mcap": "mcap_file", ".csv": "table"}
"""Module that writes each format, by suffix."""


def export(builder: TraceBuilder, suffix: str) -> bytes:
    """Return a trace in the format of a suffix in `EXPORTS`.

    Raises
    ------
    DinerosError
        A library that the format needs is not installed.
    """
    module = import_module(f"dineros.views.exports.{EXPORTS[suffix]}")
    return cast(Callable[[TraceBuilder], bytes], module.export)(builder)
