"""Sweeps: the state spaces of a grid of models, as a table (the data of the paper's Figs 15 to 17).

A sweep runs on this machine or on a Dask cluster, each point in a separate process. Finished points are
written at once to a journal next to the output, so that a killed worker or run loses none of them.
"""

from dineros.analysis.sweeps.grid import Axis, Grid, Point, SweepError
from dineros.analysis.sweeps.point import Figures
from dineros.analysis.sweeps.sweep import Outcome, Progress, SweepInterrupt, share_of_memory, sweep

__all__ = [
    "Axis",
    "Figures",
    "Grid",
    "Outcome",
    "Point",
    "Progress",
    "SweepError",
    "SweepInterrupt",
    "share_of_memory",
    "sweep",
]
