"""TINA's textual format ``.net`` for place/transition and time Petri nets (LAAS-CNRS, manual page "formats").

Read are all declarations (``net tr pl lb pr nt``, see `parsing`) with weights and their factors (``2K``),
read and inhibitor arcs, intervals and priorities. Several declarations of one node add up. Stopwatch arcs are
refused: nets have none. Bounds may be decimal (``0.25``) or rational (``1/3``) and stay exact; TINA itself
takes whole numbers only.

Written are nodes and what they do. References are resolved and pages dropped; layout, notes of other tools
and the data of tokens have no place in this format. Nodes are named by their ids and labelled by their names.
Channels and clauses are errors, as their meaning would be lost.

If a transition takes tokens from a place that it also reads, TINA compares the marking with the weight of
the read arc alone and DiNeROS with the sum, since a read arc is short for a pair of normal arcs; reading and
writing convert.
"""

from dineros.metamodel.files.tina.reader import net_from_text
from dineros.metamodel.files.tina.writer import net_text

__all__ = ["net_from_text", "net_text"]
