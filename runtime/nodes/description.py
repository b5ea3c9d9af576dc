"""A static description of a node: its part of the model, its ports, its handlers."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from dineros.runtime.nets.ports import Port
from dineros.runtime.nodes.core import Core

_HIDDEN = ("mappings", "token_type", "place_types")
"""Fields of ports that only encoders need."""

_KINDS = ("publishers", "subscribers", "clients", "servers", "action_clients", "action_servers")


def description_of(core: Core) -> dict[str, Any]:
    """Return the description of a node as JSON values; from any thread."""
    structure = core.structure
    ports = structure.ports
    return {
        "model": ports.model,
        "node": ports.node,
        "middleware": ports.middleware,
        "managed": ports.is_managed,
        "seed": core.seed,
        "places": {
            id: {"tokens": len(tokens), "capacity": capacity}
            for id, tokens, capacity in zip(
                structure.places, structure.initial, structure.capacities, strict=True
            )
        },
        "transitions": list(structure.transitions),
        "signals": dict(zip(structure.signals, structure.initial_signals, strict=True)),
        "timers": {timer.callback: timer.period for timer in ports.timers},
        "handlers": [
            {
                "transition": handler.transition,
                "name": handler.name,
                "thread": handler.thread or handler.is_asynchronous,
                "timeout": handler.timeout,
                "budget": handler.budget,
            }
            for handler in core.handlers.all()
        ],
        **{kind: [_port(port) for port in getattr(ports, kind)] for kind in _KINDS},
    }


def _port(port: Port) -> dict[str, Any]:
    return {name: value for name, value in asdict(port).items() if name not in _HIDDEN}
