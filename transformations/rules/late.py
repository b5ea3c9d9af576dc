"""What executors do about clients that give up, and about their late requests (families E and R together)."""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.transformations.language.functions import ancestor
from dineros.transformations.language.patterns import Index, Made, Node
from dineros.transformations.language.rule import Rule
from dineros.transformations.rules.callbacks import Awaited, Callback
from dineros.transformations.rules.executors import E1, E3, E7, Beginning, Ending
from dineros.transformations.rules.notation import arc
from dineros.transformations.rules.requests import GiveUp, R6Instance
from dineros.transformations.rules.services import S4, instances


class E3Late(Rule):
    """A server's callback begins for a late request, too."""

    service = Node(sym.ServiceChannel)
    instance = Index(upto=instances(service))
    copy = Made(S4.page, of=[service, instance])
    page = Node(sym.CallbackPage, of=copy)
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    t_call = Made(R6Instance.t_call, of=[service, instance])
    threads = Made(E1.threads, of=node)
    running = Made(E3.running, of=page)

    beginning = Beginning(t_call, threads, running)


class E4Late(Rule):
    """It ends with its response to nobody."""

    service = Node(sym.ServiceChannel)
    instance = Index(upto=instances(service))
    copy = Made(S4.page, of=[service, instance])
    page = Node(sym.CallbackPage, of=copy)
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    t_return = Made(R6Instance.t_return, of=[service, instance])
    threads = Made(E1.threads, of=node)
    running = Made(E3.running, of=page)

    ending = Ending(t_return, threads, running)


class E7GiveUp(Rule):
    """A callback that awaits takes a thread when it gives up, and goes on."""

    client = Node(sym.ClientPort)
    page = Node(sym.CallbackPage, of=Callback(client.request))
    given = Made(GiveUp, of=client)
    node = Node(sym.NodeNet, of=ancestor(page, sym.NodeNet))
    threads = Made(E1.threads, of=node)
    running = Made(E3.running, of=page)
    awaiting = Made(E7.awaiting, of=page)

    goes_on = [arc(awaiting, given.give_up), arc(threads, given.give_up), arc(given.give_up, running)]

    where = [Awaited(client)]
