"""Certificates prove what they say: whatever is accepted is true, and what was changed is refused."""

from __future__ import annotations

import ast
import copy
import itertools
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.evidence import Inductive, Row
from dineros.analysis.evidence.certificate import (
    FORMAT,
    CertificateFileError,
    difference,
    read_certificate,
    sealed,
    write_certificate,
)
from dineros.analysis.evidence.checker import _Markings, excluded, refutation
from dineros.analysis.evidence.proving import Asked, certificate_of, proved
from dineros.analysis.logic.language.atoms import BoundAtoms, Step
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import TRUE
from dineros.analysis.model.subject import Subject, subject_of
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.models import to_model
from dineros.analysis.proofs.induction import sums_of
from dineros.metamodel.errors import DinerosError
from tests.analysis.classic_nets import round_robin_mutex
from tests.analysis.strategies import nets

ROOT = Path(__file__).resolve().parents[3]
MOST = 3_000


def subject(net: CompiledNet) -> Subject:
    return subject_of(to_model(net, "net"))


def certify(net: CompiledNet, kind: str, text: str) -> dict[str, Any] | None:
    """Return the certificate of a proof: whatever is proved has one."""
    asked = Asked(subject(net), kind, text)
    answer = proved(asked)
    if answer is None:
        return None
    found = certificate_of(asked, answer.status, answer.evidence)
    assert found is not None
    return found


def claimed(asked: Asked, evidence: Inductive, clauses: list[list[Row]]) -> dict[str, Any] | None:
    """Return a certificate with clauses that are only claimed; None if it is refused."""
    facts = certificate_of(replace(asked, text="false"), "unreachable", evidence)
    assert facts is not None
    places = asked.subject.net.places
    rows = [
        [{"sum": {places[p]: k for p, k in terms.items() if k}, "least": least} for terms, least in clause]
        for clause in clauses
    ]
    steps = max(evidence.depth, min(1, len(rows)))
    made = asked.certificate(FORMAT, "unreachable", never=facts["never"], clauses=rows, steps=steps)
    return None if refutation(made, asked.subject) else made


def reachable(net: CompiledNet) -> list[tuple[int, ...]]:
    """Return reachable markings, by plain search: all, or the first of many."""
    found = {tuple(net.initial.tolist())}
    todo = list(found)
    for marking in todo:
        for t in range(len(net.transitions)):
            if net.is_enabled(t, marking):
                after = tuple(net.fire(t, marking))
                if after not in found and len(found) < MOST:
                    found.add(after)
                    todo.append(after)
    return todo


def is_true(certificate: dict[str, Any], net: CompiledNet) -> bool:
    """Whether no marking of a plain search does what is excluded, by definition."""
    asked = certificate["question"]
    goal = excluded(asked["kind"], asked["text"], certificate["answer"])
    atoms = BoundAtoms(net, goal, subject(net).names)
    steps = (
        Step(marking, t)
        for marking in reachable(net)
        for t in [*(t for t in range(len(net.transitions)) if net.is_enabled(t, marking)), None]
    )
    return not any(holds_on_lasso(goal, [], [step], atoms.is_true) for step in steps)


def holds(row: dict[str, Any], marking: dict[str, int]) -> bool:
    return bool(sum(k * marking[p] for p, k in row["sum"].items()) >= row["least"])


def facts_hold(certificate: dict[str, Any], net: CompiledNet) -> bool:
    """Whether what is never so, and clauses, are true of all markings of a plain search."""
    markings = [dict(zip(net.places, marking, strict=True)) for marking in reachable(net)]
    return all(
        not any(all(holds(row, m) for row in fact["rows"]) for fact in certificate["never"])
        and all(any(holds(row, m) for row in clause) for clause in certificate["clauses"])
        for m in markings
    )


INVARIANT = CompiledNet.build(
    {"idle": 2, "busy": 0, "log": 0},
    [("start", {"idle": 1}, {"busy": 1}), ("stop", {"busy": 1}, {"idle": 1, "log": 1})],
)

# Marked forever by turns, though the state equation lets both run empty (Esparza and Melzer, 2000, Fig. 1).
TRAP = CompiledNet.build(
    {"a": 1, "b": 0, "c": 0},
    [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1, "a": 1}, {"a": 1}), ("v", {"b": 2}, {"a": 1})],
)

# The inhibitor arc keeps b from a second token; no weighting knows of it.
INDUCTIVE = CompiledNet.build(
    {"a": 5, "b": 0},
    [("t", {"a": 1}, {"b": 1}, {"b": 1}), ("u", {"b": 1}, {"a": 1})],
)

# A second token of c needs two firings in a row that the marking between them forbids.
STEPS = CompiledNet.build(
    {"a": 1, "b": 0, "c": 0, "free": 1},
    [
        ("t", {"a": 1}, {"b": 1}),
        ("u", {"b": 1}, {"a": 1}),
        ("v", {"b": 2}, {"c": 1}),
    ],
)

# An inhibitor arc stops what no weighting bounds.
UNBOUNDED = CompiledNet.build({"n": 0, "m": 0}, [("up", {}, {"n": 1}, {"n": 3})])

EXAMPLES = {
    "weighting": (INVARIANT, "ctl", "AG (idle + busy == 2)", "never"),
    "weightings": (INVARIANT, "marking", "busy >= 3 | idle >= 3 & log >= 1", "never"),
    "trap": (TRAP, "marking", "a + b == 0", "clauses"),
    "induction": (INDUCTIVE, "ltl", "G b <= 1", "steps"),
    "enabled": (STEPS, "enabled", "v", "never"),
    "fired": (STEPS, "ltl", "G !fired(v)", "never"),
    "several": (TRAP, "ctl", "!EF (a + b == 0) & AG (a + b <= 1)", "clauses"),
    "unbounded": (UNBOUNDED, "marking", "n >= 4", "steps"),
}


@pytest.mark.parametrize("name", EXAMPLES)
def test_each_kind_of_proof_is_found_and_accepted(name: str, tmp_path: Path) -> None:
    net, kind, text, part = EXAMPLES[name]
    found = certify(net, kind, text)
    assert found is not None and found[part]
    write_certificate(found, tmp_path / "one.json")
    assert read_certificate(tmp_path / "one.json") == found
    assert difference(found, subject(net)) == ""
    assert is_true(found, net) and facts_hold(found, net)


def test_deadlock_is_excluded_by_traps_and_invariants() -> None:
    assert certify(round_robin_mutex(4), "ctl", "AG !deadlock") is not None


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        ("ctl", "AG (busy <= 1)"),  # false
        ("ctl", "AG EF (idle == 2)"),  # no question of markings alone
        ("ctl", "idle >= 2"),
        ("ltl", "F busy >= 3"),  # violated, but by a run
        ("ltl", "G !fired(start)"),
        ("ltl", "G (fired(start) -> busy >= 1)"),
        ("enabled", "start"),
        ("marking", "busy >= 2"),
    ],
)
def test_what_cannot_be_certified_is_not(kind: str, text: str) -> None:
    assert certify(INVARIANT, kind, text) is None


def test_steps_of_an_induction_are_all_looked_at() -> None:
    """A counter that an inhibitor arc stops at 3: fewer than two is not invariant, however many steps."""
    asked = Asked(subject(UNBOUNDED), "marking", "n >= 2")
    assert all(certificate_of(asked, "unreachable", Inductive(depth, ())) is None for depth in range(6))


def test_two_steps_prove_what_one_does_not() -> None:
    """The fault needs what can only be there right after a fault: a run of two steps shows that."""
    net = CompiledNet.build(
        {"ok": 1, "odd": 0, "bad": 0},
        # `bad` comes from `odd`; `odd` comes, and goes, only with `bad`.
        [("fail", {"odd": 1, "ok": 1}, {"bad": 1, "ok": 1}), ("turn", {"bad": 1}, {"odd": 1, "bad": 1})],
    )
    asked = Asked(subject(net), "marking", "bad >= 1")
    assert certificate_of(asked, "unreachable", Inductive(1, ())) is None
    # From `odd` alone the first step leads to `bad`, so two steps never come from there.
    assert certificate_of(asked, "unreachable", Inductive(2, ())) is not None


def changes(value: Any) -> Iterator[Any]:
    """Yield a value of JSON with one thing in it changed: a number, a text, a part left out."""
    if isinstance(value, int):
        yield from (value + 1, value - 1, -value, 0, value + 0.5)
    elif isinstance(value, dict):
        for key, part in value.items():
            yield from ({**value, key: changed} for changed in changes(part))
            yield {other: part for other, part in value.items() if other != key}
    elif isinstance(value, list):
        for number, part in enumerate(value):
            yield from ([*value[:number], changed, *value[number + 1 :]] for changed in changes(part))
            yield [*value[:number], *value[number + 1 :]]


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_changed_certificate_is_refused(name: str, tmp_path: Path) -> None:
    net, kind, text, _ = EXAMPLES[name]
    found, about = certify(net, kind, text), subject(net)
    assert found is not None
    tried = refused = 0
    for key in ("never", "clauses", "steps"):
        for changed in changes(found[key]):
            if changed == found[key]:
                continue
            tried += 1
            broken = {**found, key: changed}
            assert difference(broken, about) == "it was changed after it was written"
            # Who seals it again gets only through what is true.
            path = tmp_path / "changed.json"
            write_certificate(sealed(broken), path)
            try:
                verdict = refutation(read_certificate(path), about)
            except CertificateFileError as error:
                verdict = str(error)
            refused += bool(verdict)
            assert verdict or facts_hold(broken, net)
    assert tried > 3 and refused > tried / 3


@pytest.mark.parametrize("name", EXAMPLES)
def test_another_net_or_question_is_refused(name: str) -> None:
    net, kind, text, _ = EXAMPLES[name]
    found = certify(net, kind, text)
    assert found is not None
    more = subject(net.with_initial({net.places[0]: int(net.initial[0]) + 1}))
    assert difference(found, more) == "it belongs to another net"
    other = copy.deepcopy(found)
    other["question"] = {"kind": "marking", "text": f"{net.places[0]} >= 0"}
    assert "not excluded" in refutation({**other, "answer": "unreachable"}, subject(net))
    with pytest.raises(DinerosError):
        refutation({**found, "answer": "maybe"}, subject(net))


@st.composite
def goals(draw: st.DrawFn, places: tuple[str, ...]) -> str:
    """A condition on markings, as text."""
    parts = []
    for _ in range(draw(st.integers(1, 3))):
        terms = draw(st.dictionaries(st.sampled_from(places), st.integers(-1, 2), min_size=1, max_size=3))
        total = " ".join(f"{'+' if k > 0 else '-'} {abs(k)}*{p}" for p, k in terms.items() if k)
        total = total.removeprefix("+ ") if total.startswith("+") else f"{places[0]} {total}"
        parts.append(f"{total} {draw(st.sampled_from(['>=', '<=', '==', '!=']))} {draw(st.integers(0, 6))}")
    return draw(st.sampled_from([" & ", " | "])).join(parts)


@settings(max_examples=20, deadline=None)
@given(st.data())
def test_what_is_proved_is_true_and_certified(data: st.DataObject) -> None:
    net = data.draw(nets())
    goal = data.draw(st.one_of(goals(net.places), st.just("deadlock")))
    if data.draw(st.booleans()):
        goal = f"({goal}) & {data.draw(st.sampled_from(['', '!']))}fired({net.transitions[0]})"
        found = certify(net, "ltl", f"G !({goal})")
    else:
        found = certify(net, "marking", goal)
    if found is not None:
        assert is_true(found, net) and facts_hold(found, net)


@settings(max_examples=30, deadline=None)
@given(st.data())
def test_whatever_is_claimed_only_what_is_true_is_accepted(data: st.DataObject) -> None:
    net = data.draw(nets())
    known = sums_of(net) if data.draw(st.booleans()) else None
    rows = st.tuples(
        st.dictionaries(st.sampled_from(range(len(net.places))), st.integers(-2, 2), min_size=1, max_size=2),
        st.integers(-3, 3),
    )
    clauses: list[list[Row]] = data.draw(st.lists(st.lists(rows, min_size=1, max_size=2), max_size=2))
    some = ((), (), ()) if known is None else (known.bounds, known.proofs, known.weightings)
    evidence = Inductive(data.draw(st.integers(0, 3)), *some)
    asked = Asked(subject(net), "marking", data.draw(goals(net.places)))
    found = claimed(asked, evidence, clauses)
    if found is not None:
        assert is_true(found, net)
        # Without a step the clauses are not used.
        assert not found["steps"] or facts_hold(found, net)


@settings(max_examples=30, deadline=None)
@given(
    st.lists(
        st.lists(
            st.tuples(st.dictionaries(st.integers(0, 2), st.integers(-3, 3), max_size=3), st.integers(-8, 8)),
            min_size=1,
            max_size=3,
        ),
        max_size=6,
    )
)
def test_what_the_solver_is_told_is_what_trying_all_finds(
    clauses: list[list[tuple[dict[int, int], int]]],
) -> None:
    most = 6
    net = CompiledNet.build({"a": 1, "b": 2, "c": 3}, [])
    rows = [
        [(tuple(sorted((p, k) for p, k in terms.items() if k)), least) for terms, least in c] for c in clauses
    ]
    bounds = [[(((p, -1),), -most)] for p in range(3)]
    found = _Markings(subject(net), TRUE, [*bounds, *rows], False).lead_to_it(0, [])
    assert found == any(
        all(any(sum(k * tokens[p] for p, k in terms) >= least for terms, least in clause) for clause in rows)
        for tokens in itertools.product(range(most + 1), repeat=3)
    )


def test_who_checks_is_one_small_module_that_imports_no_engine() -> None:
    """All that it imports of ours, with all that these import, reads models and formulas."""
    seen: set[str] = set()
    todo = ["analysis.evidence.checker"]
    while todo:
        name = todo.pop()
        file = ROOT / (name.replace(".", "/") + ".py")
        if name in seen or not file.exists():
            continue
        seen.add(name)
        for node in ast.walk(ast.parse(file.read_bytes())):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("dineros."):
                module = str(node.module).removeprefix("dineros.")
                todo += [module, *(f"{module}.{alias.name}" for alias in node.names)]
    own = {name for name in seen if name.startswith("analysis.")}
    others = {name for name in own if not name.startswith(("analysis.logic.language.", "analysis.model."))}
    assert others == {"analysis.evidence.checker", "analysis.nets.compiled", "analysis.nets.models"}
    assert len((ROOT / "analysis/evidence/checker.py").read_text().splitlines()) < 300
