"""Property files: what is read, what is refused, and what is written is read back."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.portfolio.branching_time import check_ctl
from dineros.analysis.properties.property import GroupedNames, Property
from dineros.analysis.properties.reading import read_properties
from dineros.analysis.properties.writing import write_properties
from dineros.metamodel.errors import DinerosError
from tests.analysis.logic.generated import atoms_of, random_ctl, random_net

NET = CompiledNet.build({"a": 1, "b": 0, "c": 0}, [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1}, {"c": 1})])
FILE = '<property-set xmlns="http://mcc.lip6.fr/">{}</property-set>'
ONE = "<property><id>{}</id><description/><formula>{}</formula></property>"
FIREABLE = "<is-fireable><transition>t</transition></is-fireable>"

ONE_TOKEN = "<integer-constant>1</integer-constant>"
TWO = "<integer-constant>2</integer-constant>"


def read(tmp_path: Path, formula: str, id: str = "n-CTLFireability-00") -> Property:
    path = tmp_path / "questions.xml"
    path.write_text(FILE.format(ONE.format(id, formula)))
    (found,) = read_properties(path, GroupedNames(NetNames(NET)))
    return found


def count(*places: str) -> str:
    return f"<tokens-count>{''.join(f'<place>{place}</place>' for place in places)}</tokens-count>"


@pytest.mark.parametrize(
    ("formula", "text"),
    [
        (
            f"<integer-le><integer-constant>2</integer-constant>{count('a', 'b')}</integer-le>",
            "-a - b <= -2",
        ),
        (f"<integer-le>{count('a')}{count('b', 'a')}</integer-le>", "-b <= 0"),
        (f"<integer-le>{count('a')}{count('a')}</integer-le>", "true"),
        (f"<integer-ge>{count('a')}{ONE_TOKEN}</integer-ge>", "a >= 1"),
        (f"<integer-gt>{count('a')}{ONE_TOKEN}</integer-gt>", "a > 1"),
        (f"<integer-lt>{count('a')}{ONE_TOKEN}</integer-lt>", "a < 1"),
        (f"<integer-eq>{count('a')}{ONE_TOKEN}</integer-eq>", "a == 1"),
        (f"<integer-ne>{count('a')}{ONE_TOKEN}</integer-ne>", "a != 1"),
        (f"<integer-ge>{ONE_TOKEN}{count('a')}</integer-ge>", "-a >= -1"),
        (f"<integer-ne>{ONE_TOKEN}{ONE_TOKEN}</integer-ne>", "false"),
        (f"<integer-gt>{count('a')}{count('a')}</integer-gt>", "false"),
        (
            f"<integer-ge><integer-sum>{count('a')}{count('b', 'a')}{ONE_TOKEN}</integer-sum>"
            f"<integer-difference>{count('c')}{ONE_TOKEN}</integer-difference></integer-ge>",
            "2*a + b - c >= -2",
        ),
        (
            f"<integer-le><integer-product>{TWO}<integer-sum>{count('a')}{ONE_TOKEN}</integer-sum></integer-product>"
            f"<integer-product>{TWO}{TWO}</integer-product></integer-le>",
            "2*a <= 2",
        ),
        (
            "<exclusive-disjunction><true/><false/></exclusive-disjunction>",
            "!(true <-> false)",
        ),
        (f"<and>{FIREABLE}<not><true/></not></and>", "enabled(t) & !true"),
        (f"<exists-path><next>{FIREABLE}</next></exists-path>", "EX enabled(t) & !deadlock"),
        (f"<all-paths><next>{FIREABLE}</next></all-paths>", "AX enabled(t) | deadlock"),
        (
            f"<exists-path><until><before>{FIREABLE}</before><reach><deadlock/></reach></until></exists-path>",
            "E[enabled(t) U deadlock]",
        ),
        (f"<implication>{FIREABLE}<true/></implication>", "enabled(t) -> true"),
    ],
)
def test_formulas_of_branching_time(tmp_path: Path, formula: str, text: str) -> None:
    found = read(tmp_path, formula)
    assert (found.kind, str(found.formula)) == ("ctl", text)


@pytest.mark.parametrize("id", ["n-LTLFireability-00", "n-00"])
def test_a_formula_of_linear_time_is_known_by_its_operators(tmp_path: Path, id: str) -> None:
    found = read(tmp_path, f"<all-paths><globally><finally>{FIREABLE}</finally></globally></all-paths>", id)
    assert (found.kind, str(found.formula)) == ("ltl", "G F enabled(t)")


def test_next_of_linear_time_goes_on_at_a_deadlock(tmp_path: Path) -> None:
    found = read(tmp_path, f"<all-paths><next>{FIREABLE}</next></all-paths>", "n-LTLFireability-00")
    assert (found.kind, str(found.formula)) == ("ltl", "X enabled(t)")


def test_several_transitions_are_any_of_them(tmp_path: Path) -> None:
    path = tmp_path / "questions.xml"
    either = "<is-fireable><transition>t</transition><transition>u</transition></is-fireable>"
    path.write_text(FILE.format(ONE.format("x", either)))
    names = GroupedNames(NetNames(NET))
    (found,) = read_properties(path, names)
    assert found.formula is not None
    assert names.transitions("t or u") == [0, 1]
    assert check_ctl(NET, found.formula, names).status == "holds"


def test_bounds_and_global_questions(tmp_path: Path) -> None:
    assert read(tmp_path, f"<place-bound>{'<place>a</place><place>b</place>'}</place-bound>").places == (
        "a",
        "b",
    )
    assert read(tmp_path, "<true/>", "net-Liveness").examination == "Liveness"
    assert read(tmp_path, "<true/>", "Liveness").examination == "Liveness"
    assert read(tmp_path, "", "Liveness").examination == "Liveness"
    assert read(tmp_path, FIREABLE, "RobotLiveness").kind == "ctl"
    assert read(tmp_path, FIREABLE, "Robot-Liveness").kind == "ctl"


@pytest.mark.parametrize(
    ("formula", "said"),
    [
        ("<is-fireable><transition>v</transition></is-fireable>", "no transition is named 'v'"),
        ("<is-fireable><place>a</place></is-fireable>", "<place> is not a <transition>"),
        (f"<globally>{FIREABLE}</globally><true/>", "<formula> holds 2 elements"),
        ("<exists-path><true/></exists-path>", "needs a temporal operator, not <true>"),
        ("<negations><true/></negations>", "<negations> is not part of a formula"),
        (
            f"<integer-le>{count('a')}<integer-constant>1e9</integer-constant></integer-le>",
            "not a whole number",
        ),
        ("<all-paths><until><before><true/></before></until></all-paths>", "<until> holds 1 elements"),
        (f"<integer-lee>{count('a')}{ONE_TOKEN}</integer-lee>", "did you mean 'integer-le'"),
        (
            f"<integer-le><integer-product>{count('a')}{count('b')}</integer-product>{TWO}</integer-le>",
            "is not linear",
        ),
        (f"<integer-ge>{count('a')}</integer-ge>", "holds 1 elements"),
        (
            f'<all-paths><globally upper="5">{FIREABLE}</globally></all-paths>',
            "<globally> has an unknown attribute 'upper'",
        ),
        (f"<conjunction>not {FIREABLE}</conjunction>", "<conjunction> holds the text 'not'"),
        (
            f"<integer-ge><tokens-count><place>a</place> * 2</tokens-count>{ONE_TOKEN}</integer-ge>",
            "<tokens-count> holds the text '* 2'",
        ),
        (
            f"<integer-ge>{count('a')}<integer-constant>1<x/>0</integer-constant></integer-ge>",
            "<integer-constant> holds 1 elements",
        ),
        (f"<integer-ge><integer-sum/>{ONE_TOKEN}</integer-ge>", "holds 0 elements"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(tmp_path: Path, formula: str, said: str) -> None:
    with pytest.raises(DinerosError, match=r"questions\.xml:1: ") as caught:
        read(tmp_path, formula)
    assert said in str(caught.value)


@pytest.mark.parametrize("part", ["id", "formula"])
def test_of_two_ids_or_formulas_none_is_dropped(tmp_path: Path, part: str) -> None:
    path = tmp_path / "questions.xml"
    inside = {"id": "x", "formula": "<true/>"}
    second = f"<true/></formula>\n<{part}>{inside[part]}</{part}><formula>"
    path.write_text(FILE.format(ONE.format("x", second)))
    with pytest.raises(DinerosError) as caught:
        read_properties(path, GroupedNames(NetNames(NET)))
    assert f"has two <{part}>, on lines 1 and 2" in str(caught.value)


@pytest.mark.parametrize(
    ("space", "said"),
    [("", "no namespace"), (' xmlns="http://tapaal.net/"', "the namespace 'http://tapaal.net/'")],
)
def test_other_namespaces_are_read_with_a_note(tmp_path: Path, space: str, said: str) -> None:
    path = tmp_path / "questions.xml"
    path.write_text(f"<property-set{space}>{ONE.format('q', FIREABLE)}</property-set>")
    notes: list[str] = []
    (found,) = read_properties(path, GroupedNames(NetNames(NET)), notes.append)
    assert str(found.formula) == "enabled(t)"
    assert len(notes) == 1 and said in notes[0]


def test_other_files_are_refused(tmp_path: Path) -> None:
    for text, said in (("<pnml/>", "is not a property file"), ("<!DOCTYPE a><a/>", "document type")):
        (tmp_path / "other.xml").write_text(text)
        with pytest.raises(DinerosError, match=said):
            read_properties(tmp_path / "other.xml", GroupedNames(NetNames(NET)))
    twice = ONE.format("x", "<true/>") * 2
    (tmp_path / "twice.xml").write_text(FILE.format(twice))
    with pytest.raises(DinerosError, match="two properties 'x'"):
        read_properties(tmp_path / "twice.xml", GroupedNames(NetNames(NET)))


@pytest.mark.parametrize("seed", range(30))
def test_what_is_written_means_the_same(tmp_path: Path, seed: int) -> None:
    rng = random.Random(seed)
    net = random_net(rng)
    atoms = [atom for atom in atoms_of(rng, net, with_fired=False) if " + " not in str(atom)]
    formula = random_ctl(rng, rng.randrange(2, 9), atoms)
    try:
        write_properties(tmp_path / "w.xml", [Property("x", "ctl", formula)], net, NetNames(net))
    except DinerosError as error:
        assert "cannot be expressed" in str(error)
        return
    names = GroupedNames(NetNames(net))
    (again,) = read_properties(tmp_path / "w.xml", names)
    assert again.formula is not None
    few = Budget(states=2_000)
    one, other = (
        check_ctl(net, tree, names, few, engine="explicit").status for tree in (formula, again.formula)
    )
    assert one == other or "unknown" in (one, other)


def test_linear_time_is_written_without_operators_that_are_not_known(tmp_path: Path) -> None:
    formula = parse("(a >= 1 W b >= 1) & (c < 2 R a == 1)")
    write_properties(tmp_path / "w.xml", [Property("LTL", "ltl", formula)], NET, NetNames(NET))
    (again,) = read_properties(tmp_path / "w.xml", GroupedNames(NetNames(NET)))
    assert again.kind == "ltl" and " U " in str(again.formula)


@pytest.mark.parametrize("formula", ["F fired(t)", "G (a + b - c <= 1)"])
def test_what_cannot_be_written_is_refused(tmp_path: Path, formula: str) -> None:
    with pytest.raises(DinerosError, match="cannot be expressed in a property file"):
        write_properties(tmp_path / "w.xml", [Property("x", "ltl", parse(formula))], NET, NetNames(NET))
    assert not (tmp_path / "w.xml").exists()
