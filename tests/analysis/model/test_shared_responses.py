"""Clients that share a service or an action: what answers about all runs assume of them."""

from __future__ import annotations

from dineros.analysis.model.shared_responses import shared_responses
from dineros.metamodel import sym
from dineros.metamodel.build import place
from dineros.metamodel.callbacks.groups import callback_page_of
from dineros.metamodel.elements import channels, node_net_of, pages
from tests.support.ros2_systems.shared_services import shared_model


def _service(model: sym.SystemModel) -> sym.ServiceChannel:
    (service,) = channels(model, sym.ServiceChannel)
    return service


def _client(model: sym.SystemModel, number: int) -> sym.ClientPort:
    return _service(model).clients[number]


def _without_other_callback(model: sym.SystemModel, number: int) -> None:
    page = next(page for page in pages(model) if page.id == f"OnOther{number}")
    page.delete()


def test_two_busy_clients_of_one_service_are_named() -> None:
    (text,) = shared_responses(shared_model())
    assert text == (
        "fewer than 10 responses to other clients of service /battery arrive"
        " while a response waits for the executor of clients user0, user1"
    )


def test_nothing_is_assumed_of_one_client() -> None:
    assert shared_responses(shared_model(1)) == []


def test_a_client_with_a_time_out_gives_up_in_the_net_too() -> None:
    model = shared_model()
    _client(model, 0).timeout = 1.0
    (text,) = shared_responses(model)
    assert text.endswith("of client user1")


def test_a_client_whose_node_has_nothing_else_to_do_takes_its_response_at_once() -> None:
    model = shared_model()
    _without_other_callback(model, 0)
    (text,) = shared_responses(model)
    assert text.endswith("of client user1")
    page = callback_page_of(_client(model, 0).request)
    assert page is not None
    page.group = sym.CallbackGroup(id="many", kind="reentrant")
    (text,) = shared_responses(model)
    assert text.endswith("of clients user0, user1")


def test_clients_in_one_node_share_an_executor_that_takes_all_responses() -> None:
    model = shared_model(1)
    page = callback_page_of(_client(model, 0).request)
    assert page is not None
    other = sym.ClientPort(client="again", request=place(page, "More"), response=place(page, "Got"))
    _service(model).clients.append(other)
    assert shared_responses(model) == []


def test_nodes_that_run_the_engine_ask_again() -> None:
    model = shared_model()
    for number in range(2):
        node = node_net_of(_client(model, number).request)
        assert node is not None
        node.execution = sym.Execution.net
    assert shared_responses(model) == []


def test_the_depth_of_the_service_is_that_of_its_clients() -> None:
    model = shared_model()
    _service(model).depth = 3
    (text,) = shared_responses(model)
    assert text.startswith("fewer than 3 responses")
