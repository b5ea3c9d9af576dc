"""A client that gives up and asks again, where the first request is served late (ros2_control#2071)."""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.build import callback, here, node_net, place, read, step
from dineros.metamodel.constraints import validate


def late_configure(*, idempotent: bool = False, timeout: float | None = 10.0) -> sym.SystemModel:
    """A spawner gives a request up and asks again; the server refuses to configure twice."""
    answer = sym.TokenType(id="Answer", fields=[sym.TokenField(name="success", kind="boolean")])
    model = sym.SystemModel(id="spawning", middleware="ros2", tokenType=answer)
    manager = node_net(model, "controller_manager", execution="callbacks")
    page = callback(manager, "OnConfigure", "server")
    asked, answered = place(page, "Asked"), place(page, "Answered")
    new, configured = place(manager, "Unconfigured", 1), place(manager, "Configured")
    first = step(page, "Configure", [asked, here(new, page)], [answered, here(configured, page)])
    first.assigns = "Answered.success := true"
    again = step(page, "IsConfigured", [asked], [answered])
    again.assigns = f"Answered.success := {str(idempotent).lower()}"
    read(here(configured, page), again)
    spawner = node_net(model, "spawner")
    ask, got, late = place(spawner, "Ask"), place(spawner, "Got"), place(spawner, "Late")
    tries, finished, failed = place(spawner, "Tries", 2), place(spawner, "Finished"), place(spawner, "Failed")
    step(spawner, "First", [place(spawner, "Start", 1)], [ask])
    step(spawner, "Finish", [got], [finished]).guard = "success = true"
    step(spawner, "Fail", [got], [failed]).guard = "success = false"
    client = sym.ClientPort(client="spawner", request=ask, response=got)
    if timeout is not None:
        given_up = place(spawner, "GivenUp")
        step(spawner, "TryAgain", [late, tries], [ask])
        step(spawner, "GiveUp", [late], [given_up])
        client.timeout, client.timedOut = timeout, late
        given_up.kind = sym.PlaceKind.end
    else:
        spawner.objects.remove(late)
        spawner.objects.remove(tries)
    finished.kind = failed.kind = sym.PlaceKind.end
    service = sym.ServiceChannel(id="Configuring", service="/configure", model=model)
    service.server = sym.ServerPort(page=page, entry=asked, exit=answered)
    service.clients.append(client)
    model.properties.append(sym.Property(id="NeverFails", text="never Failed >= 1"))
    assert [each for each in validate(model) if each.severity == "error"] == []
    return model
