"""Models that break the constraints of `nets`."""

from __future__ import annotations

from dineros.metamodel import pn
from dineros.metamodel.build import suppress
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small, plain

CASES = Cases()


@CASES.breaks(
    "arc-joins-place-and-transition",
    "arc 'p-t' joins place 'p' and place 'q'",
    "join a place and a transition, or references to them",
    of=plain,
)
def two_places(small: Small) -> None:
    small["p-t"].target = small["q"]


@CASES.breaks(
    "arc-joins-place-and-transition",
    "arc 'r-tr-read' joins transition 'u' and reference transition 'tr'",
    "join a place and a transition, or references to them",
    of=plain,
)
def two_transitions(small: Small) -> None:
    small["r-tr-read"].source = small["u"]


@CASES.breaks(
    "arc-within-page",
    "arc 'p-t' joins place 'p' and transition 'u', which are on different pages",
    "put a reference place or a reference transition on one of the pages",
    of=plain,
)
def ends_on_two_pages(small: Small) -> None:
    small["p-t"].target = small["u"]


@CASES.breaks(
    "arc-on-page-of-its-ends",
    "arc 'p-t' is on another page than its ends",
    "move it to page 'left'",
    of=plain,
)
def arc_elsewhere(small: Small) -> None:
    small["right"].arcs.append(small["p-t"])


@CASES.breaks(
    "arc-weight",
    "arc 'p-t' has the weight 0",
    "give it a weight of 1 or more",
    of=plain,
)
def weight_0(small: Small) -> None:
    small["p-t"].weight = 0


@CASES.breaks(
    "read-or-inhibitor-arc-from-place",
    "arc 't-q' is an inhibitor arc that starts at a transition",
    "let it go from the place to the transition",
    of=plain,
)
def inhibitor_to_a_place(small: Small) -> None:
    small["t-q"].kind = "inhibitor"


@CASES.breaks(
    "read-or-inhibitor-arc-from-place",
    "arc 't-q' is a read arc that starts at a transition",
    "let it go from the place to the transition",
    of=plain,
)
def read_arc_to_a_place(small: Small) -> None:
    small["t-q"].kind = "read"


@CASES.breaks(
    "arc-not-doubled",
    "arc 'again' joins the same nodes as arc 'p-t', in the same direction",
    "use one arc; the weights of normal arcs add up",
    of=plain,
)
def two_arcs(small: Small) -> None:
    pn.Arc(id="again", source=small["p"], target=small["t"], page=small["left"])


@CASES.breaks(
    "tokens-not-negative",
    "place 'r' holds -1 tokens",
    "give it 0 tokens or more",
    of=plain,
)
def debt(small: Small) -> None:
    small["r"].tokens = -1


@CASES.breaks(
    "reference-ends",
    "references run in a circle: back -> pr -> back",
    "let one of them refer to a place or transition",
    of=plain,
)
def circle_of_two(small: Small) -> None:
    pn.ReferencePlace(id="back", target=small["pr"], page=small["left"])
    small["pr"].target = small["back"]


@CASES.breaks(
    "reference-ends",
    "references run in a circle: pr -> pr",
    "let one of them refer to a place or transition",
    of=plain,
)
def reference_to_itself(small: Small) -> None:
    small["pr"].target = small["pr"]


@CASES.breaks(
    "reference-to-other-page",
    "reference place 'pr' refers to place 'r' of its own page",
    "join the arcs to that node itself",
    of=plain,
)
def reference_to_a_neighbour(small: Small) -> None:
    small["pr"].target = small["r"]


@CASES.breaks(
    "interval-finite",
    "time interval of transition 't' runs from -1.0 to 2.0",
    "use finite bounds of 0 or more, or no latest time for a transition that may wait forever",
    of=plain,
)
def negative_time(small: Small) -> None:
    small["t"].interval.earliest = -1.0


@CASES.breaks(
    "interval-finite",
    "time interval of transition 't' runs from 1.0 to inf",
    "use finite bounds of 0 or more, or no latest time for a transition that may wait forever",
    of=plain,
)
def infinite_latest_time(small: Small) -> None:
    small["t"].interval.latest = float("inf")


@CASES.breaks(
    "interval-not-empty",
    "time interval of transition 't' is empty: it runs from 1.0 to 0.5",
    "use a latest time after the earliest one, or the same time with both ends included",
    of=plain,
)
def latest_before_earliest(small: Small) -> None:
    small["t"].interval.latest = 0.5


@CASES.breaks(
    "interval-not-empty",
    "time interval of transition 't' is empty: it runs from 1.0 to 1.0, ends excluded",
    "use a latest time after the earliest one, or the same time with both ends included",
    of=plain,
)
def open_point(small: Small) -> None:
    small["t"].interval.latest = 1.0
    small["t"].interval.latestExcluded = True


@CASES.breaks(
    "overrides-acyclic",
    "priorities run in a circle: t -> u -> t",
    "remove one of these overrides",
    of=plain,
)
def circle_of_two_2(small: Small) -> None:
    small["t"].overrides.append(small["u"])


@CASES.breaks(
    "overrides-acyclic",
    "priorities run in a circle: t -> t",
    "remove one of these overrides",
    of=plain,
)
def over_itself(small: Small) -> None:
    small["t"].overrides.append(small["t"])


@CASES.breaks(
    "layout-finite",
    "point of graphics of place 'p' lies at (nan, 2.0)",
    "use finite numbers",
    of=plain,
)
def no_number(small: Small) -> None:
    small["p"].graphics.positions[0].x = float("nan")


@CASES.breaks(
    "suppression-until-day",
    "suppression 'deadlock' of place 'p' ends on '2027-02-30', which is not a date",
    "write the date as 2027-03-31, or omit it",
    of=plain,
)
def suppression_until_no_day(small: Small) -> None:
    suppress(small["p"], "deadlock", "known", until="2027-02-30")


@CASES.breaks(
    "suppression-until-day",
    "suppression 'deadlock' of place 'p' ends on '20270331', which is not a date",
    "write the date as 2027-03-31, or omit it",
    of=plain,
)
def suppression_until_another_notation(small: Small) -> None:
    suppress(small["p"], "deadlock", "known", until="20270331")


@CASES.breaks(
    "suppression-has-reason",
    "suppression 'deadlock' of place 'p' gives no reason",
    "write why the finding is accepted",
    of=plain,
)
def suppression_without_reason(small: Small) -> None:
    suppress(small["p"], "deadlock", "  ")
