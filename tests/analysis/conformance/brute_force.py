"""Whether traces are a behaviour of a model, by trying every order: slow, and too simple to be wrong."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

from dineros.analysis.model.step_roles import StepRole, step_roles
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.models import compile_net
from dineros.metamodel import sym
from dineros.metamodel.records import (
    Drop,
    Fire,
    Publish,
    Record,
    Reply,
    Request,
    Response,
    Serve,
    Signal,
    Take,
    Transfer,
)
from dineros.metamodel.records.schema import ChannelStep, Step
from dineros.transformations.flattening.flatten import flatten

_Positions = tuple[int, ...]
_Marking = tuple[int, ...]

_AFTER: dict[type[Record], type[Record]] = {Take: Publish, Serve: Request, Reply: Serve, Response: Reply}


class TooLargeError(Exception):
    """There are more orders than shall be tried."""


def is_behaviour(
    model: sym.SystemModel, traces: Mapping[str, Sequence[Record]], limit: int = 200_000
) -> bool:
    """Try all orders; starts are taken as they should be."""
    flattened = flatten(model, "fully-enabled")
    net = compile_net(flattened.net)
    roles = {net.transitions.index(name): role for name, role in step_roles(flattened.trace.links).items()}
    # Nobody sees how a topic of ROS 2 loses a message, only later that it has.
    unseen = (Transfer, Drop) if model.middleware == sym.Middleware.ros2 else (Transfer,)
    silent = [index for index, role in roles.items() if role.kind in unseen]
    steps = [
        [record for record in records if isinstance(record, Step) and type(record) not in unseen]
        for records in traces.values()
    ]
    if not _each_once(steps):
        return False
    nameless = {
        record.channel
        for trace in steps
        for record in trace
        if isinstance(record, Reply) and not record.message
    }
    clients = {
        record.message: record.client for trace in steps for record in trace if isinstance(record, Request)
    }
    firings = [[_transitions(record, roles, net.transitions, clients) for record in trace] for trace in steps]
    came: dict[tuple[type[Record], str | None], tuple[int, int]] = {
        (type(record), record.message): (node, position)
        for node, trace in enumerate(steps)
        for position, record in enumerate(trace)
        if isinstance(record, ChannelStep)
    }
    first = (tuple(0 for _ in steps), tuple(net.initial.tolist()))
    seen, stack = {first}, [first]
    while stack:
        positions, marking = stack.pop()
        if all(position == len(trace) for position, trace in zip(positions, steps, strict=True)):
            return True
        for new in _following(positions, marking, steps, firings, came, silent, net, nameless):
            if new not in seen:
                if len(seen) > limit:
                    raise TooLargeError
                seen.add(new)
                stack.append(new)
    return False


def _following(
    positions: _Positions,
    marking: _Marking,
    steps: Sequence[Sequence[Record]],
    firings: Sequence[Sequence[list[int] | None]],
    came: Mapping[tuple[type[Record], str | None], tuple[int, int]],
    silent: Sequence[int],
    net: CompiledNet,
    nameless: Collection[str],
) -> Iterator[tuple[_Positions, _Marking]]:
    for transition in silent:
        if net.is_enabled(transition, marking):
            yield positions, tuple(net.fire(transition, marking))
    for node, position in enumerate(positions):
        if position == len(steps[node]):
            continue
        record = steps[node][position]
        after = _AFTER.get(type(record))
        if isinstance(record, ChannelStep) and (
            not record.message or (isinstance(record, Response) and record.channel in nameless)
        ):
            after = None  # the net alone tells whether there is such a message
        if after is not None:
            other, at = came.get((after, getattr(record, "message", None)), (0, 10**9))
            if positions[other] <= at:
                continue
        moved = (*positions[:node], position + 1, *positions[node + 1 :])
        options = firings[node][position]
        if options is None:  # a signal that nothing uses
            yield moved, marking
        for transition in options or ():
            if net.is_enabled(transition, marking):
                yield moved, tuple(net.fire(transition, marking))


def _each_once(steps: Sequence[Sequence[Record]]) -> bool:
    seen = set()
    for trace in steps:
        for record in trace:
            if isinstance(record, ChannelStep) and record.message:
                place = record.place if isinstance(record, Take) else ""
                key = (type(record), record.message, place)
                if key in seen:
                    return False
                seen.add(key)
    return True


def _transitions(
    record: Record,
    roles: Mapping[int, StepRole],
    names: Sequence[str],
    clients: Mapping[str | None, str | None],
) -> list[int] | None:
    found = []
    for index, role in roles.items():
        if role.kind is not type(record) or role.node != record.node:
            continue
        if isinstance(record, Fire) and names[index] != record.transition:
            continue
        for name, value in role.fields().items():
            expected = getattr(record, name)
            if name == "client" and not getattr(record, "message", None) and expected is None:
                continue  # any client
            if name == "client" and expected is None:
                expected = clients.get(getattr(record, "message", None))
            if expected != value:
                break
        else:
            found.append(index)
    return None if isinstance(record, Signal) and not found else found
