"""A compiled time Petri net as a model again, so that it can be saved for another tool."""

from __future__ import annotations

from fractions import Fraction

from dineros.analysis.nets.models import model_of_nodes
from dineros.analysis.timed.nets import TimedNet
from dineros.metamodel import pn
from dineros.metamodel.build import flow, inhibit, read
from dineros.metamodel.files.exact import nearest


def to_timed_model(net: TimedNet, id: str, unit: Fraction | None = None) -> pn.Net:
    """Return a time Petri net as a model of one page.

    Parameters
    ----------
    net, id
        The net, and the id of the model.
    unit
        What all bounds are divided by, which changes no state class but the times in it. By default it is
        `TimedNet.unit`: then they are whole numbers.
    """
    unit = net.unit if unit is None else unit
    made, _, places, transitions = model_of_nodes(net.untimed, id)
    for number, transition in enumerate(transitions):
        interval = net.intervals[number]
        if not interval.is_free:
            transition.interval = pn.TimeInterval(
                earliest=nearest(interval.earliest / unit),
                latest=None if interval.latest is None else nearest(interval.latest / unit),
                earliestExcluded=interval.is_open_below,
                latestExcluded=interval.is_open_above and interval.latest is not None,
            )
        taken = dict(net.take.row(number))
        for place, weight in taken.items():
            flow(places[place], transition, weight=weight)
        for place, weight in net.untimed.pre.row(number):
            if weight > taken.get(place, 0):
                read(places[place], transition, weight - taken.get(place, 0))
        for place, weight in net.untimed.inhibitor.row(number):
            inhibit(places[place], transition, weight)
        for place, weight in net.put.row(number):
            flow(transition, places[place], weight=weight)
    for low, above in enumerate(net.above):
        for high in above:
            transitions[high].overrides.append(transitions[low])
    return made
