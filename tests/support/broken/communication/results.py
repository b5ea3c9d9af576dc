"""Models that break the constraints of `results`."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small, flat, runtime

CASES = Cases()


@CASES.breaks(
    "runtime-model-is-one-node",
    "runtime model 'node' also holds node net 'second'",
    "split the system model again: a run-time model is one ROS node",
    of=runtime,
)
def two_node_nets(small: Small) -> None:
    sym.NodeNet(id="second", net=small.net)


@CASES.breaks(
    "runtime-client-request-is-not-response",
    "client port 'c1' of place 'Ask' has place 'Ask' for requests and responses",
    "use two places",
    of=runtime,
)
def one_place(small: Small) -> None:
    small["Ask"].ports[0].response = small["Ask"]


@CASES.breaks(
    "petri-net-model-is-flat",
    "petri net model 'flat' holds reference place 'copy'",
    "flatten the system model again: its references and pages are resolved",
    of=flat,
)
def reference(small: Small) -> None:
    pn.ReferencePlace(id="copy", target=small["Load"], page=pn.Page(id="other", net=small.net))


@CASES.breaks(
    "petri-net-model-is-flat",
    "petri net model 'flat' holds the nested page 'inner'",
    "flatten the system model again: its references and pages are resolved",
    of=flat,
)
def nested_page(small: Small) -> None:
    pn.Page(id="inner", page=small["page"])


@CASES.breaks(
    "invariant-holds-initially",
    "place invariant 'Load + Capacity = 3' of petri net model 'flat' gives 2 in the initial marking, not 3",
    "flatten the system model again, or correct the invariant",
    of=flat,
)
def token_lost(small: Small) -> None:
    small["Capacity"].tokens = 2
