"""Replays the steps of calls: those of clients and servers, time-outs, and losses on the way.

A request stays under way until it is served or given up, so that it uses room in the history of its service
as late as possible. A request that is given up is kept there, if there is room; a new request at a full
history displaces such a late request.
"""

from __future__ import annotations

from dataclasses import replace

from dineros.analysis.conformance.messages import Messages
from dineros.analysis.conformance.player import Player
from dineros.analysis.conformance.refusals import Fault, Refusal, Waiting
from dineros.analysis.conformance.services.nameless import NamelessCalls, is_nameless
from dineros.metamodel import sym
from dineros.metamodel.records import Drop, Reply, Request, Response, Serve
from dineros.metamodel.records.schema import ServiceStep
from dineros.metamodel.records.steps import CallStep, Step


class Calls:
    """The calls of all services."""

    def __init__(self, player: Player, messages: Messages) -> None:
        self._net, self._marking = player.net, player.marking
        self._messages = messages
        self._player = player
        self._nameless = {
            channel.id: NamelessCalls(player, channel.id)
            for channel in player.net.model.channels
            if isinstance(channel, sym.ServiceChannel)
        }

    def are_ambiguous(self, channel: str) -> bool:
        """Return whether servers of a service do not know the clients of their requests."""
        return channel in self._nameless and self._nameless[channel].are_ambiguous

    # Traces that begin in the middle of the run.

    def begin(self, kind: type[ServiceStep], channel: str, client: str, instance: int = 1) -> None:
        """Apply an unrecorded step of a client's call before the traces begin."""
        enter = self._net.entering(channel, client)
        for transition in (
            enter if kind is Serve else None,
            self._net.service(kind, channel, client, instance),
        ):
            if transition is not None:
                self._player.add_between(transition)

    def begin_late(self, channel: str, client: str, instance: int | None = None) -> None:
        """Apply that a client gave up a waiting request, or one being served, before the traces begin."""
        self.begin(Request, channel, client)
        ways = self._net.giving_up(channel, client, Request, None)[:1]
        serve = None if instance is None else self._net.service(Serve, channel, None, instance)
        for transition in (self._net.entering(channel, client), *ways, serve):
            if transition is not None:
                self._player.add_between(transition)

    def begin_instance(self, channel: str, client: str, instance: int) -> None:
        """Apply the start of serving a request whose sending is later in the client's trace."""
        serve, reply = self._ends(channel, client, instance)
        for place in serve.keys() & reply.keys():
            self._marking[place] += serve[place]

    def _ends(self, channel: str, client: str, instance: int) -> tuple[dict[int, int], dict[int, int]]:
        """Return the changes of markings by serving and answering a client."""
        found = [self._net.service(kind, channel, client, instance) for kind in (Serve, Reply)]
        serve, reply = (dict(self._net.net.delta[index]) if index is not None else {} for index in found)
        return serve, reply

    def _catch_up(self, channel: str, client: str, stage: type[ServiceStep], request: int) -> None:
        """Apply the server's steps for a request that it had served when its trace begins."""
        own = self._net.own_places
        for place, tokens in self._net.net.delta[request].items():
            if tokens > 0 and place not in own:
                self._marking[place] -= tokens
        if stage is Reply:
            serve, reply = self._ends(channel, client, 1)
            for place, tokens in reply.items():
                if tokens > 0 and place not in own and place not in serve:
                    self._marking[place] += tokens

    # Steps.

    def step(self, record: CallStep) -> Refusal | None:
        """Replay a step of a call."""
        calls = self._nameless.get(record.channel)
        if calls is None:
            return Fault(f"the model has no service channel {record.channel!r}")
        if not isinstance(record, ServiceStep):
            return self._give_up(record, calls, record.channel, record.client, record.message or "")
        if is_nameless(record):
            return self._step_nameless(record, calls)
        client = self._messages.client_of(record)
        if client is None:
            return Fault(f"{record.message!r} is of no client of service channel {record.channel!r}")
        instance = record.instance or self._net.instances.get((record.channel, record.place))
        transition = self._net.service(type(record), record.channel, client, instance)
        if transition is None:
            return Fault(f"service channel {record.channel!r} has no such port")
        fault = self._player.at(record, transition)
        if fault is not None:
            return fault
        refusal = self._messages.may_serve(record, client)
        message = self._messages.stages.message(record, client)
        if isinstance(refusal, Waiting) and isinstance(record, Response):
            if self._messages.is_asking(record, client) and calls.respond(client, message):
                refusal = None
            else:
                refusal = replace(refusal, unclear=calls.has_answers, unclear_if_stuck=calls.are_ambiguous)
        if refusal is not None:
            return refusal
        is_late = self._messages.stages.late(record.channel, message) is not None
        if is_late:
            late = self._net.service(type(record), record.channel, None, instance)
            assert late is not None, "its client has a time-out"
            transition = late
            if self._messages.stages.is_stray(record.channel, message):
                self.begin_late(record.channel, client)
        elif isinstance(record, Serve) and not calls.claim(client, message):
            return self._nobody_asks(record, calls, unclear=True)
        stages, channel = self._messages.stages, record.channel
        was_over = not is_late and stages.is_over(channel, client, message)
        if was_over and isinstance(record, Serve):
            self.begin(Request, channel, client)
        before = self._player.fired
        fault = self._player.fire_recorded(record, transition)
        if fault is None:
            self._messages.served(record, client, instance)
            if isinstance(record, Request):
                calls.asks(client, message, before)
                if (ahead := stages.ahead(channel, client, message)) is not None:
                    self._catch_up(channel, client, ahead, transition)
            elif was_over and isinstance(record, Reply):
                self.begin(Response, channel, client)
        return fault

    def _give_up(
        self, record: Step, calls: NamelessCalls, channel: str, client: str, message: str
    ) -> Refusal | None:
        """Let a client give up a call, wherever that is: waiting, lost, served, or answered."""
        stages = self._messages.stages
        refusal = self._messages.may_give_up(channel, client, message)
        if refusal is not None:
            return refusal
        stage = stages.of(channel, client, message)
        assert stage is not None, "it may be given up"
        if not calls.forget(client, message):
            return Waiting("whether the server works on its request is not known", (), unclear=True)
        ways = self._net.giving_up(channel, client, stage, stages.instance(channel, message))
        fault = Fault(f"client {client} has no time-out") if not ways else None
        for way in ways:
            fault = self._player.fire_at(record, way)
            if fault is None:
                stages.give_up(channel, client, message)
                break
        return fault

    def _step_nameless(self, record: ServiceStep, calls: NamelessCalls) -> Refusal | None:
        """Replay a step of a server that does not know the client of the request."""
        instance = record.instance or self._net.instances.get((record.channel, record.place)) or 0
        serves = isinstance(record, Serve)
        client = calls.next_client() if serves else calls.client_at(instance)
        some = client or next(iter(self._net.clients_of(record.channel)), "")
        transition = self._net.service(type(record), record.channel, some, instance)
        if transition is None:
            return Fault(f"service channel {record.channel!r} has no such port")
        fault = self._player.at(record, transition)
        if fault is None and client is None:
            late = self._net.service(type(record), record.channel, None, instance)
            if late is not None and self._player.fire_recorded(record, late) is None:
                return None  # its client has given up
            return (
                self._nobody_asks(record, calls)
                if serves
                else Fault(f"instance {instance} serves no request")
            )
        before = self._player.fired
        fault = fault or self._player.fire_recorded(record, transition)
        if fault is None:
            note = calls.served if serves else calls.answered
            note(instance, before)
        return fault

    def _nobody_asks(self, record: ServiceStep, calls: NamelessCalls, unclear: bool = False) -> Waiting:
        outside = (
            f"a program outside of the model asks {self._net.names_in_ros[record.channel]}, too, "
            "or a request was sent again after a time-out"
        )
        return Waiting(
            "no request of the model waits to be served",
            self._net.asking_nodes(record.channel),
            outside,
            unclear,
            unclear_if_stuck=calls.are_ambiguous,
        )

    def lose(self, record: Drop) -> Refusal | None:
        """Replay the loss of a request by a full history; its client may send it again."""
        if record.queue != "request":
            return Fault(f"a service has no {record.queue} queue")
        client = next(iter(self._net.clients_of(record.channel)), None)
        serving = record.node if client is None else self._net.ends_of_call(record.channel, client)[1]
        if record.node != serving:
            return Fault(f"the service belongs to node {serving}, not {record.node}")
        if any(record.change.values()):
            return Fault(f"it changes {record.change}, in the model it changes nothing")
        return self._messages.may_lose(record, self._net.depths[record.channel])
