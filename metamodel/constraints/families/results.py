"""Run-time models and Petri-net models: what splitting and flattening promise of their results."""

from __future__ import annotations

from dineros.metamodel import pn, pnm, rtm, sym
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.wording import describe


@constraint("{it} also holds {found}", fix="split the system model again: a run-time model is one ROS node")
def runtime_model_is_one_node(model: rtm.RuntimeModel, index: Index) -> Outcome:
    """A run-time model holds exactly one node net."""
    others = [node_net for node_net in index.all(sym.NodeNet) if node_net is not model.node]
    return not others or describe(others[0])


@constraint("{it} has {found} for requests and responses", fix="use two places")
def runtime_client_request_is_not_response(port: rtm.ClientPort, index: Index) -> Outcome:
    """Request and response of a client of a run-time model are two places."""
    return port.eContainer() is not port.response or describe(port.response)


@constraint("{it} holds {found}", fix="flatten the system model again: its references and pages are resolved")
def petri_net_model_is_flat(model: pnm.PetriNetModel, index: Index) -> Outcome:
    """A Petri-net model has neither references nor nested pages."""
    for element in index.elements:
        if isinstance(element, (pn.ReferencePlace, pn.ReferenceTransition)):
            return describe(element)
        if isinstance(element, pn.Page) and element.page is not None:
            return f"the nested {describe(element)}"
    return True


@constraint(
    "{it} gives {found} in the initial marking, not {element.value}",
    fix="flatten the system model again, or correct the invariant",
)
def invariant_holds_initially(invariant: pnm.PlaceInvariant, index: Index) -> Outcome:
    """A place invariant of the certificate holds in the initial marking."""
    if any(not index.incomplete.isdisjoint([term, term.place]) for term in invariant.terms):
        return True
    value = sum(term.weight * term.place.tokens for term in invariant.terms)
    return value == invariant.value or str(value)
