"""A watchdog for every service client, to be used with ``dineros flatten --rules``."""

from dineros.metamodel import sym
from dineros.transformations.language import Made, Node, Rule
from dineros.transformations.rules.notation import arc, place, read, transition
from dineros.transformations.rules.services import S1


class Watchdog(Rule):
    """A watchdog that may expire while a client waits for an answer."""

    service = Node(sym.ServiceChannel)
    client = Node(sym.ClientPort, channel=service)
    ready = Made(S1.ready, of=client)
    t_req = Made(S1.t_req, of=client)
    t_res = Made(S1.t_res, of=client)

    waiting = place("{service.id}.client.{client.client}.waiting")
    armed = place("{service.id}.client.{client.client}.armed", tokens=1)
    expired = place("{service.id}.client.{client.client}.expired")
    t_timeout = transition("{service.id}.client.{client.client}.timeout")
    t_rearm = transition("{service.id}.client.{client.client}.rearm")
    arcs = [
        arc(t_req, waiting),
        arc(waiting, t_res),
        arc(armed, t_timeout),
        read(waiting, t_timeout),
        arc(t_timeout, expired),
        arc(expired, t_rearm),
        read(ready, t_rearm),
        arc(t_rearm, armed),
    ]


RULES = [Watchdog]
