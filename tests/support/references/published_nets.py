"""Coloured nets of the literature with published counts of states, written down from what they mean."""

from __future__ import annotations

from tests.support.references.coloured import Coloured, Term

DOT: Term = ("constant", "Dot", "dot")


def _v(name: str) -> Term:
    return ("variable", name)


def _t(*parts: Term) -> Term:
    return ("tuple", parts)


def repeated_requests(rows: int) -> Coloured:
    """Clients that repeat requests to servers until an answer comes; requests may get lost.

    ``rows`` servers serve the clients of a square with that many rows, and the buffer has as many slots.
    """
    net = Coloured(
        sorts={
            "Client": ("listed", tuple(map(str, range(rows**2)))),
            "Server": ("listed", tuple(map(str, range(rows)))),
            "Job": ("product", ("Client", "Server")),
            "Dot": ("dot",),
        },
        variables={"c": "Client", "s": "Server"},
        places={
            "Idle": ("Client", ("all", "Client")),
            "Asking": ("Client", None),
            "Requests": ("Client", None),
            "Slots": ("Dot", ("numberof", rows, DOT)),
            "Free": ("Server", ("all", "Server")),
            "Busy": ("Job", None),
        },
        conditions=dict.fromkeys(("begin", "ask", "lose", "serve", "answer")),
    )
    client, server, job = _v("c"), _v("s"), _t(_v("c"), _v("s"))
    net.takes = [
        ("Idle", "begin", client),
        ("Asking", "ask", client),
        ("Slots", "ask", DOT),
        ("Requests", "lose", client),
        ("Requests", "serve", client),
        ("Free", "serve", server),
        ("Asking", "answer", client),
        ("Busy", "answer", job),
    ]
    net.puts = [
        ("Asking", "begin", client),
        ("Asking", "ask", client),
        ("Requests", "ask", client),
        ("Busy", "serve", job),
        ("Slots", "serve", DOT),
        ("Idle", "answer", client),
        ("Free", "answer", server),
    ]
    return net


def peterson(rounds: int) -> Coloured:
    """Peterson's algorithm for one process more than there are rounds.

    In each round, a process makes itself the one that waits, and then looks at the others in turn: it goes on
    once all the others want nothing, or once another process waits.
    """
    i, j, k = map(_v, "ijk")
    last, final = ("constant", "Process", str(rounds)), ("constant", "Round", str(rounds - 1))
    first, zero = ("constant", "Process", "0"), ("constant", "Round", "0")
    yes, no = ("constant", "Wants", "yes"), ("constant", "Wants", "no")
    net = Coloured(
        sorts={
            "Process": ("listed", tuple(map(str, range(rounds + 1)))),
            "Round": ("listed", tuple(map(str, range(rounds)))),
            "Wants": ("listed", ("no", "yes")),
            "Flag": ("product", ("Process", "Wants")),
            "At": ("product", ("Process", "Round")),
            "Waits": ("product", ("Round", "Process")),
            "Looks": ("product", ("Process", "Round", "Process")),
        },
        variables={"i": "Process", "j": "Round", "k": "Process"},
        places={
            "Idle": ("Process", ("all", "Process")),
            "Flags": ("Flag", ("tuples", (("all", "Process"), no))),
            "Waiting": ("Waits", ("tuples", (("all", "Round"), first))),
            "Asks": ("At", None),
            "Tests": ("At", None),
            "Passes": ("At", None),
            "Inside": ("Process", None),
            **dict.fromkeys(("Begins", "Compares", "LooksAt", "Ends"), ("Looks", None)),
        },
        conditions={
            **dict.fromkeys(("ask", "wait", "first", "enter", "leave", "compare", "itself")),
            "other": ("inequality", i, k),
            "second": ("inequality", i, k),
            "next": ("inequality", j, final),
            "on": ("inequality", k, last),
            **dict.fromkeys(("again", "quiet", "done")),
        },
    )
    at, looks = _t(i, j), _t(i, j, k)
    net.takes = [
        *[("Idle", "ask", i), ("Flags", "ask", _t(i, no))],
        *[("Asks", "wait", at), ("Waiting", "wait", _t(j, k))],
        *[("Tests", "first", at), ("Waiting", "first", _t(j, i))],
        *[("Tests", "second", at), ("Waiting", "second", _t(j, k))],
        ("Passes", "enter", _t(i, final)),
        ("Passes", "next", at),
        *[("Inside", "leave", i), ("Flags", "leave", _t(i, yes))],
        ("Begins", "compare", looks),
        ("Compares", "itself", _t(i, j, i)),
        ("Compares", "other", looks),
        ("Ends", "on", looks),
        *[("LooksAt", "again", looks), ("Flags", "again", _t(k, yes))],
        *[("LooksAt", "quiet", looks), ("Flags", "quiet", _t(k, no))],
        ("Ends", "done", _t(i, j, last)),
    ]
    net.puts = [
        *[("Asks", "ask", _t(i, zero)), ("Flags", "ask", _t(i, yes))],
        *[("Tests", "wait", at), ("Waiting", "wait", _t(j, i))],
        *[("Begins", "first", _t(i, j, first)), ("Waiting", "first", _t(j, i))],
        *[("Passes", "second", at), ("Waiting", "second", _t(j, k))],
        ("Inside", "enter", i),
        ("Asks", "next", _t(i, ("successor", j))),
        *[("Idle", "leave", i), ("Flags", "leave", _t(i, no))],
        ("Compares", "compare", looks),
        ("Ends", "itself", _t(i, j, i)),
        ("LooksAt", "other", looks),
        ("Begins", "on", _t(i, j, ("successor", k))),
        *[("Tests", "again", at), ("Flags", "again", _t(k, yes))],
        *[("Ends", "quiet", looks), ("Flags", "quiet", _t(k, no))],
        ("Passes", "done", at),
    ]
    return net


def safe_bus(stations: int) -> Coloured:
    """Stations that share a cable under a controller; messages and acknowledgements may get lost."""
    i, j, r, x = map(_v, "ijrx")
    job, ticket, begins = _t(i, r), _t(i, x), ("constant", "Station", "1")
    net = Coloured(
        sorts={
            "Station": ("listed", tuple(map(str, range(1, stations + 1)))),
            "Pair": ("product", ("Station", "Station")),
            "Dot": ("dot",),
        },
        variables=dict.fromkeys("ijrx", "Station"),
        places={
            "Asked": ("Station", begins),
            "Served": ("Station", begins),
            "Receivers": ("Station", ("all", "Station")),
            "Listening": ("Station", ("all", "Station")),
            "Tickets": ("Pair", None),
            "WaitForCable": ("Station", None),
            "WaitForMessage": ("Station", None),
            "WaitForAnswer": ("Pair", None),
            "Received": ("Station", None),
            "CableFree": ("Dot", DOT),
            "CableUsed": ("Station", None),
            "Granted": ("Station", None),
            "Refused": ("Station", None),
            "GivenBack": ("Station", None),
            "NothingGivenBack": ("Dot", DOT),
            "Message": ("Station", None),
            "Answer": ("Dot", None),
            "Armed": ("Dot", DOT),
            "Expired": ("Dot", None),
            "Late": ("Dot", None),
        },
        conditions={
            "emit": ("inequality", r, i),
            **dict.fromkeys(("ask", "askAgain", "grant", "refuse", "giveUp", "hear", "read", "finish")),
            **dict.fromkeys(("release", "loseMessage", "loseAnswer", "resend", "arm")),
        },
    )
    following = ("successor", x)
    steps: dict[str, tuple[list[tuple[str, Term]], list[tuple[str, Term]]]] = {
        "ask": (
            [("Listening", i), ("Asked", x)],
            [("Asked", following), ("WaitForCable", i), ("Tickets", ticket)],
        ),
        "askAgain": (
            [("Received", i), ("Asked", x)],
            [("Asked", following), ("WaitForCable", i), ("Tickets", ticket)],
        ),
        "grant": (
            [("Served", x), ("Tickets", ticket), ("CableFree", DOT), ("NothingGivenBack", DOT)],
            [("Served", following), ("CableUsed", i), ("Granted", i), ("NothingGivenBack", DOT)],
        ),
        "refuse": (
            [("Served", x), ("Tickets", ticket), ("CableUsed", j), ("NothingGivenBack", DOT)],
            [("Served", following), ("CableUsed", j), ("Refused", i), ("NothingGivenBack", DOT)],
        ),
        "giveUp": ([("WaitForCable", i), ("Refused", i)], [("WaitForMessage", i)]),
        "emit": (
            [("Receivers", r), ("WaitForCable", i), ("Granted", i)],
            [("Receivers", r), ("WaitForAnswer", job), ("Message", r)],
        ),
        "hear": ([("Listening", i), ("Message", i)], [("Listening", i), ("Answer", DOT)]),
        "read": ([("WaitForMessage", i), ("Message", i)], [("Received", i), ("Answer", DOT)]),
        "finish": (
            [("WaitForAnswer", job), ("Answer", DOT), ("NothingGivenBack", DOT)],
            [("Listening", i), ("GivenBack", i)],
        ),
        "release": ([("GivenBack", i), ("CableUsed", i)], [("CableFree", DOT), ("NothingGivenBack", DOT)]),
        "loseMessage": ([("Message", r), ("Armed", DOT)], [("Expired", DOT), ("Late", DOT)]),
        "loseAnswer": ([("Answer", DOT), ("Armed", DOT)], [("Expired", DOT), ("Late", DOT)]),
        "resend": ([("WaitForAnswer", job), ("Expired", DOT)], [("WaitForAnswer", job), ("Message", r)]),
        "arm": ([("GivenBack", i), ("Late", DOT)], [("GivenBack", i), ("Armed", DOT)]),
    }
    for transition, (takes, puts) in steps.items():
        net.takes += [(place, transition, term) for place, term in takes]
        net.puts += [(place, transition, term) for place, term in puts]
    return net


def shared_memory(processors: int) -> Coloured:
    """Processors with a memory each; one at a time uses the memory of another one, over a bus."""
    p, m, use = _v("p"), _v("m"), _t(_v("p"), _v("m"))
    net = Coloured(
        sorts={
            "Processor": ("listed", tuple(map(str, range(processors)))),
            "Use": ("product", ("Processor", "Processor")),
            "Dot": ("dot",),
        },
        variables={"p": "Processor", "m": "Processor"},
        places={
            "Active": ("Processor", ("all", "Processor")),
            "Memories": ("Processor", ("all", "Processor")),
            "Bus": ("Dot", DOT),
            "AtHome": ("Processor", None),
            "Queue": ("Processor", None),
            "Abroad": ("Use", None),
        },
        conditions={
            **dict.fromkeys(("stay", "goHome", "leave", "comeBack")),
            "begin": ("inequality", p, m),
        },
    )
    net.takes = [
        ("Active", "stay", p),
        *[("AtHome", "goHome", p), ("Memories", "goHome", p)],
        ("Active", "leave", p),
        *[("Queue", "begin", p), ("Memories", "begin", m), ("Bus", "begin", DOT)],
        ("Abroad", "comeBack", use),
    ]
    net.puts = [
        ("AtHome", "stay", p),
        *[("Active", "goHome", p), ("Memories", "goHome", p)],
        ("Queue", "leave", p),
        ("Abroad", "begin", use),
        *[("Active", "comeBack", p), ("Memories", "comeBack", m), ("Bus", "comeBack", DOT)],
    ]
    return net
