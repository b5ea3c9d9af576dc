"""The possible steps of a node: places of its publications, requests and goals, and of its waits."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.observation.importing.assuming import TIMER, USUAL_DEPTH, Assumed, Marked, of_client, quoted
from dineros.observation.importing.channels import Channels
from dineros.observation.importing.flows.graphs import variables_of
from dineros.observation.importing.flows.labels import Flow, Set, Step
from dineros.observation.importing.flows.racing import races
from dineros.observation.importing.given import Given, GivenCallback
from dineros.observation.importing.names import flat
from dineros.observation.systems import ALL_KEPT, ObservedNode, TopicEndpoint


class Abilities:
    """Determines the possible steps of a node, and records assumptions.

    Parameters
    ----------
    node : ObservedNode
        What was seen.
    given : Given
        The facts given for all nodes.
    channels : Channels
        Gets the ports.
    is_unseen : bool
        Whether it was not observed and represents unknown nodes.
    is_partial : bool
        Whether the system may have other nodes. Then an invented server answers; otherwise, no server ever
        answers.
    """

    def __init__(
        self,
        node: ObservedNode,
        given: Given,
        channels: Channels,
        is_unseen: bool,
        is_partial: bool = False,
    ) -> None:
        self._node = node
        self._given = given
        self._said = given.node(node.name)
        self._channels = channels
        self._ids = channels.ids
        self._is_unseen = is_unseen
        self._is_silent = is_unseen and not is_partial
        self._asked: set[str] = set()
        self._net: sym.NodeNet
        self.assumed: list[Assumed] = []

    def _publishers(self) -> dict[Step, tuple[pn.Place, ...]]:
        found: dict[Step, tuple[pn.Place, ...]] = {}
        for endpoint in self._node.publishers:
            name = endpoint.topic
            id = self._ids.new(f"{self._net.id}.{flat(name)}")
            place = sym.Place(id=id, page=self._net, sourceLine=endpoint.at or None)
            place.tokenType = self._channels.tokens(name)
            limit, is_taken = self._depth(endpoint)
            port = self._channels.publish(endpoint, place, limit)
            if is_taken:
                self._assume_depth(port, name, limit)
            step = Step("publish", name)
            found[step] = (*found.get(step, ()), place)
        return found

    def _goals(self) -> dict[Step, tuple[pn.Place, ...]]:
        return {
            Step(verb, client.name): (self._single(f"{verb}s_{flat(client.name)}"),)
            for client in self._node.action_clients
            for verb in ("goal", "cancel")
        }

    def _requests(self) -> dict[Step, tuple[pn.Place, ...]]:
        """Return the places of requests whose responses no callback waits for.

        An open callback may send any request; other callbacks send the given ones.
        """
        said = {step for callback in self._said.callbacks.values() for step in callback.does or ()}
        sent = {step.name for step in said if step.verb == "send"}
        return {
            Step("send", client.name): (self._bare(f"asks_{flat(client.name)}"),)
            for client in self._node.clients
            if client.name in sent or self._is_open()
        }

    def _waits(self) -> dict[Step, pn.Place]:
        """Return the places that mark messages, acceptances and results for which a callback waits."""
        said = {step for callback in self._said.callbacks.values() for step in callback.does or ()}
        topics = {each.topic for each in self._node.subscribers}
        actions = {each.name for each in self._node.action_clients}
        return {
            Step(step.verb, step.name): self._single(
                f"{word}_{flat(step.name)}", name=f"{word.replace('_', ' ')} {step.name}"
            )
            for verb, names, word in (
                ("wait", topics, "message_of"),
                ("accepted", actions, "acceptance_of"),
                ("result", actions, "result_of"),
            )
            for step in sorted({Step(each.verb, each.name) for each in said}, key=str)
            if step.verb == verb and step.name in names
        }

    def _variables(self) -> dict[str, dict[str, pn.Place]]:
        """Return places for the values of the variables, if the node has all callbacks that set them."""
        said, node = self._said, self._node
        known = {each.given_as for each in node.subscribers} | set(said.timers or ())
        for endpoints in (node.servers, node.clients, node.action_servers, node.action_clients):
            known |= {each.name for each in endpoints} | {of_client(each.name) for each in endpoints}
        clients = {each.name for each in (*node.clients, *node.action_clients)}
        clients |= {of_client(each) for each in clients}
        served = {each.name for each in (*node.servers, *node.action_servers)}
        answers: list[Flow] = []
        others: list[Flow] = []
        for name, callback in said.callbacks.items():
            flows = [
                each for each in (callback.flow, callback.accepted, callback.rejected) if each is not None
            ]
            if name not in known and any(variables_of(each, Set) for each in flows):
                return {}
            (answers if name in clients - served else others).extend(flows)
        is_mixed = said.threads not in (None, 1) or any(each.awaits for each in said.callbacks.values())
        if is_mixed and races(answers, others):
            return {}
        return {
            name: {
                value: sym.Place(
                    id=self._ids.new(f"{self._net.id}.{flat(name)}_{flat(value)}"),
                    page=self._net,
                    tokens=int(value == variable.first),
                    sourceLine=variable.at or None,
                )
                for value in variable.values
            }
            for name, variable in said.variables.items()
        }

    def _is_open(self) -> bool:
        """Return whether no steps are given for a callback of the node."""
        node = self._node
        names = [each.given_as for each in node.subscribers]
        for endpoints in (node.servers, node.action_servers, node.action_clients):
            names += [each.name for each in endpoints]
        names += [TIMER] if self._said.timers is None else self._said.timers
        said = self._said.callbacks
        return not self._is_unseen and any(said.get(name, GivenCallback()).does is None for name in names)

    def _bare(self, word: str) -> sym.Place:
        """Return a place of the node."""
        return sym.Place(id=self._ids.new(f"{self._net.id}.{word}"), page=self._net)

    def _single(self, word: str, name: str | None = None) -> sym.Place:
        """Return a place for one token at a time: nothing bounds how often a callback puts one there."""
        return sym.Place(id=self._ids.new(f"{self._net.id}.{word}"), name=name, page=self._net, capacity=1)

    def _depth(self, endpoint: TopicEndpoint) -> tuple[int, bool]:
        """Return the depth of a history, and whether it is assumed."""
        said = self._said.depths.get(endpoint.topic)
        known = endpoint.depth if said is None else said
        if known is None:
            return USUAL_DEPTH, True
        return known or ALL_KEPT, False

    def _assume_depth(self, port: sym.TopicPort, topic: str, limit: int) -> None:
        self._assume(
            port, "limit", f"depths.{quoted(topic)}", str(limit), f"keeps {limit} messages of {topic}"
        )

    def _assume(self, element: Marked, mark: str, key: str, value: str, words: str) -> None:
        if self._is_unseen:
            return
        element.assumed = f"{element.assumed} {mark}" if element.assumed else mark
        self.assumed.append(Assumed(self._node.name, key, value, words))
