"""Builds the node net of one observed node: its callback pages, and its ports in the channels."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow, seconds
from dineros.metamodel.errors import DinerosError, Location, counted, near_matches
from dineros.observation.importing.abilities import Abilities
from dineros.observation.importing.assuming import TIMER, USUAL_PERIOD, of_client, quoted
from dineros.observation.importing.bodies import Body, Call, Possible
from dineros.observation.importing.flows.graphs import relabelled, variables_of
from dineros.observation.importing.flows.labels import Flow, Label, Received, Set, Step
from dineros.observation.importing.flows.narrowing import narrowed
from dineros.observation.importing.given import LIFE, GivenCallback
from dineros.observation.importing.names import flat, split
from dineros.observation.systems import Endpoint, TopicEndpoint


class NodeBuilder(Abilities):
    """Builds the node net of a node; its parameters are those of `Abilities`."""

    def build(self) -> sym.NodeNet:
        """Return the node net; its ports are in the channels."""
        namespace, name = split(self._node.name)
        id = self._ids.new(flat(self._node.name))
        self._net = sym.NodeNet(
            id=id,
            name=name if name != id else None,
            namespace=namespace or None,
            execution="callbacks",
            sourceLine=self._said.at or None,
        )
        self._groups = {name: sym.CallbackGroup(id=self._ids.new(f"{id}.{name}"), name=name, kind=kind)
                        for name, kind in self._said.groups.items()}  # fmt: skip
        self._net.callbackGroups.extend(self._groups.values())
        self._possible = Possible(
            {**self._publishers(), **self._goals(), **self._requests()},
            self._call,
            tuple(Step("call", client.name) for client in self._node.clients),
            self._waits(),
            self._variables(),
        )
        for subscriber in self._node.subscribers:
            self._subscription(subscriber)
        for server in self._node.servers:
            self._service(server)
        for server in self._node.action_servers:
            self._action(server)
        self._timers()
        self._answers()
        self._executor()
        self._lifecycle()
        self._refuse_unknown()
        return self._net

    # ---------------------------------------------------------------------------------------------- the node

    def _executor(self) -> None:
        if self._is_unseen:
            self._net.assumed = "node"
            if self._node.clients:  # it may ask again and again: it must not wait for itself
                self._net.executor, self._net.threads = "multi", 2
            return
        if self._said.order is not None:
            if self._said.is_shared and self._said.order == "rclpy":
                raise DinerosError(
                    f"node {self._node.name} stands for several, whose callbacks rclpy takes node by node",
                    hint="omit its order: then all orders are explored",
                )
            self._net.order = self._said.order
        threads = self._said.threads
        if threads is not None:
            self._net.executor, self._net.threads = ("multi" if threads > 1 else "single"), threads
            if self._said.open_threads is not None:
                words = f"runs its callbacks on {counted(threads, 'thread')}"
                self._assume(self._net, "executor", "threads", str(threads), words)
            return
        self._assume(self._net, "executor", "threads", "1", "runs its callbacks on one thread")

    def _lifecycle(self) -> None:
        if self._node.lifecycle is None:
            return
        life = self._said.lifecycle
        if life is None:
            value = f"[{', '.join(map(quoted, LIFE))}]"
            words = "may be stopped at any time, or fail to start"
            self._assume(self._net, "lifecycle", "lifecycle", value, words)
        self._net.lifecycle = sym.Lifecycle()
        for feature in LIFE if life is None else life:
            setattr(self._net.lifecycle, feature, True)

    def _timers(self) -> None:
        """Add the timers; they are invisible, so if none are given, one timer takes all possible steps."""
        if self._said.timers is not None:
            for name, period in self._said.timers.items():
                self._timer(name, period)
        elif self._possible.steps():
            self._assume(self._net, "timers", "timers", f"{{{TIMER} = {USUAL_PERIOD}}}", "has a timer")
            self._timer(TIMER, USUAL_PERIOD)

    def _timer(self, name: str, period: float) -> None:
        body = self._page(name, f"on_{flat(name)}", "timer", timer=period)
        said = self._said.callback(name)
        if self._said.timers is None or name in self._said.open_timers:
            body.page.assumed = f"{body.page.assumed} period" if body.page.assumed else "period"
        body.page.offset = seconds(*said.offset) if said.offset is not None else None
        ticks = body.transition("ticks", kind="start")
        overlaps = None if said.overlaps is None else (ticks, said.overlaps)
        body.end(body.run(ticks, *self._does(name)), overlaps=overlaps)

    # --------------------------------------------------------------------------------------------- callbacks

    def _subscription(self, endpoint: TopicEndpoint) -> None:
        name = endpoint.given_as
        owner = f"_of_{flat(endpoint.reader)}" if endpoint.reader else ""
        body = self._page(name, f"on_{flat(endpoint.topic)}{owner}", "subscriber", at=endpoint.at)
        place, begin = body.place("message", sourceLine=endpoint.at or None), body.transition("begins")
        flow(place, begin)
        place.tokenType = self._channels.tokens(endpoint.topic)
        received = self._received(name, endpoint.topic)
        if received is None:
            state = body.run(begin, *self._does(name))
        else:
            state = body.decide(begin, place, received)
        most = self._said.callback(name).overlaps
        state = body.store(state, self._possible.waits.get(Step("wait", endpoint.topic)))
        body.end(state, overlaps=None if most is None else (begin, most))
        limit, is_taken = self._depth(endpoint)
        port = self._channels.subscribe(endpoint, place, limit)
        if is_taken:
            self._assume_depth(port, endpoint.topic, limit)
        self._newest(port, endpoint, limit)

    def _received(self, name: str, topic: str) -> Received | None:
        """Return the branches of a callback by the field of its message that the model has."""
        said = self._said.callback(name)
        deciding = self._channels.deciding.get(topic)
        if said.received is None or deciding is None or said.does is None or said.flow is not None:
            return None
        if deciding.name != said.received.name:
            return None
        branches = tuple((value, self._able(name, flow)) for value, flow in said.received.branches)
        return replace(said.received, branches=branches)

    def _newest(self, port: sym.SubscriberPort, endpoint: TopicEndpoint, limit: int) -> None:
        """Decide whether a reader needs only the newest message: by default, from its QoS."""
        given = self._said.newest.get(endpoint.given_as)
        if given is not None:
            port.newestOnly = given
        elif not self._is_unseen and (limit == 1 or endpoint.quality.durability == "transientLocal"):
            port.newestOnly = True
            key, words = (
                f"newest.{quoted(endpoint.given_as)}",
                f"needs only the newest message of {endpoint.topic}",
            )
            self._assume(port, "newestOnly", key, "true", words)

    def _service(self, endpoint: Endpoint) -> None:
        body = self._page(endpoint.name, f"serves_{flat(endpoint.name)}", "server", at=endpoint.at)
        entry, answer, begin = body.place("request"), body.place("response"), body.transition("begins")
        flow(entry, begin)
        if self._is_silent:
            flow(begin, body.place("unanswered"))
        else:
            answer.tokenType = self._channels.responses(endpoint.name)
            body.reply(begin, *self._does(endpoint.name), answer)
        port = sym.ServerPort(entry=entry, exit=answer, page=body.page)
        self._channels.serve(endpoint, port, self._said.at_once(endpoint.name))

    def _action(self, endpoint: Endpoint) -> None:
        body = self._page(endpoint.name, f"works_on_{flat(endpoint.name)}", "goal", at=endpoint.at)
        goal, begin = body.place("goal"), body.transition("begins")
        succeeded, aborted, canceled = (body.place(each) for each in ("succeeded", "aborted", "canceled"))
        cancel, feedback = body.place("cancel"), body.place("feedback")
        flow(goal, begin)
        state = body.run(begin, *self._does(endpoint.name))
        tells = body.transition("tells")
        flow(state, tells, state)
        flow(tells, feedback)
        body.end(state, succeeded)
        flow(state, body.transition("gives_up"), aborted)
        stops = body.transition("stops")
        flow(state, stops, canceled)
        flow(cancel, stops)
        self._channels.work(
            endpoint,
            sym.ActionServerPort(
                page=body.page,
                entry=goal,
                succeeded=succeeded,
                aborted=aborted,
                canceled=canceled,
                cancel=cancel,
                feedback=feedback,
                mayReject=True,
            ),
        )

    def _answers(self) -> None:
        """Add the callbacks of responses without a wait, and of results of goals."""
        for client in self._node.clients:
            name, step = client.name, Step("send", client.name)
            if step in self._possible.puts:
                key = self._key(name)
                place = self._answer(
                    key,
                    f"on_answer_of_{flat(name)}",
                    *self._does(key),
                    tokens=self._channels.responses(name),
                )
                request = self._possible.puts[step][0]
                asks = self._channels.ask(client, str(self._net.id), request, place, self._group(key))
                asks.assumed = self._open_group(key)
        for client in self._node.action_clients:
            name = client.name
            key = self._key(name)
            kept = self._possible.waits.get(Step("result", name))
            ended = self._answer(key, f"on_result_of_{flat(name)}", *self._does(key), kept)
            told = self._told(key, name)
            goal = self._possible.puts[Step("goal", name)][0]
            goal.capacity = outstanding = self._said.callback(key).outstanding
            port = sym.ActionClientPort(
                client=self._net.id,
                goal=goal,
                outstanding=outstanding,
                cancel=self._possible.puts[Step("cancel", name)][0],
                succeeded=ended,
                aborted=ended,
                canceled=ended,
                accepted=told[0],
                rejected=told[1] or ended,
                feedback=self._answer(key, f"on_feedback_of_{flat(name)}", ()),
                group=self._group(key),
                assumed=self._open_group(key),
            )
            self._channels.want(client, port)

    def _told(self, key: str, name: str) -> tuple[sym.Place | None, sym.Place | None]:
        """Add the handling of accepted and refused goals, if it depends on variables or a callback waits."""
        said, word = self._said.callback(key), flat(name)
        kept, result = (self._possible.waits.get(Step(verb, name)) for verb in ("accepted", "result"))
        is_known = said.accepted is not None and said.rejected is not None and bool(self._possible.variables)
        if not is_known and kept is None:
            return None, None
        accepted, rejected = (said.accepted, said.rejected) if is_known else (None, None)
        return (
            self._answer(key, f"on_acceptance_by_{word}", (), accepted and self._able(key, accepted), kept),
            self._answer(
                key, f"on_refusal_by_{word}", (), rejected and self._able(key, rejected), kept, result
            ),
        )

    def _answer(
        self,
        name: str,
        word: str,
        steps: tuple[Step, ...] | None,
        branches: Flow | None = None,
        *kept: pn.Place | None,
        tokens: sym.TokenType | None = None,
    ) -> sym.Place:
        body = self._page(name, word, "client")
        place, begin = body.place("answer"), body.transition("begins")
        place.tokenType = tokens
        flow(place, begin)
        state = body.run(begin, steps, branches, place)
        for each in kept:
            state = body.store(state, each)
        body.end(state)
        return place

    def _page(self, name: str, word: str, kind: str, timer: float | None = None, at: str = "") -> Body:
        said = self._said.callback(name)
        self._asked.add(name)
        id = self._ids.new(f"{self._net.id}.{word}")
        page = sym.CallbackPage(
            id=id,
            kind=kind,
            page=self._net,
            timer=timer,
            awaits=said.awaits or (self._is_unseen and kind == "goal"),
            sourceLine=said.at or at or None,
        )
        if kind != "client" or self._said.answers_hold_groups:
            page.group = self._group(name)
            page.assumed = self._open_group(name)
        if kind != "client":
            page.duration = seconds(*said.takes) if said.takes is not None else None
            if page.duration is not None:
                page.duration.source = said.measured or None
            page.jitter = said.jitter if timer is not None else None
        if said.does is None and self._possible.steps() and not self._is_unseen:
            steps = ", ".join(quoted(str(each)) for each in self._possible.steps())
            key = f"callback.{quoted(name)}.does"
            words = f"may, on {name}, in any order: {', '.join(map(str, self._possible.steps()))}"
            self._assume(page, "behaviour", key, f"[{steps}]", words)
        return Body(page, self._ids, self._possible)

    def _does(self, name: str) -> tuple[tuple[Step, ...] | None, Flow | None]:
        """Return the steps given for a callback, in order and in its branches."""
        branches = self._said.callback(name).flow
        return self._steps(name), None if branches is None else self._able(name, branches)

    def _able(self, name: str, branches: Flow) -> Flow:
        """Return a flow of a callback without impossible steps, and with propagated values."""

        def able(label: Label) -> Label:
            is_step = isinstance(label, Step) and Step(label.verb, label.name) not in self._ables()
            return None if is_step else label

        values = {each: variable.values for each, variable in self._said.variables.items()}
        own = [each for each in values if self._is_alone(name, each)]
        return narrowed(relabelled(branches, able), values, own, keeps_waiting=not self._awaits(name))

    def _awaits(self, name: str) -> bool:
        return self._said.callback(name).awaits

    def _is_alone(self, name: str, variable: str) -> bool:
        """Return whether no other run sets a variable while a callback runs."""
        setting = [
            key
            for key, callback in self._said.callbacks.items()
            for each in (callback.flow, callback.accepted, callback.rejected)
            if each is not None and variable in variables_of(each, Set)
        ]
        if self._said.threads == 1:
            return not self._awaits(name) and not any(map(self._awaits, setting))
        group = self._said.callback(name).group
        goals = {each.name for each in self._node.action_servers}
        return (group is None or self._said.groups[group] == "exclusive") and all(
            key not in goals and self._said.callbacks[key].group == group for key in [name, *setting]
        )

    def _ables(self) -> set[Step]:
        return {Step(step.verb, step.name) for step in self._possible.steps()} | set(self._possible.waits)

    def _steps(self, name: str) -> tuple[Step, ...] | None:
        """Return the steps given for a callback; None: not given.

        Raises
        ------
        DinerosError
            The node cannot take these steps.
        """
        steps = self._said.callback(name).does
        able = self._ables()
        if (
            steps is not None
        ):  # actions on ports that the model does not have are reported where the ports are omitted
            steps = tuple(step for step in steps if not step.at or Step(step.verb, step.name) in able)
        for step in steps or ():
            if Step(step.verb, step.name) not in able:
                names = [each.name for each in able if each.verb == step.verb]
                hint = near_matches(step.name, names) or f"it can {_listed(able)}"
                raise self._wrong(f"callback.{name}.does", f"the node does not {step.verb} {step.name}", hint)
        return steps

    def _call(self, page: sym.CallbackPage, step: Step, timeout: float | None) -> Call:
        service = step.name
        group = self._group(self._key(service)) if step.group is None else self._groups.get(step.group)
        if self._is_unseen:
            group = sym.CallbackGroup(id=self._ids.new(f"{self._net.id}.answers"), name="answers")
            self._net.callbackGroups.append(group)
        client = next(each for each in self._node.clients if each.name == service)
        request, response = (
            sym.Place(
                id=self._ids.new(f"{page.id}.{word}_{flat(service)}"), page=page, sourceLine=client.at or None
            )
            for word in ("asks", "answer_of")
        )
        response.tokenType = self._channels.responses(service)
        port = self._channels.ask(client, str(page.id), request, response, group)
        port.assumed = self._open_group(self._key(service)) if step.group is None else None
        if timeout is None or timeout <= 0:
            return Call(request, response)
        id = self._ids.new(f"{page.id}.no_answer_of_{flat(service)}")
        port.timeout, port.timedOut = timeout, sym.Place(id=id, page=page, sourceLine=client.at or None)
        return Call(request, response, port.timedOut)

    def _key(self, name: str) -> str:
        """Return the key of a client: a separate one if the node is also the server."""
        own = of_client(name)
        return own if own in self._said.callbacks else name

    def _group(self, name: str) -> sym.CallbackGroup | None:
        """Return the callback group given for a callback, or for the client of a service."""
        group = self._said.callback(name).group
        return None if group is None else self._groups[group]

    def _open_group(self, name: str) -> str | None:
        """Return the mark of a callback, or of a client, whose group the code does not say."""
        return "group" if self._said.callback(name).has_open_group else None

    # ------------------------------------------------------------------------------------- what is refused

    def _refuse_unknown(self) -> None:
        """Reject facts given for callbacks and topics that the node does not have."""
        read = [endpoint.given_as for endpoint in self._node.subscribers]
        ends = (*self._node.publishers, *self._node.subscribers)
        topics = [endpoint.topic for endpoint in ends]
        named = sorted(self._asked | {client.name for client in self._node.clients})
        for key, given, known in (
            ("callback", self._said.callbacks, named),
            ("depths", self._said.depths, topics),
            ("newest", self._said.newest, read),
        ):
            for name, said in given.items():
                is_of_code = bool(said.at if isinstance(said, GivenCallback) else self._said.at)
                if name not in known and not is_of_code:
                    hint = near_matches(name, known) or f"it has {_listed(known)}"
                    raise self._wrong(f"{key}.{name}", "the node has none", hint)

    def _wrong(self, key: str, message: str, hint: str) -> DinerosError:
        said = f"node.{self._node.name}.{key}: {message}"
        return DinerosError(said, location=Location(self._given.path), hint=hint)


def _listed(things: Iterable[object]) -> str:
    return ", ".join(sorted(map(str, things))) or "none"
