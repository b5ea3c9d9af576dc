"""System models of small timed systems.

A system is a dictionary: `nodes` with threads, `latency` by topic and service, `chains`, and `callbacks` with
a `script` of steps. ``["work", a, b]`` takes a to b units, ``["publish", topic]`` no time, ``["open", a, b,
topic]`` works for a to b and publishes at any moment of that, ``["call", service, group]`` waits for a
response that comes to a client in that group, and ``["call", service, group, timeout]`` no longer than that.
A callback that works once can have `stores`, the name of a value of its node that it replaces when it ends,
and `samples`, the names of values that it reads.
"""

from __future__ import annotations

from typing import Any

from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, flow, here, node_net, place, read, seconds, step
from dineros.metamodel.constraints import validate

System = dict[str, Any]


def model_of(system: System, unit: float = 1.0) -> sym.SystemModel:
    """Return the system model of a system; a unit of its times is so many seconds."""
    return _Maker(system, unit).made()


class _Maker:
    def __init__(self, system: System, unit: float) -> None:
        self.system = system
        self.unit = unit
        self.model = sym.SystemModel(id="system", middleware="ros2")
        self.nodes: dict[str, sym.NodeNet] = {}
        self.groups: dict[tuple[str, str], sym.CallbackGroup] = {}
        self.publishers: dict[tuple[str, str], sym.Place] = {}
        """By topic and node."""
        self.values: dict[str, sym.Place] = {}
        self.readers: dict[str, list[tuple[sym.Place, int]]] = {}
        self.servers: dict[str, tuple[sym.CallbackPage, pn.Place, pn.Place]] = {}
        self.calls: list[tuple[str, str, sym.ClientPort]] = []

    def made(self) -> sym.SystemModel:
        for name, node in self.system["nodes"].items():
            self.nodes[name] = node_net(
                self.model,
                name,
                execution="callbacks",
                threads=node["threads"],
                order=node.get("order", "any"),
            )
        for each in self.system["callbacks"]:
            self._callback(each)
        for topic, readers in self.readers.items():
            self._topic(topic, readers)
        for topic in dict.fromkeys(topic for topic, _ in self.publishers):
            if topic not in self.readers:
                self._topic(topic, [])
        for service, (page, entry, exit_) in self.servers.items():
            self._service(service, page, entry, exit_)
        wrong = [each for each in validate(self.model) if each.severity == "error"]
        assert not wrong, wrong
        return self.model

    def interval(self, least: float, most: float) -> pn.TimeInterval:
        return seconds(round(least * self.unit, 9), round(most * self.unit, 9))

    def _group(self, node: str, group: str) -> sym.CallbackGroup | None:
        if group == "default":
            return None
        if (node, group) not in self.groups:
            made = sym.CallbackGroup(
                id=f"{node}.{group}",
                name=group,
                kind="reentrant" if group == "reentrant" else "exclusive",
            )
            self.nodes[node].callbackGroups.append(made)
            self.groups[node, group] = made
        return self.groups[node, group]

    def _callback(self, each: dict[str, Any]) -> None:
        name, net = each["name"], self.nodes[each["node"]]
        kind = "timer" if "period" in each else "subscriber" if "topic" in each else "server"
        page = callback(net, name, kind)
        page.group = self._group(each["node"], each["group"])
        if kind == "timer":
            page.timer = round(each["period"] * self.unit, 9)
            if "jitter" in each:
                page.jitter = round(each["jitter"] * self.unit, 9)
            if each["offset"] != "any":
                offset = each["offset"]
                page.offset = self.interval(*(offset if isinstance(offset, list) else (offset, offset)))
        before: list[pn.PlaceNode] = []
        if kind == "subscriber":
            heard = place(page, f"{name}.heard")
            before = [heard]
            self.readers.setdefault(each["topic"], []).append((heard, each["depth"]))
        after: list[pn.PlaceNode] = []
        if kind == "server":
            entry, exit_ = place(page, f"{name}.entry"), place(page, f"{name}.exit")
            before, after = [entry], [exit_]
            self.servers[each["service"]] = (page, entry, exit_)
        script = each["script"]
        kinds = [step_[0] for step_ in script]
        if kinds in (["work"], ["work", "publish"]):
            page.duration = self.interval(*script[0][1:3])
            does = step(page, f"{name}.do", before, [*self._published(page, script[1:]), *after])
            if "stores" in each:
                value = here(self._value(each["node"], each["stores"]), page)
                flow(value, does)
                flow(does, value)
            for sampled in each.get("samples", ()):
                read(here(self._value(each["node"], sampled), page), does)
        elif kinds == ["open"]:
            page.duration = self.interval(*script[0][1:3])
            told = place(page, f"{name}.told")
            step(page, f"{name}.tell", before, [told, self._publisher(page, script[0][3])])
            step(page, f"{name}.end", [told], after)
        else:
            self._script(page, each, before, after)

    def _value(self, node: str, name: str) -> sym.Place:
        """Return the place of a stored value; there is one from the start."""
        if name not in self.values:
            self.values[name] = place(self.nodes[node], f"{name}.value", tokens=1)
        return self.values[name]

    def _published(self, page: pn.Page, steps: list[Any]) -> list[pn.PlaceNode]:
        return [self._publisher(page, topic) for _, topic in steps]

    def _publisher(self, page: pn.Page, topic: str) -> pn.PlaceNode:
        assert page.page is not None
        node = str(page.page.id)
        if (topic, node) not in self.publishers:
            is_first = all(topic != other for other, _ in self.publishers)
            self.publishers[topic, node] = place(page, f"{topic}.out" if is_first else f"{topic}.out.{node}")
        return here(self.publishers[topic, node], page)

    def _script(
        self,
        page: sym.CallbackPage,
        each: dict[str, Any],
        before: list[pn.PlaceNode],
        after: list[pn.PlaceNode],
    ) -> None:
        """Make a transition with an interval of each piece of work."""
        name = each["name"]
        steps = list(each["script"])
        number = 0
        late: pn.PlaceNode | None = None
        while steps:
            number += 1
            port: sym.ClientPort | None = None
            first = steps.pop(0)
            tells: list[pn.PlaceNode] = []
            if first[0] == "open":
                before = self._open(page, f"{name}.{number}", first, before)
                takes = [0, 0]
            else:
                assert first[0] == "work", first
                takes = first[1:3]
            onward: list[pn.PlaceNode] = []
            while steps and steps[0][0] == "publish":
                tells.append(self._publisher(page, steps.pop(0)[1]))
            if steps and steps[0][0] == "call":
                _, service, group, *timeout = steps.pop(0)
                request = place(page, f"{name}.{number}.request")
                response = place(page, f"{name}.{number}.response")
                port = sym.ClientPort(client=f"{name}.{number}", request=request, response=response)
                if timeout:
                    port.timeout = round(timeout[0] * self.unit, 9)
                    port.timedOut = place(page, f"{name}.{number}.late")
                self.calls.append((service, group, port))
                tells.append(request)
                onward = [response]
            elif steps:
                onward = [place(page, f"{name}.{number}.done")]
                tells.append(onward[0])
            else:
                tells.extend(after)
            step(page, f"{name}.do{number}", before, tells).interval = self.interval(*takes)
            if late is not None:
                step(page, f"{name}.late{number}", [late], tells).interval = self.interval(*takes)
            before = onward
            late = port.timedOut if port is not None else None

    def _open(
        self, page: sym.CallbackPage, name: str, opened: list[Any], before: list[pn.PlaceNode]
    ) -> list[pn.PlaceNode]:
        """Work, and publish once at any moment of that, with intervals alone."""
        _, least, most, topic = opened
        works, worked = place(page, f"{name}.works"), place(page, f"{name}.worked")
        silent, told = place(page, f"{name}.silent"), place(page, f"{name}.told")
        step(page, f"{name}.fork", before, [works, silent]).interval = self.interval(0, 0)
        step(page, f"{name}.work", [works], [worked]).interval = self.interval(least, most)
        out = self._publisher(page, topic)
        step(page, f"{name}.tell", [silent], [told, out])
        late = step(page, f"{name}.late", [silent, worked], [told, worked, out])
        late.interval = self.interval(0, 0)
        return [worked, told]

    def _topic(self, topic: str, readers: list[tuple[sym.Place, int]]) -> None:
        made = sym.TopicChannel(id=topic, topic=topic)
        for (other, _), source in self.publishers.items():
            if other == topic:
                made.publishers.append(sym.PublisherPort(place=source, limit=10))
        for sink, depth in readers:
            made.subscribers.append(sym.SubscriberPort(place=sink, limit=depth))
        made.latency = self.interval(*self.system["latency"].get(topic, (0, 0)))
        self.model.channels.append(made)

    def _service(self, service: str, page: sym.CallbackPage, entry: pn.Place, exit_: pn.Place) -> None:
        made = sym.ServiceChannel(id=f"{service}.service", service=service, depth=10)
        made.server = sym.ServerPort(page=page, entry=entry, exit=exit_)
        for called, group, port in self.calls:
            if called == service:
                node = port.request.page.page if port.request.page is not None else None
                assert node is not None
                port.group = self._group(str(node.id), group)
                made.clients.append(port)
        made.latency = self.interval(*self.system["latency"].get(service, (0, 0)))
        self.model.channels.append(made)


__all__ = ["System", "flow", "model_of"]
