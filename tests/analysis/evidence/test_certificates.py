"""Certificates prove what they say: whatever is accepted is true, and what was changed is refused."""

from __future__ import annotations

import ast
import copy
import itertools
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.evidence.checker import CertificateFileError, read_certificate, refutation, sealed
from dineros.analysis.evidence.deciding import Decider
from dineros.analysis.evidence.proving import Asked, certificate_of, certify
from dineros.analysis.evidence.reading import Condition, Net, excluded, negated
from dineros.analysis.model.subject import Subject, subject_of
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.models import to_model
from dineros.metamodel.errors import DinerosError
from tests.analysis.classic_nets import round_robin_mutex
from tests.analysis.strategies import nets

ROOT = Path(__file__).resolve().parents[3]
MOST = 3_000


def subject(net: CompiledNet) -> Subject:
    return subject_of(to_model(net, "net"))


def holds(condition: Condition, marking: dict[str, int]) -> bool:
    """Evaluate a condition by its definition."""
    if "sum" in condition:
        return bool(sum(k * marking[p] for p, k in condition["sum"].items()) >= condition["least"])
    ((key, parts),) = condition.items()
    return (all if key == "all" else any)(holds(part, marking) for part in parts)


def reachable(net: CompiledNet) -> list[dict[str, int]]:
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
    return [dict(zip(net.places, marking, strict=True)) for marking in found]


def is_true(certificate: dict[str, Any], net: CompiledNet) -> bool:
    """Whether no marking of a plain search does what is excluded."""
    asked = certificate["question"]
    read = Net.of(to_model(net, "net"), "none", "weighted")
    goal = excluded(read, asked["kind"], asked["text"], certificate["answer"])
    return not any(holds(goal, marking) for marking in reachable(net))


INVARIANT = CompiledNet.build(
    {"idle": 2, "busy": 0, "log": 0},
    [("start", {"idle": 1}, {"busy": 1}), ("stop", {"busy": 1}, {"idle": 1, "log": 1})],
)

# Marked for ever by turns, though the state equation lets both run empty (Esparza and Melzer, 2000, Fig. 1).
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

EXAMPLES = {
    "weighting": (INVARIANT, "ctl", "AG (idle + busy == 2)", "weights"),
    "weightings": (INVARIANT, "marking", "busy >= 3 | idle >= 3 & log >= 1", "weights"),
    "trap": (TRAP, "marking", "a + b == 0", "trap"),
    "induction": (INDUCTIVE, "ltl", "G b <= 1", "clauses"),
    "enabled": (STEPS, "enabled", "v", "weights"),
}


@pytest.mark.parametrize("name", EXAMPLES)
def test_each_kind_of_fact_is_found_and_accepted(name: str) -> None:
    net, kind, text, fact = EXAMPLES[name]
    found = certify(Asked(subject(net), kind, text))
    assert found is not None
    assert any(fact in one for one in found["facts"])
    assert refutation(found, to_model(net, "net")) == ""
    assert is_true(found, net)


def test_deadlock_is_excluded_by_traps_and_invariants() -> None:
    net = round_robin_mutex(4)
    found = certify(Asked(subject(net), "ctl", "AG !deadlock"))
    assert found is not None
    assert refutation(found, to_model(net, "net")) == ""


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        ("ctl", "AG (busy <= 1)"),  # false
        ("ctl", "AG EF (idle == 2)"),  # no question of markings alone
        ("ctl", "idle >= 2"),
        ("ltl", "F busy >= 3"),  # violated, but by a run
        ("enabled", "start"),
        ("marking", "busy >= 2"),
    ],
)
def test_what_cannot_be_certified_is_not(kind: str, text: str) -> None:
    assert certify(Asked(subject(INVARIANT), kind, text)) is None


def test_induction_over_several_steps() -> None:
    """Of markings with both x and y, none can be entered; two steps before one there must be both, too."""
    net = CompiledNet.build(
        {"s0": 1, "s1": 0, "s2": 0, "s3": 0},
        [("t", {"s0": 1}, {"s0": 1}), ("x", {"s1": 1}, {"s2": 1}), ("y", {"s2": 1}, {"s3": 1})],
    )
    read = Net.of(to_model(net, "net"), "none", "weighted")
    goal = excluded(read, "marking", "s3 >= 1", "unreachable")
    asked = Asked(subject(net), "marking", "s3 >= 1")
    clauses = [[{"sum": {"s3": -1}, "least": 0}], [{"sum": {"s2": -1}, "least": 0}]]
    # s3 <= 0 alone is not inductive: from s2 it ends. With s2 <= 0 it still ends from s1, over one step.
    for steps, one in ((1, clauses[:1]), (1, clauses)):
        assert certificate_of(asked, read, goal, "unreachable", [{"clauses": one, "steps": steps}]) is None
    # Nothing puts tokens on s1, but a run of three steps may begin with some: 3 steps do not suffice either.
    loop = [("t", {"s0": 1}, {"s1": 1}), ("u", {"s1": 1}, {"s0": 1}), ("v", {"s2": 1}, {"s3": 1})]
    turns = CompiledNet.build({"s0": 1, "s1": 0, "s2": 0, "s3": 0}, [*loop, ("w", {"s1": 2}, {"s2": 1})])
    assert certify(Asked(subject(turns), "marking", "s3 >= 1")) is not None


def test_steps_of_an_induction_are_all_looked_at() -> None:
    """A counter that an inhibitor arc stops at 3: fewer than two is no invariant, over however many steps."""
    net = CompiledNet.build({"n": 0, "m": 0}, [("up", {}, {"n": 1}, {"n": 3})])
    asked, read = Asked(subject(net), "marking", "n >= 2"), Net.of(to_model(net, "net"), "none", "weighted")
    goal = excluded(read, "marking", "n >= 2", "unreachable")
    for steps in range(1, 6):
        fact = {"clauses": [[{"sum": {"n": -1}, "least": -1}]], "steps": steps}
        assert certificate_of(asked, read, goal, "unreachable", [fact]) is None
    four = Asked(subject(net), "marking", "n >= 4")
    found = certify(four)
    assert found is not None and refutation(found, to_model(net, "net")) == ""


def test_two_steps_prove_what_one_does_not() -> None:
    """The fault needs what can only be there right after a fault: a run of two steps shows that."""
    net = CompiledNet.build(
        {"ok": 1, "odd": 0, "bad": 0},
        # `bad` comes from `odd`; `odd` comes, and goes, only with `bad`.
        [("fail", {"odd": 1, "ok": 1}, {"bad": 1, "ok": 1}), ("turn", {"bad": 1}, {"odd": 1, "bad": 1})],
    )
    read, asked = (
        Net.of(to_model(net, "net"), "none", "weighted"),
        Asked(subject(net), "marking", "bad >= 1"),
    )
    goal = excluded(read, "marking", "bad >= 1", "unreachable")
    fact = {"clauses": [[{"sum": {"bad": -1}, "least": 0}]]}
    assert certificate_of(asked, read, goal, "unreachable", [{**fact, "steps": 1}]) is None
    # From `odd` alone the first step leads to `bad`, so two steps never come from there.
    assert certificate_of(asked, read, goal, "unreachable", [{**fact, "steps": 2}]) is not None


def changes(value: Any) -> Iterator[Any]:
    """Yield a value of JSON with one thing in it changed: a number, a text, a part left out."""
    if isinstance(value, bool):
        return
    if isinstance(value, int):
        yield from (value + 1, value - 1, -value, 0, value + 1000)
    elif isinstance(value, dict):
        for key, part in value.items():
            yield from ({**value, key: changed} for changed in changes(part))
            if key not in ("sum", "least", "weights", "trap", "clauses", "steps"):
                yield {other: part for other, part in value.items() if other != key}
    elif isinstance(value, list):
        for number, part in enumerate(value):
            yield from ([*value[:number], changed, *value[number + 1 :]] for changed in changes(part))
            yield [*value[:number], *value[number + 1 :]]


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_changed_certificate_is_refused(name: str, tmp_path: Path) -> None:
    net, kind, text, _ = EXAMPLES[name]
    model = to_model(net, "net")
    found = certify(Asked(subject(net), kind, text))
    assert found is not None
    tried = refused = 0
    for key in ("facts", "excluded"):
        for changed in changes(found[key]):
            if changed == found[key]:
                continue
            tried += 1
            broken = {**found, key: changed}
            assert refutation(broken, model) == "it was changed after it was written"
            # Who seals it anew does not get a wrong one through, nor another question's.
            path = tmp_path / "changed.json"
            path.write_text(json.dumps(sealed(broken)), encoding="utf-8")
            try:
                verdict = refutation(read_certificate(path), model)
            except CertificateFileError as error:
                verdict = str(error)
            refused += bool(verdict)
            assert verdict or (key == "facts" and all_true(changed, net))
    assert tried > 5 and refused > tried / 2


def all_true(facts: list[dict[str, Any]], net: CompiledNet) -> bool:
    """Whether facts are true of all markings of a plain search."""
    markings, first = reachable(net), dict(zip(net.places, net.initial.tolist(), strict=True))

    def total(weights: dict[str, int], marking: dict[str, int]) -> int:
        return sum(k * marking[p] for p, k in weights.items())

    return all(
        all(total(fact["weights"], m) <= total(fact["weights"], first) for m in markings)
        if "weights" in fact
        else all(any(m[p] for p in fact["trap"]) for m in markings)
        if "trap" in fact
        else all(any(holds(row, m) for row in clause) for m in markings for clause in fact["clauses"])
        for fact in facts
    )


@pytest.mark.parametrize("name", EXAMPLES)
def test_another_net_or_question_is_refused(name: str) -> None:
    net, kind, text, _ = EXAMPLES[name]
    found = certify(Asked(subject(net), kind, text))
    assert found is not None
    more = net.with_initial({net.places[0]: int(net.initial[0]) + 1})
    assert refutation(found, to_model(more, "net")) == "it is about another net"
    other = copy.deepcopy(found)
    other["question"]["text"] = f"({text}) | true" if kind == "marking" else "idle"
    if kind == "marking":
        wrong = "the question asks for something else than what is excluded"
        assert refutation(sealed(other), to_model(net, "net")) == wrong
    else:
        with pytest.raises(DinerosError):
            refutation(sealed({**other, "answer": "maybe"}), to_model(net, "net"))


@st.composite
def goals(draw: st.DrawFn, places: tuple[str, ...]) -> str:
    """A condition on markings, as text."""
    parts = []
    for _ in range(draw(st.integers(1, 3))):
        terms = draw(st.dictionaries(st.sampled_from(places), st.integers(1, 2), min_size=1, max_size=3))
        total = " + ".join(f"{k}*{p}" for p, k in terms.items())
        parts.append(f"{total} {draw(st.sampled_from(['>=', '<=', '==', '!=']))} {draw(st.integers(0, 6))}")
    return draw(st.sampled_from([" & ", " | "])).join(parts)


@settings(max_examples=120, deadline=None)
@given(st.data())
def test_what_is_certified_is_true(data: st.DataObject) -> None:
    net = data.draw(nets())
    text = data.draw(st.one_of(goals(net.places), st.just("deadlock")))
    found = certify(Asked(subject(net), "marking", text))
    if found is not None:
        assert is_true(found, net) and all_true(found["facts"], net)
        assert refutation(found, to_model(net, "net")) == ""


@settings(max_examples=120, deadline=None)
@given(st.data())
def test_induction_accepts_only_what_is_true(data: st.DataObject) -> None:
    net = data.draw(nets())
    text = data.draw(goals(net.places))
    read, model = Net.of(to_model(net, "net"), "none", "weighted"), to_model(net, "net")
    goal = excluded(read, "marking", text, "unreachable")
    rows = negated(goal)
    clauses = [[rows]] if "sum" in rows else None
    if clauses is None:
        ((key, parts),) = rows.items()
        if any("sum" not in part for part in parts):
            return
        clauses = [[part] for part in parts] if key == "all" else [parts]
    fact = {"clauses": clauses, "steps": data.draw(st.integers(1, 3))}
    found = certificate_of(Asked(subject(net), "marking", text), read, goal, "unreachable", [fact])
    if found is not None:
        assert is_true(found, net)
        assert refutation(found, model) == ""


@settings(max_examples=120, deadline=None)
@given(
    st.lists(
        st.lists(
            st.tuples(
                st.dictionaries(st.sampled_from("abc"), st.integers(-3, 3), max_size=3), st.integers(-8, 8)
            ),
            min_size=1,
            max_size=3,
        ),
        max_size=6,
    )
)
def test_what_is_decided_is_what_trying_all_finds(clauses: list[list[tuple[dict[str, int], int]]]) -> None:
    most = 6
    bounds: list[Condition] = [{"sum": {p: -1}, "least": -most} for p in "abc"]
    parts: list[Condition] = [
        {"any": [{"sum": weights, "least": least} for weights, least in clause]} for clause in clauses
    ]
    wanted: Condition = {"all": [*bounds, *parts]}
    decider = Decider()
    found = decider.marking([decider.encode(wanted)])
    tried = (dict(zip("abc", tokens, strict=True)) for tokens in itertools.product(range(most + 1), repeat=3))
    if found is None:
        assert not any(holds(wanted, marking) for marking in tried)
    else:
        assert holds(wanted, dict.fromkeys("abc", 0) | found)


MAY_IMPORT = ("metamodel", "transformations", "analysis.logic.language", "analysis.nets.linear_programs")


def test_who_checks_imports_no_engine() -> None:
    """The modules that check, and all that they import of ours, but for what packages offer by themselves."""
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
    own = {name for name in seen if name.startswith("analysis.evidence.")}
    assert own == {f"analysis.evidence.{name}" for name in ("checker", "deciding", "reading")}
    others = {name for name in seen - own if not name.startswith(MAY_IMPORT)}
    assert others <= {"analysis.logic.language.errors"}
    for name in own:
        assert len((ROOT / f"{name.replace('.', '/')}.py").read_text().splitlines()) < 300
