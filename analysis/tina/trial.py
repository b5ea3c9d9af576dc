"""A trial before each question: whether this TINA answers as its manual is read here.

What the manual leaves open decides answers: above all, what becomes of a run that ends in a deadlock, and of
one that ends where exploration stopped. So before programs of TINA are believed about a net, they are asked
about a small one whose only run is known. A run that ends must continue there forever without an event, as it
does for our own engines; names that need quotes, arcs of all kinds and all operators that are ever written
must mean what they mean here. Each fact is asked for together with its opposite: a program that leaves runs
out, and finds everything true of none, is found out.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.tina.digest import read_counts
from dineros.analysis.tina.formulas import PARTIAL, always, formula_text, not_
from dineros.analysis.tina.programs import TinaAnswerError, TinaError, Workplace, tool

#: Its one run fires ``t{1}`` and ``u``, and ends.
TRIAL = CompiledNet.build(
    {"a": 1, "b c": 0, "3": 2, "d": 0},
    [
        Transition("t{1}", {"a": 1}, {"b c": 2}, {"b c": 1}, {"3": 2}),
        Transition("u", {"b c": 2}, {"d": 1}),
        Transition("v", {"d": 2}, {"d": 2}),
    ],
)
#: The conditions at its three markings, and at the events between them, with all comparisons.
MOMENTS = """
fired("t{1}") & enabled("t{1}") & !fired(u) & !enabled(u) & !deadlock & !(enabled(v) | fired(v))
& a = 1 & "b c" = 0 & "3" > 1 & "3" != 3 & "b c" - 2*"3" <= -4
& (enabled(v) <-> false) & (enabled(v) -> a = 7) & (true U fired(u))
& X (fired(u) & enabled(u) & !deadlock & a < 1 & "b c" - "3" = 0 & 2*"b c" + "3" >= 6
& X G (deadlock & d = 1 & !(fired("t{1}") | fired(u) | fired(v))))
"""
#: Facts in our language, few temporal operators in each: automata of long formulas take long.
FACTS = (
    MOMENTS,
    '(a >= 1 U "b c" >= 2) & !(a >= 1 U d >= 1) & (fired("t{1}") W enabled(u))',
    "F G deadlock & (d >= 1 R (d = 0 | deadlock)) & (G F fired(v) -> d >= 5)",
)

_passed: set[tuple[object, ...]] = set()


def forget() -> None:
    """Try programs again that have passed."""
    _passed.clear()


def ask(place: Workplace, graph: str, text: str) -> bool:
    """Ask ``selt`` whether a formula, in its language, holds of a marking graph.

    Parameters
    ----------
    place : Workplace
        Where the graph is.

    Raises
    ------
    TinaError
        It failed, or did not answer with TRUE or FALSE.
    """
    # -q -b: the truth value, no banner, no times; -wp 0: nothing is waited for while something is enabled.
    output = place.run("selt", graph, "-f", text, "-q", "-b", "-wp", "0").stdout
    said = [line.strip() for line in output.splitlines() if line.strip() in ("TRUE", "FALSE")]
    if len(said) != 1:
        first = next((line.strip()[:80] for line in output.splitlines() if line.strip()), "nothing")
        raise TinaAnswerError(f"selt answers neither TRUE nor FALSE but {first!r}")
    return said[0] == "TRUE"


def try_temporal(place: Workplace) -> None:
    """Try ``tina`` and ``selt``.

    Raises
    ------
    TinaError
        They do not answer as expected.
    """
    key = _key("tina", "selt")
    if key in _passed:
        return
    place.save(TRIAL, "trial.net")
    counts = read_counts(TRIAL, place.run("tina", "-R", "trial.net", "trial.ktz"))
    if (counts.states, counts.arcs, counts.is_bounded) != (3, 2, True):
        raise _otherwise("tina", f"counts {counts.states} markings and {counts.arcs} arcs", "3 and 2")
    _expect_facts(place, FACTS)
    _passed.add(key)


def try_reachability(place: Workplace) -> None:
    """Try ``sift``, and ``selt`` on the graphs that it writes.

    Raises
    ------
    TinaError
        They do not answer as expected.
    """
    key = _key("sift", "selt")
    if key in _passed:
        return
    place.save(TRIAL, "trial.net")
    place.run("sift", "-R", "trial.net", "trial.ktz")
    _expect_facts(place, FACTS[:1])
    goal = _text('"b c" >= 2')
    place.run("sift", "-R", "trial.net", "stopped.ktz", "-f", not_(goal))
    _expect(place, "stopped.ktz", always(not_(goal)), False)
    _expect(place, "stopped.ktz", always(not_(PARTIAL)), False)
    _passed.add(key)


def _expect_facts(place: Workplace, facts: Sequence[str]) -> None:
    for fact in facts:
        text = _text(fact)
        _expect(place, "trial.ktz", text, True)
        _expect(place, "trial.ktz", not_(text), False)
    _expect(place, "trial.ktz", always(not_(PARTIAL)), True)


def _expect(place: Workplace, graph: str, text: str, expected: bool) -> None:
    if ask(place, graph, text) is not expected:
        answer = "FALSE" if expected else "TRUE"
        raise _otherwise("selt", f"answers {answer} to {_shortened(text)}", str(expected).upper())


def _otherwise(program: str, answer: str, expected: str) -> TinaError:
    return TinaError(
        f"tried on a net of three markings, {program} {answer}, where {expected} is right",
        hint="this version may differ from its manual; use another engine",
    )


def _text(formula: str) -> str:
    tree = parse(formula, "ltl")
    return formula_text(TRIAL, tree, BoundAtoms(TRIAL, tree, NetNames(TRIAL)))


def _shortened(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:57]}..."


def _key(*names: str) -> tuple[object, ...]:
    """Return which programs these are: a program that was replaced is tried again."""
    programs = [Path(tool(name)).resolve() for name in names]
    return tuple((str(program), program.stat().st_mtime_ns) for program in programs)
