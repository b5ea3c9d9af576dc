"""Cases of executors and callback groups: a timer's callback calls a service and waits for the answer."""

from __future__ import annotations

from dataclasses import dataclass

from dineros.metamodel import sym
from dineros.metamodel.build import flow


@dataclass(frozen=True)
class Case:
    """How node A runs its callbacks.

    Attributes
    ----------
    threads : int
        Of its executor.
    client : {"default", "own"}
        The group of the client: that of the node, or one of its own.
    kind : {"exclusive", "reentrant"}
        Of the one group that timers and clients are in, unless the client has its own.
    awaits : bool
        Whether the callback is `async def`.
    timers : int
        How many such timers there are.
    answers : bool
        Whether the service calls one of node A inside its callback.
    """

    threads: int = 1
    client: str = "default"
    kind: str = "exclusive"
    awaits: bool = False
    timers: int = 1
    answers: bool = False


def case_model(case: Case) -> sym.SystemModel:
    """Return node A, whose timers call node B, which has one thread, one group and one instance."""
    model = sym.SystemModel(id="executors", middleware="ros2")
    node = sym.NodeNet(id="A", net=model, execution="callbacks", executor="multi", threads=case.threads)
    all_in = sym.CallbackGroup(id="all", kind=case.kind)
    own = sym.CallbackGroup(id="own")
    node.callbackGroups.extend([all_in, own])
    service = _service(model, sym.NodeNet(id="B", net=model, execution="callbacks"), "Work")
    for number in range(case.timers):
        suffix = str(number or "")
        timer = sym.CallbackPage(
            id=f"OnTimer{suffix}", kind="timer", timer=0.1, page=node, group=all_in, awaits=case.awaits
        )
        ask, got = sym.Place(id=f"Ask{suffix}", page=timer), sym.Place(id=f"Got{suffix}", page=timer)
        flow(sym.Transition(id=f"Begin{suffix}", page=timer), ask)
        flow(got, sym.Transition(id=f"Done{suffix}", page=timer))
        service.clients.append(
            sym.ClientPort(
                client=f"timer{suffix}",
                request=ask,
                response=got,
                group=own if case.client == "own" else all_in,
            )
        )
    if case.answers:
        back = _service(model, node, "Back")
        page = service.server.page
        assert isinstance(page, sym.CallbackPage) and isinstance(back.server.page, sym.CallbackPage)
        back.server.page.group = all_in
        (serve,) = (each for each in page.objects if isinstance(each, sym.Transition))
        ask, got = sym.Place(id="AskBack", page=page), sym.Place(id="GotBack", page=page)
        (leaving,) = serve.outgoing
        leaving.source = after = sym.Transition(id="Answer", page=page)
        flow(serve, ask)
        flow(got, after)
        back.clients.append(sym.ClientPort(client="back", request=ask, response=got))
    return model


def _service(model: sym.SystemModel, node: sym.NodeNet, name: str) -> sym.ServiceChannel:
    page = sym.CallbackPage(id=f"On{name}", kind="server", page=node)
    entry, exit_ = sym.Place(id=f"{name}In", page=page), sym.Place(id=f"{name}Out", page=page)
    flow(entry, sym.Transition(id=f"{name}Serve", page=page), exit_)
    return sym.ServiceChannel(
        id=name,
        service=f"/{name.lower()}",
        instances=1,
        server=sym.ServerPort(entry=entry, exit=exit_, page=page),
        model=model,
    )


FIGURES: list[tuple[Case, tuple[int, int, int]]] = [
    (Case(), (12, 15, 1)),
    (Case(threads=2), (12, 15, 1)),
    (Case(client="own"), (12, 15, 1)),
    (Case(client="own", threads=2), (14, 20, 0)),
    (Case(kind="reentrant", threads=2), (34, 62, 1)),
    (Case(kind="reentrant", threads=2, timers=2), (256, 644, 3)),
    (Case(kind="reentrant", threads=3, timers=2), (844, 2576, 4)),
    (Case(client="own", threads=2, answers=True), (12, 15, 1)),
]
"""Markings, arcs and deadlocks of each (the design's table of executors)."""
