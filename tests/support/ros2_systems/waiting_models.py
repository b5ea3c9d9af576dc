"""Models of callbacks that wait for results of goals, for locks of their own, and for messages of others."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, flow, place, step
from examples.callbacks.models import node, timer


def awaiting_result(
    threads: int = 1, same: bool = False, awaits: bool = False, own: bool = False
) -> sym.SystemModel:
    """Return a node `boss` whose timer's callback sends a goal and waits for its result.

    Parameters
    ----------
    threads : int
        Of that node.
    same : bool
        Whether the server of the action is in that node, too.
    awaits : bool
        Whether what works on goals awaits at each step.
    own : bool
        Whether client and server have callback groups of their own.
    """
    model = sym.SystemModel(id="waits", middleware="ros2")
    boss = node(model, "boss", threads)
    for name in ("client", "server"):
        boss.callbackGroups.append(sym.CallbackGroup(id=name))
    arm = boss if same else sym.NodeNet(id="arm", net=model)
    work = sym.CallbackPage(id="Work", kind="goal", page=arm, awaits=awaits)
    goal, done = sym.Place(id="Goal", page=work), sym.Place(id="Done", page=work)
    flow(goal, sym.Transition(id="Move", page=work), done)
    tick = timer(boss, 0.5)
    send, won = sym.Place(id="Send", page=tick), sym.Place(id="Won", page=tick)
    flow(sym.Transition(id="Ask", page=tick), send)
    flow(won, sym.Transition(id="Go", page=tick))
    client = sym.ActionClientPort(client="boss", goal=send, succeeded=won)
    if own:
        client.group, work.group = boss.callbackGroups
    server = sym.ActionServerPort(page=work, entry=goal, succeeded=done)
    model.channels.append(sym.ActionChannel(id="Act", action="/act", server=server, clients=[client]))
    return model


def sharing_a_lock() -> sym.SystemModel:
    """Return a node whose timer and two server instances share two threads, and a lock that each takes.

    The timer's callback asks the service of its own node while it holds the lock.
    """
    model = sym.SystemModel(id="shared", middleware="ros2")
    owner = node(model, "n", threads=2)
    timers, services = sym.CallbackGroup(id="timers"), sym.CallbackGroup(id="services", kind="reentrant")
    owner.callbackGroups.extend([timers, services])
    lock = sym.Place(id="Lock", page=owner, tokens=1)
    serve = sym.CallbackPage(id="OnWork", kind="server", page=owner, group=services)
    entry, working, done = (sym.Place(id=id, page=serve) for id in ("In", "Working", "Out"))
    begin, finish = sym.Transition(id="Begin", page=serve), sym.Transition(id="Finish", page=serve)
    flow(entry, begin, working, finish, done)
    there = pn.ReferencePlace(id="Lock@OnWork", target=lock, page=serve)
    flow(there, begin)
    flow(finish, there)
    tick = timer(owner, 1.0)
    tick.group = timers
    wants, ask, got = (sym.Place(id=id, page=tick) for id in ("Wants", "Ask", "Got"))
    locks, unlocks = sym.Transition(id="Locks", page=tick), sym.Transition(id="Unlocks", page=tick)
    here = pn.ReferencePlace(id="Lock@OnTimer", target=lock, page=tick)
    flow(sym.Transition(id="Tick", page=tick), wants, locks, ask)
    flow(here, locks)
    flow(got, unlocks, here)
    others = sym.NodeNet(id="others", net=model)
    clients = [sym.ClientPort(client="own", request=ask, response=got, group=services)]
    for name in ("a", "b"):
        sent, answered = (
            sym.Place(id=f"Send_{name}", page=others, tokens=1),
            sym.Place(id=f"Got_{name}", page=others),
        )
        flow(answered, sym.Transition(id=f"Take_{name}", page=others))
        clients.append(sym.ClientPort(client=name, request=sent, response=answered))
    port = sym.ServerPort(page=serve, entry=entry, exit=done)
    sym.ServiceChannel(id="Work", service="/work", instances=2, server=port, clients=clients, model=model)
    return model


def locking_crosswise(calls: bool = False) -> sym.SystemModel:
    """Return a node with two threads whose timers take two locks in opposite order, each in its own group.

    Parameters
    ----------
    calls : bool
        Whether the first one calls a service of another node while it has its first lock.
    """
    model = sym.SystemModel(id="crosswise", middleware="ros2")
    owner = node(model, "n", threads=2)
    locks = [place(owner, id, tokens=1) for id in ("A", "B")]
    for number, (first, second) in enumerate([locks, locks[::-1]]):
        group = sym.CallbackGroup(id=f"timers{number}")
        owner.callbackGroups.append(group)
        page = callback(owner, f"OnTimer{number}", "timer", 1.0)
        page.group = group
        has_one, has_both = place(page, f"One{number}"), place(page, f"Both{number}")
        step(page, f"TakeFirst{number}", [first], [has_one])
        if calls and not number:
            server = sym.NodeNet(id="other", net=model)
            serve = callback(server, "OnWork", "server")
            entry, done, got = place(serve, "In"), place(serve, "Out"), place(page, "Got")
            step(serve, "Work", [entry], [done])
            client = sym.ClientPort(client="n", request=has_one, response=got, group=group)
            port = sym.ServerPort(page=serve, entry=entry, exit=done)
            sym.ServiceChannel(id="Serve", service="/work", server=port, clients=[client], model=model)
            has_one = got
        step(page, f"TakeSecond{number}", [has_one, second], [has_both])
        step(page, f"Release{number}", [has_both], [first, second])
    return model


def served_in_a_busy_group(timers: int = 2) -> sym.SystemModel:
    """Return a node with a service in its default group, which callbacks of timers of that group ask.

    Each of their clients has a group of its own, and there are threads enough.
    """
    model = sym.SystemModel(id="busy", middleware="ros2")
    owner = node(model, "n", threads=timers + 2)
    serve = sym.CallbackPage(id="OnWork", kind="server", page=owner)
    entry, done = sym.Place(id="In", page=serve), sym.Place(id="Out", page=serve)
    flow(entry, sym.Transition(id="Work", page=serve), done)
    clients = []
    for number in range(timers):
        tick = timer(owner, 1.0)
        tick.id = f"OnTimer{number}"
        ask, got = sym.Place(id=f"Ask{number}", page=tick), sym.Place(id=f"Got{number}", page=tick)
        flow(sym.Transition(id=f"Begin{number}", page=tick), ask)
        flow(got, sym.Transition(id=f"Note{number}", page=tick))
        group = sym.CallbackGroup(id=f"answers{number}")
        owner.callbackGroups.append(group)
        clients.append(sym.ClientPort(client=f"c{number}", request=ask, response=got, group=group))
    port = sym.ServerPort(page=serve, entry=entry, exit=done)
    sym.ServiceChannel(id="Serve", service="/work", server=port, clients=clients, model=model)
    return model


def waiting_for_an_echo() -> sym.SystemModel:
    """Return a node in which a callback waits for what another one hears once a third one has asked for it.

    The first and the third are in one group. Between the others stands a node that answers, so that those of
    this node do not wait for each other in a circle.
    """
    model = sym.SystemModel(id="echo", middleware="ros2")
    owner, mirror = node(model, "n", threads=3), sym.NodeNet(id="mirror", net=model)
    waits, asks = timer(owner, 1.0), timer(owner, 1.0)
    waits.id, asks.id = "OnWait", "OnAsk"
    ears = sym.CallbackGroup(id="ears")
    owner.callbackGroups.append(ears)
    hears = sym.CallbackPage(id="OnEcho", page=owner, group=ears)
    between, heard = sym.Place(id="Between", page=waits), sym.Place(id="Heard", page=owner, capacity=1)
    goes_on, asked = sym.Transition(id="GoOn", page=waits), sym.Place(id="Asked", page=owner)
    flow(sym.Transition(id="Begin", page=waits), between, goes_on)
    flow(pn.ReferencePlace(id="Heard@OnWait", target=heard, page=waits), goes_on)
    ask = sym.Transition(id="Ask", page=asks)
    flow(ask, pn.ReferencePlace(id="Asked@OnAsk", target=asked, page=asks))
    reflects = sym.CallbackPage(id="OnAsked", page=mirror)
    seen, echo, got = (
        sym.Place(id="Seen", page=reflects),
        sym.Place(id="Echo", page=reflects),
        sym.Place(id="Got", page=hears),
    )
    flow(seen, sym.Transition(id="Reflect", page=reflects), echo)
    note = sym.Transition(id="Note", page=hears)
    flow(got, note, pn.ReferencePlace(id="Heard@OnEcho", target=heard, page=hears))
    for id, source, sink in (("Ask", asked, seen), ("Echo", echo, got)):
        sym.TopicChannel(
            id=f"T{id}",
            topic=f"/{id.lower()}",
            publishers=[sym.PublisherPort(place=source, limit=1)],
            subscribers=[sym.SubscriberPort(place=sink, limit=1)],
            model=model,
        )
    return model
