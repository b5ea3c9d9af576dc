"""Facts that people give about nodes override those of the code."""

from __future__ import annotations

from dataclasses import replace

from dineros.observation.importing.given import Given, GivenCallback, GivenNode


def merged(code: Given, people: Given) -> Given:
    """Return the facts of the code, overridden by facts that users give for the same nodes."""
    nodes = dict(code.nodes)
    for name, said in people.nodes.items():
        known = nodes.get(name, GivenNode())
        nodes[name] = replace(
            known,
            threads=said.threads if said.threads is not None else known.threads,
            order=said.order if said.order is not None else known.order,
            groups={**known.groups, **said.groups},
            depths={**known.depths, **said.depths},
            timers=said.timers if said.timers is not None else known.timers,
            lifecycle=said.lifecycle if said.lifecycle is not None else known.lifecycle,
            callbacks={
                **known.callbacks,
                **{key: _corrected(known.callbacks.get(key), each) for key, each in said.callbacks.items()},
            },
            newest={**known.newest, **said.newest},
            open_timers=known.open_timers if said.timers is None else frozenset(),
            open_threads=known.open_threads if said.threads is None else None,
            variables=known.variables if all(each.does is None for each in said.callbacks.values()) else {},
        )
    return replace(people, nodes=nodes, deciding=code.deciding)


def _corrected(code: GivenCallback | None, said: GivenCallback) -> GivenCallback:
    """Return the facts of a callback from the code, overridden by those that users give."""
    if code is None:
        return said
    return replace(
        code,
        does=code.does if said.does is None else said.does,
        group=code.group if said.group is None else said.group,
        awaits=said.awaits or (said.does is None and code.awaits),
        takes=code.takes if said.takes is None else said.takes,
        received=code.received if said.does is None else None,
        flow=code.flow if said.does is None else None,
        offset=said.offset,
        jitter=said.jitter,
        measured=said.measured,
        outstanding=said.outstanding,
        has_open_group=code.has_open_group and said.group is None,
    )
