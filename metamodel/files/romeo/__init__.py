"""Romeo's formats for time Petri nets (LS2N Nantes): its drawings ``.xml``, and its language ``.cts``.

Read are initial markings, intervals with open and closed bounds, weights, read and logical inhibitor arcs,
and priorities. Features that time Petri nets lack are errors, reported with their line: stopwatches, timed
inhibitor arcs, speeds, processors, parameters, flush arcs, coloured tokens, guards, updates, and intervals of
places. Costs, and which transitions can be observed or controlled, change no behaviour and are not kept.

If a transition takes tokens from a place that it also reads, Romeo compares the marking with the weight of
the read arc alone and DiNeROS with the sum; reading and writing convert, as for TINA.

Of ``.cts``, the part is read in which Romeo itself writes time Petri nets; see `cts_reader`.

In Romeo, a transition with a higher number goes before all with a lower one. Relations between single
transitions are written if such numbers can say them.
"""

from dineros.metamodel.files.romeo.cts_reader import net_from_cts
from dineros.metamodel.files.romeo.cts_writer import cts_text
from dineros.metamodel.files.romeo.reader import net_from_content
from dineros.metamodel.files.romeo.writer import net_content

__all__ = ["cts_text", "net_content", "net_from_content", "net_from_cts"]
