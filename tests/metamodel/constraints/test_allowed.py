"""What looks odd, but is allowed."""

import pytest

from dineros.metamodel import pn, sym
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.constraints import validate
from tests.support.broken.small import flat, plain, runtime, system


def constraints_violated(net: pn.Net) -> list[str]:
    return [violation.constraint for violation in validate(net)]


def test_an_unsatisfiable_clause() -> None:
    small = system()
    set_clause(small["Serve"], "Open & !Open")
    assert constraints_violated(small.net) == []


def test_a_normal_form_written_otherwise_but_equivalent() -> None:
    small = system()
    clause = set_clause(small["Talk"], "Ready & (!Ready | Danger)")
    clause.text = "Ready & Danger"
    assert constraints_violated(small.net) == []


@pytest.mark.parametrize("text", ["Ready | !Ready", "true"])
def test_a_clause_that_is_always_true(text: str) -> None:
    small = system()
    clause = set_clause(small["Done"], text)
    clause.text = "Danger -> (Ready -> Danger)"
    assert constraints_violated(small.net) == []


@pytest.mark.parametrize("stored", ["Ready & Danger", "Ready | Danger", "true"])
def test_a_normal_form_that_only_implies_or_is_implied_is_found(stored: str) -> None:
    small = system()
    clause = set_clause(small["Done"], stored)
    clause.text = "Ready"
    assert constraints_violated(small.net) == ["clause-form-is-text"]


def test_false_written_as_text_and_stored_otherwise() -> None:
    small = system()
    set_clause(small["Done"], "Ready & !Ready").text = "false"
    assert constraints_violated(small.net) == []


@pytest.mark.parametrize(
    "name", ["chatter", "/a/b_1/c", "~/status", "~", "{node}/status", "/cell{n}/x", "_x"]
)
def test_topic_names(name: str) -> None:
    small = system()
    small["chatter"].topic = name
    assert constraints_violated(small.net) == []


def test_a_volatile_topic_of_an_existing_type() -> None:
    """Nodes of DiNeROS lose nothing all the same; other programs hear no transient-local subscriber."""
    small = system()
    assert small["chatter"].type is not None
    small["chatter"].qos = sym.QualityOfService(durability="volatile")
    assert constraints_violated(small.net) == []


def test_several_subscribers_and_responses_on_one_place() -> None:
    small = system()
    page = sym.CallbackPage(id="inbox", page=small["talker"])
    inbox = sym.Place(id="Inbox", page=page)
    small["chatter"].subscribers.append(sym.SubscriberPort(place=inbox))
    small["ask"].clients[0].response = inbox
    news = sym.TopicChannel(id="news", topic="/news", model=small.net)
    news.publishers.append(sym.PublisherPort(place=sym.Place(id="News", page=small["listener"])))
    news.subscribers.append(sym.SubscriberPort(place=inbox))
    assert constraints_violated(small.net) == []


def test_ports_inside_server_pages() -> None:
    small = system()
    page = sym.CallbackPage(id="also", kind="server", page=small["talker"])
    sent, *places = (sym.Place(id=f"{id}2", page=page) for id in ("Said", "Entry", "Exit", "Ask", "Answer"))
    server = sym.ServerPort(entry=places[0], exit=places[1], page=page)
    other = sym.ServiceChannel(id="other", service="/other", server=server, model=small.net)
    small["chatter"].publishers.append(sym.PublisherPort(place=sent))
    # They call each other in a circle, and `ask` says how many instances it has.
    small["ask"].clients.append(sym.ClientPort(client="c2", request=places[2], response=places[3]))
    request, response = (sym.Place(id=f"{id}3", page=small["serve"]) for id in ("Ask", "Answer"))
    other.clients.append(sym.ClientPort(client="c1", request=request, response=response))
    assert constraints_violated(small.net) == []


def test_a_service_of_several_instances_that_calls_itself() -> None:
    small = system()
    request, response = (sym.Place(id=f"{id}3", page=small["serve"]) for id in ("Ask", "Answer"))
    small["ask"].clients.append(sym.ClientPort(client="c2", request=request, response=response))
    assert constraints_violated(small.net) == []


def test_a_message_that_is_a_request() -> None:
    small = system()
    small["ask"].clients[0].request = small["Heard"]
    small["ask"].clients[0].response = small["Count"]
    assert constraints_violated(small.net) == []


def test_two_clients_of_a_service_on_the_same_places() -> None:
    small = system()
    small["ask"].clients.append(sym.ClientPort(client="c2", request=small["Ask"], response=small["Answer"]))
    assert constraints_violated(small.net) == []


def test_a_topic_and_a_service_of_the_same_name() -> None:
    small = system()
    small["ask"].service = "/chatter"
    assert constraints_violated(small.net) == []


def test_entry_and_exit_on_a_page_inside_the_server_page() -> None:
    small = system()
    inner = pn.Page(id="inner", page=small["serve"])
    small["ask"].server.entry = sym.Place(id="Entry2", page=inner)
    pn.ReferencePlace(id="Entry2Here", target=small["Entry2"], page=small["serve"])
    assert constraints_violated(small.net) == []


def test_node_nets_of_the_same_name_in_different_namespaces() -> None:
    small = system()
    small["listener"].name = "talker"
    assert constraints_violated(small.net) == []


@pytest.mark.parametrize(
    "data",
    [
        '{"count": 3}',
        '{"count": "-3"}',
        '{"pose": [1, "2.5"]}',
        '{"pose": "[1, 2]"}',
        '{"tag": "42"}',
        " {} ",
    ],
)
def test_balloon_data_that_fits_or_denotes_what_fits(data: str) -> None:
    small = system()
    small["Idle"].balloons[0].data = data
    assert constraints_violated(small.net) == []


def test_inhibitor_read_and_normal_arcs_beside_each_other() -> None:
    small = plain()
    for kind in ("read", "inhibitor"):
        pn.Arc(id=f"p-t-{kind}", source=small["p"], target=small["t"], kind=kind, page=small["left"])
    assert constraints_violated(small.net) == []


def test_an_interval_that_is_one_closed_point() -> None:
    small = plain()
    small["t"].interval.latest = small["t"].interval.earliest
    assert constraints_violated(small.net) == []


def test_priorities_that_share_a_lower_transition() -> None:
    small = plain()
    pn.Transition(id="v", overrides=[small["u"], small["t"]], page=small["right"])
    assert constraints_violated(small.net) == []


def test_plain_nets_need_no_node_nets() -> None:
    assert constraints_violated(pn.Net(id="n", pages=[pn.Page(id="p", objects=[pn.Place(id="x")])])) == []


def test_several_invariants_with_weights() -> None:
    small = flat()
    small.net.certificate[0].terms[1].weight = 2
    small.net.certificate[0].value = 6
    assert constraints_violated(small.net) == []


def test_runtime_places_of_another_callback() -> None:
    small = runtime()
    small["hear"].kind = "timer"
    small["hear"].timer = 2.0
    assert constraints_violated(small.net) == []
