"""What the node `/controller` does when its transitions fire: the results of the arms are put together."""

from __future__ import annotations

from dineros.runtime import Net

from . import firings


def configure(net: Net) -> None:
    """Leave the net as it is."""


@firings.on("TReportL")
def report_left(firing: firings.TReportLFiring) -> firings.Outcome:
    """EndResL -> ResultL."""
    return {"sensorData": "left cell"}


@firings.on("TReportR")
def report_right(firing: firings.TReportRFiring) -> firings.Outcome:
    """EndResR -> ResultR."""
    return {"sensorData": "right cell"}
