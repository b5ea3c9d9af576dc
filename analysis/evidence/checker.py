"""Checks certificates: that no reachable marking does what a question asks for. No engine has a part in it.

A certificate holds facts about all reachable markings m of a net with the initial marking m0, each checked by
itself, and all together must contradict what is asked for:

* a weighting y that no firing raises: y . m <= y . m0 (a place invariant, where no firing lowers it either);
* a trap that is marked at first, so that it never runs empty;
* clauses of inequalities that hold at first, and after a firing if they held in the last few markings.

Read are the model itself and the formula. Libraries propose, numbers are checked here, in integers.

References
----------
T. Murata, *Petri nets: properties, analysis and applications*, Proc. IEEE 77(4), 1989 (invariants, traps). M.
Sheeran, S. Singh, G. Stålmarck, *Checking safety properties using induction and a SAT-solver*, FMCAD 2000.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from dineros.analysis.evidence.deciding import Decider, UndecidedError
from dineros.analysis.evidence.reading import Condition, Net, digest, excluded, inequality
from dineros.metamodel import pn
from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.files.reading import read_bytes
from dineros.metamodel.json_text import decode_json

FORMAT = "dineros certificate 1"
SIZE_LIMIT = 16 << 20
"""Bytes of a file."""

LARGEST = 1 << 60
"""Largest factor or number."""

MOST_STEPS, MOST_MARKINGS, MOST_SEQUENCES = 16, 20_000, 20_000
"""Of an induction; markings are those that are reached in fewer steps, sequences those of firings."""

Clauses = list[list[Condition]]


class CertificateFileError(DinerosError):
    """A file holds no certificate."""


def read_certificate(path: Path) -> dict[str, Any]:
    """Read a certificate.

    Raises
    ------
    CertificateFileError
        It is none.
    ModelFileError
        The file cannot be read, or is too large.
    """
    found = decode_json(read_bytes(path, SIZE_LIMIT), location=Location(path))
    if not _is_certificate(found):
        hint = "'dineros find' and 'dineros verify' write some with --certificate"
        raise CertificateFileError("holds no certificate", location=Location(path), hint=hint)
    return dict(found)


def refutation(certificate: Mapping[str, Any], model: pn.Net, location: Location | None = None) -> str:
    """Return what is wrong with a certificate about a model; nothing where it stands.

    Parameters
    ----------
    certificate : mapping
        As `read_certificate` returns it.
    model : pn.Net
        The model, changed as the certificate's settings say.
    location : Location, optional
        Where the certificate stands, for errors.

    Raises
    ------
    DinerosError
        The model cannot be read as a net, or the question not as one of it.
    """
    if certificate["digest"] != sealed(certificate)["digest"]:
        return "it was changed after it was written"
    net = Net.of(model, certificate["signals"], certificate["overflow"])
    if certificate["net"] != net.digest:
        return "it is about another net"
    asked = certificate["question"]
    try:
        goal = excluded(net, asked["kind"], asked["text"], certificate["answer"])
    except DinerosError as error:
        error.location = error.location or location
        raise
    if certificate["excluded"] != goal:
        return "the question asks for something else than what is excluded"
    try:
        decider = Decider()
        for number, fact in enumerate(certificate["facts"], 1):
            if wrong := add_fact(net, decider, fact):
                return f"fact {number}: {wrong}"
        marking = decider.marking([decider.encode(goal)])
    except UndecidedError:
        return "whether the facts suffice could not be decided"
    return "" if marking is None else f"the facts do not exclude {_shown(marking)}"


def sealed(certificate: Mapping[str, Any]) -> dict[str, Any]:
    """Return a certificate with the digest of what it says."""
    says = {name: value for name, value in certificate.items() if name != "digest"}
    return {**says, "digest": digest(says)}


def add_fact(net: Net, decider: Decider, fact: Mapping[str, Any]) -> str:
    """Check a fact, of which earlier ones are known, and let it be known; return what is wrong with it."""
    named = set(fact.get("weights", fact.get("trap", ())))
    named |= {p for clause in fact.get("clauses", ()) for row in clause for p in row["sum"]}
    if unknown := sorted(named - net.tokens.keys()):
        return f"the net has no place {unknown[0]!r}"
    if "weights" in fact:
        return _add_weights(net, decider, fact["weights"])
    if "trap" in fact:
        return _add_trap(net, decider, fact["trap"])
    return _Induction(net, decider, fact["clauses"]).add(fact["steps"])


def _add_weights(net: Net, decider: Decider, weights: Mapping[str, int]) -> str:
    for name in net.firings:
        if sum(weights.get(p, 0) * gain for p, gain in net.change(name).items()) > 0:
            return f"firing {name} raises the weighted sum"
    total = sum(weight * net.tokens[p] for p, weight in weights.items())
    decider.add([decider.literal(inequality({p: -weight for p, weight in weights.items()}, -total))])
    return ""


def _add_trap(net: Net, decider: Decider, places: Sequence[str]) -> str:
    for name, (takes, puts, _) in net.firings.items():
        if not takes.keys().isdisjoint(places) and puts.keys().isdisjoint(places):
            return f"firing {name} takes from the trap and puts nothing into it"
    if not any(net.tokens[p] for p in places):
        return "the trap is not marked at first"
    decider.add([decider.literal(inequality({p: 1}, 1)) for p in places])
    return ""


class _Induction:
    """Clauses that hold in the first markings, and after some markings in which they hold."""

    def __init__(self, net: Net, decider: Decider, clauses: Clauses) -> None:
        self.net, self.decider, self.clauses = net, decider, clauses
        self.sequences = 0

    def add(self, steps: int) -> str:
        for marking in self._first(steps):
            if not all(any(_holds(row, marking) for row in clause) for clause in self.clauses):
                return f"a clause does not hold in {_shown(marking)}"
        self._assume({}, [])
        return self._step(steps, {}, [])

    def _first(self, steps: int) -> list[dict[str, int]]:
        """Return the markings that are reached in fewer steps than some."""
        found = {tuple(self.net.tokens.values()): self.net.tokens}
        level = list(found.values())
        for _ in range(steps - 1):
            before, level = level, []
            for marking in before:
                for name in self.net.firings:
                    if all(_holds(row, marking) for row in self.net.enabling(name)):
                        gained = self.net.change(name)
                        after = {p: tokens + gained.get(p, 0) for p, tokens in marking.items()}
                        if tuple(after.values()) not in found:
                            found[tuple(after.values())] = after
                            level.append(after)
                if len(found) > MOST_MARKINGS:
                    raise UndecidedError
        return list(found.values())

    def _assume(self, gained: Mapping[str, int], condition: Sequence[int]) -> None:
        """Let the clauses be known of the marking after some firings; where a condition is, if that holds."""
        for clause in self.clauses:
            literals = [self.decider.literal(_after(row, gained)) for row in clause]
            self.decider.add([*(-literal for literal in condition), *literals])

    def _step(self, left: int, gained: Mapping[str, int], assumed: Sequence[int]) -> str:
        """Fire everything after what was fired, while clauses hold: they must hold after the last step."""
        for name in self.net.firings:
            change = self.net.change(name)
            after = {p: gained.get(p, 0) + change.get(p, 0) for p in {*gained, *change}}
            enabling = [self.decider.literal(_after(row, gained)) for row in self.net.enabling(name)]
            self.sequences += 1
            if self.sequences > max(MOST_SEQUENCES, len(self.net.firings)):
                raise UndecidedError
            if left > 1:
                if self.decider.marking([*assumed, *enabling]) is not None:
                    selector = self.decider.new()
                    self._assume(after, [selector])
                    if wrong := self._step(left - 1, after, [*assumed, *enabling, selector]):
                        return wrong
                continue
            for clause in self.clauses:
                # Where no sum of a clause falls, what held before holds still.
                if all(sum(k * change.get(p, 0) for p, k in row["sum"].items()) >= 0 for row in clause):
                    continue
                failing = [-self.decider.literal(_after(row, after)) for row in clause]
                if (marking := self.decider.marking([*assumed, *enabling, *failing])) is not None:
                    return f"firing {name} can end a clause, from {_shown(marking)}"
        return ""


def _after(row: Condition, gained: Mapping[str, int]) -> Condition:
    """Return what a sum must have been before places gained tokens."""
    gain = sum(k * gained.get(p, 0) for p, k in row["sum"].items())
    return inequality(row["sum"], row["least"] - gain)


def _holds(row: Condition, marking: Mapping[str, int]) -> bool:
    return bool(sum(k * marking[p] for p, k in row["sum"].items()) >= row["least"])


def _shown(marking: Mapping[str, int]) -> str:
    marked = [f"{p} {tokens}" for p, tokens in sorted(marking.items()) if tokens]
    more = f" and {len(marked) - 10} more" if len(marked) > 10 else ""
    return f"a marking with {', '.join(marked[:10]) or 'no tokens'}{more}"


def _is_certificate(found: object) -> bool:
    texts = {"format", "net", "model", "signals", "overflow", "answer", "digest"}
    return (
        isinstance(found, dict)
        and found.keys() == texts | {"settings", "question", "excluded", "facts"}
        and all(isinstance(found[name], str) for name in texts)
        and found["format"] == FORMAT
        and found["signals"] in ("none", "fully-enabled", "input-enabled", "io-enabled")
        and found["overflow"] in ("weighted", "inhibitor")
        and _is_list(found["settings"], lambda text: isinstance(text, str))
        and isinstance(found["question"], dict)
        and found["question"].keys() == {"kind", "text"}
        and all(isinstance(text, str) for text in found["question"].values())
        and _is_list(found["facts"], _is_fact)
    )


def _is_fact(fact: Any) -> bool:
    if not isinstance(fact, dict):
        return False
    if fact.keys() == {"weights"}:
        return _is_weights(fact["weights"])
    if fact.keys() == {"trap"}:
        return _is_list(fact["trap"], lambda place: isinstance(place, str))
    return (
        fact.keys() == {"clauses", "steps"}
        and _is_list(fact["clauses"], lambda clause: _is_list(clause, _is_row))
        and _is_number(fact["steps"])
        and 1 <= fact["steps"] <= MOST_STEPS
    )


def _is_row(row: Any) -> bool:
    is_row = isinstance(row, dict) and row.keys() == {"sum", "least"}
    return is_row and _is_weights(row["sum"]) and _is_number(row["least"])


def _is_weights(weights: Any) -> bool:
    return isinstance(weights, dict) and all(map(_is_number, weights.values()))


def _is_number(number: Any) -> bool:
    return isinstance(number, int) and not isinstance(number, bool) and abs(number) <= LARGEST


def _is_list(found: Any, fits: Any) -> bool:
    return isinstance(found, list) and all(map(fits, found))
