"""Code of a package is part of a system: invented nodes use its ports, and have no faults."""

from __future__ import annotations

from dataclasses import replace

from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks.check import check
from dineros.analysis.consequences.cause_fixes import is_cause
from dineros.analysis.consequences.durations import left_to_durations
from dineros.analysis.consequences.folding import fold_consequences
from dineros.analysis.consequences.unseen import about_seen
from dineros.analysis.witnesses.findings import Finding, Report
from dineros.metamodel import sym
from dineros.metamodel.elements import find, is_unseen, node_net_of, node_nets, nodes
from dineros.observation.importing.building import to_model
from dineros.observation.systems import Endpoint, ObservedNode, ObservedSystem, TopicEndpoint
from examples.callbacks.models import battery

ROBOT = ObservedNode(
    "/robot",
    subscribers=(TopicEndpoint("/scan", "sensor_msgs/msg/LaserScan"),),
    publishers=(TopicEndpoint("/pose", "geometry_msgs/msg/Pose"),),
    servers=(Endpoint("/reset", "std_srvs/srv/Empty"),),
    clients=(Endpoint("/map", "nav_msgs/srv/GetMap"),),
)


def checked(is_partial: bool) -> Report:
    model = to_model(ObservedSystem("code", (replace(ROBOT, clients=()),), is_partial=is_partial)).model
    return about_seen(model, left_to_durations(model, check(model)))


def serious(report: Report) -> list[Finding]:
    return [each for each in report.findings if each.severity != "note"]


def test_other_packages_fill_call_and_answer() -> None:
    """In a whole system with these ports, nobody fills the topic, and nobody calls the service."""
    assert "dead-transition" in {each.rule for each in serious(checked(is_partial=False))}
    assert {each.rule for each in serious(checked(is_partial=True))} == {"queue-overflow"}


def test_a_server_of_another_package_answers() -> None:
    for is_partial in (False, True):
        model = to_model(ObservedSystem("code", (ROBOT,), is_partial=is_partial)).model
        places = [each.id for each in nodes(model) if (each.id or "").startswith("unseen_server")]
        assert any(each.endswith("unanswered") for each in places) != is_partial


def test_each_open_end_has_a_node() -> None:
    model = to_model(ObservedSystem("code", (ROBOT,), is_partial=True)).model
    assert sorted(node.id for node in node_nets(model) if is_unseen(node)) == [
        "unseen_client_reset",
        "unseen_publisher_scan",
        "unseen_server_map",
    ]


def test_findings_about_invented_nodes_alone_are_dropped() -> None:
    model = to_model(ObservedSystem("code", (ROBOT,), is_partial=True)).model
    invented = Finding("dead-node-net", "error", ("unseen_client_reset",), "it does nothing")
    real = Finding("dead-node-net", "error", ("robot", "unseen_client_reset"), "it does nothing")
    other = Finding("unused-topic", "warning", ("pose",), "nobody hears it")
    kept = about_seen(model, Report(findings=[invented, real, other]))
    assert kept.findings == [real, other]


def test_a_node_of_parameters_only_has_nothing_that_could_be_dead() -> None:
    model = to_model(ObservedSystem("code", (ROBOT, ObservedNode("/settings")), is_partial=True)).model
    assert "settings" in [node.id for node in node_nets(model)]
    assert "dead-node-net" not in {each.rule for each in check(model).findings}


def test_what_waits_for_a_service_that_no_node_serves_is_its_consequence() -> None:
    """A callback that waits for it never ends: that is not a second cause."""
    model = battery()
    page = find(model, "OnLevel", sym.CallbackPage)
    does = find(model, "Measure", sym.Transition)
    does.outgoing[0].target = sym.Place(id="Unanswered", page=page)
    server = node_net_of(page)
    assert server is not None
    server.assumed = "node"
    report = check(model)
    before = {each.rule for each in serious(report)}
    assert {"callback-never-ends", "service-never-returns", "dead-transition"} <= before
    fold_consequences(model, report, Budget(seconds=600).begun())
    report = about_seen(model, report)
    (cause,) = serious(report)
    assert (cause.rule, cause.elements) == ("service-never-returns", ("Level",))
    assert {each.elements[0] for each in cause.consequences} >= {"OnTimer", "NoteLevel"}


def test_a_service_whose_server_was_seen_is_not_a_cause() -> None:
    model = battery()
    finding = Finding("service-never-returns", "error", ("Level",), "it never returns")
    assert not is_cause(model, finding)
