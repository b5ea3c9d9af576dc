"""The case study where data decides: what the sensor sees, and whether an arm has picked and placed.

``python -m case_study.guarded`` writes `guarded.sym.xmi` next to this file. The model differs from
`build.py` in three nodes. The executor has one place `Scene` for what the sensor saw, and moves an arm only
while `humanDetected` is false. Picking and placing answer whether they succeeded; a controller places only
what was picked, and the user interface counts what was sorted and what was not.
"""

from __future__ import annotations

from case_study import build as plain
from case_study.build import CELLS, HOME, RETRY_TIME, transition
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, flow, here, node_net, place, read
from dineros.metamodel.elements import find
from dineros.metamodel.files import save


def executor(model: sym.SystemModel) -> tuple[dict[str, sym.ServerPort], sym.Place, sym.Place]:
    """Picking and placing under one place that holds what the sensor saw last."""
    signals = ("RobotIsIdle", "RobotHasFinished", "ObjectIsPicked", "ObjectIsPlaced", "Danger")
    net = node_net(model, "executor", signals, package="sorting_executor")
    safety = pn.Page(id="Safety", name="Safety", page=net)
    scene = place(safety, "Scene", tokens=1)
    scene.balloons.append(sym.BalloonToken(data='{"humanDetected": true}'))
    request, response = place(safety, "SensorReq"), place(safety, "SensorRes")
    retry = transition(safety, "TRetry", earliest=RETRY_TIME)
    retry.guard = "humanDetected = true"
    flow(scene, retry, request)
    stop = transition(safety, "TStop", clause="Danger")
    stop.guard = "humanDetected = false"
    flow(scene, stop, request)
    see = transition(safety, "TSee")
    see.assigns = "Scene.humanDetected := SensorRes.humanDetected"
    flow(response, see, scene)
    servers = {}
    for operation in ("Pick", "Place"):
        page = callback(net, f"{operation}Server", "server")
        entry, run, exit_ = (place(page, f"{operation}{role}") for role in ("Entry", "Run", "Exit"))
        success = f"{exit_.id}.{operation.lower()}Success"
        start = transition(page, f"T{operation}")
        start.guard = "Scene.humanDetected = false"
        flow(entry, start, run)
        read(here(scene, page), start)
        done = f"ObjectIs{operation.removesuffix('e')}ed"
        for outcome, literal in (("Success", done), ("Fail", f"!{done}")):
            end = transition(page, f"T{operation}{outcome}", f"(RobotIsIdle | RobotHasFinished) & {literal}")
            end.assigns = f"{success} := {'true' if outcome == 'Success' else 'false'}"
            flow(run, end, exit_)
        abort = transition(page, f"T{operation}Abort")
        abort.guard, abort.assigns = "Scene.humanDetected = true", f"{success} := false"
        flow(run, abort, exit_)
        read(here(scene, page), abort)
        servers[operation] = sym.ServerPort(entry=entry, exit=exit_, page=page)
    return servers, request, response


def feedback(model: sym.SystemModel) -> sym.Place:
    """The user interface shows each object that was sorted, and each one that was not."""
    net = node_net(model, "feedback", package="sorting_feedback")
    received = place(callback(net, "ReceiveResult"), "Feedback")
    page = received.page
    assert page is not None
    for outcome, shown, value in (("Result", "Shown", "true"), ("Failure", "NotSorted", "false")):
        show = transition(page, f"TShow{outcome}")
        show.guard = f"placeSuccess = {value}"
        flow(received, show, place(page, shown))
    return received


def decide(model: sym.SystemModel) -> None:
    """Let the controllers, and the server that takes control back, decide by and hand on what succeeded."""
    for cell in CELLS:
        start, release, report = (
            find(model, f"T{name}{cell}", sym.Transition) for name in ("StartPlace", "Release", "Report")
        )
        start.guard = "pickSuccess = true"
        release.assigns = f"EndReq{cell}.placeSuccess := PlaceRes{cell}.placeSuccess"
        report.assigns = f"Result{cell}.placeSuccess := EndRes{cell}.placeSuccess"
        page = start.page
        assert page is not None
        give_up = transition(page, f"TGiveUp{cell}")
        give_up.guard, give_up.assigns = "pickSuccess = false", f"EndReq{cell}.placeSuccess := false"
        flow(find(model, f"PickRes{cell}", sym.Place), give_up, find(model, f"EndReq{cell}", sym.Place))
    find(model, "TEnd", sym.Transition).assigns = "EndExit.placeSuccess := EndEntry.placeSuccess"


def properties() -> list[sym.Property]:
    """Return what the application is to do."""
    safe = '"Scene[humanDetected=false]" >= 1'
    texts = {
        "ArmsWaitForHumans": f"always not (enabled(TPick) or enabled(TPlace)) or {safe}",
        "PlacesWhatIsPicked": "after fired(TPickFail) until fired(TPickSuccess): never fired(TPlace)",
        "AbortsPlaceNothing": "after fired(TPickAbort) until fired(TPickSuccess): never fired(TPlace)",
        "ShowsWhatIsPlaced": "fired(TShowResult) only after fired(TPlaceSuccess)",
        "NothingIsLost": "Shown + NotSorted >= 3 stays possible",
        "OneArmAtATime": "always PickRun + PlaceRun <= 1",
    }
    found = [sym.Property(id=id, text=text) for id, text in texts.items()]
    # The sensor may be asked again and again while an arm is to pick.
    found.append(
        sym.Property(
            id="EachPickEnds", language="ltl", text="G (PickReqL >= 1 -> F PickResL >= 1)", expected=False
        )
    )
    return found


def build_guarded() -> sym.SystemModel:
    """Return the case study where data decides."""
    model = plain.build("guarded", executor=executor, feedback=feedback)
    decide(model)
    model.properties.extend(properties())
    return model


if __name__ == "__main__":
    save(build_guarded(), HOME / "guarded.sym.xmi")
