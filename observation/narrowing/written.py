"""Writes the facts given for a system as TOML 1.0."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping

from dineros.observation.importing.given import (
    Given,
    GivenCallback,
    GivenNode,
    GivenService,
    GivenTopic,
    Span,
)


def given_text(given: Given) -> str:
    """Return a text that `dineros.observation.importing.given.read_given` reads as equal facts."""
    tables = [
        *(table for name in sorted(given.nodes) for table in _node(name, given.nodes[name])),
        *(_channel(f"topic.{_text(name)}", given.topics[name]) for name in sorted(given.topics)),
        *(_channel(f"service.{_text(name)}", given.services[name]) for name in sorted(given.services)),
        *(_channel(f"action.{_text(name)}", given.actions[name]) for name in sorted(given.actions)),
    ]
    times = {"latency": _span(given.latency), "takes": _span(given.takes)}
    if any(times.values()):
        tables.append(_table("times", times))
    return "\n".join(tables)


def _node(name: str, said: GivenNode) -> Iterator[str]:
    lines = {
        "threads": None if said.threads is None else str(said.threads),
        "order": None if said.order is None else _text(said.order),
        "groups": _inline(said.groups) if said.groups else None,
        "depths": _inline(said.depths) if said.depths else None,
        "newest": _inline(said.newest) if said.newest else None,
        "timers": None if said.timers is None else _inline(said.timers),
        "lifecycle": None if said.lifecycle is None else _list(said.lifecycle),
    }
    yield _table(f"node.{_text(name)}", lines)
    for callback, its in sorted(said.callbacks.items()):
        yield _table(f"node.{_text(name)}.callback.{_text(callback)}", _callback(its))


def _callback(said: GivenCallback) -> dict[str, str | None]:
    least, most = said.takes or (0.0, None)
    does = None if said.does is None else [*map(str, said.does)]
    if does is not None and most is None and least:  # it sleeps, and works for an unknown time
        does.append(f"sleep {least:.9f}")
    return {
        "does": None if does is None else _list(does),
        "group": None if said.group is None else _text(said.group),
        "awaits": "true" if said.awaits else None,
        "takes": None if most is None else _span((least, most)),
        "offset": _span(said.offset),
        "jitter": None if said.jitter is None else json.dumps(said.jitter),
        "measured": _text(said.measured) if said.measured else None,
        "outstanding": None if said.outstanding is None else str(said.outstanding),
    }


def _channel(name: str, said: GivenTopic | GivenService) -> str:
    """Return the facts given for a channel; actions have no `publishers = []`."""
    lines = {end: _list(nodes) for end, nodes in vars(said).items() if end != "latency" and nodes}
    return _table(name, {**lines, "latency": _span(said.latency)})


def _span(span: Span | None) -> str | None:
    return None if span is None else json.dumps([*span])


def _table(name: str, lines: Mapping[str, str | None]) -> str:
    return "".join(
        [f"[{name}]\n", *(f"{key} = {value}\n" for key, value in lines.items() if value is not None)]
    )


def _inline(values: Mapping[str, str | int | float]) -> str:
    return "{" + ", ".join(f"{_text(name)} = {json.dumps(values[name])}" for name in sorted(values)) + "}"


def _list(texts: Iterable[str]) -> str:
    return "[" + ", ".join(map(_text, texts)) + "]"


def _text(text: str) -> str:
    """Return a basic string: that of JSON, except one character that TOML requires to be escaped."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
