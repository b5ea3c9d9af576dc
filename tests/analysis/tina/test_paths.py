"""Firing sequences read back: their form, and that nothing is shown which the net cannot fire."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.tina.formulas import quoted
from dineros.analysis.tina.paths import lasso, read_sequence, to_goal
from dineros.analysis.tina.programs import TinaError

RING = CompiledNet.build(
    {"a": 1, "b": 0, "c": 0},
    [
        ("go", {"a": 1}, {"b": 1}),
        ("back", {"b": 1}, {"a": 1}),
        ("end", {"b": 1}, {"c": 1}),
        ("wait", {"a": 1}, {"a": 1}),
    ],
)


@given(st.data())
def test_what_is_written_is_read(data: st.DataObject) -> None:
    names = data.draw(
        st.lists(
            st.text(st.characters(blacklist_categories=["Cs", "Cc"]), min_size=1), min_size=1, unique=True
        )
    )
    net = CompiledNet.build({}, [(name,) for name in names])
    steps = st.lists(st.integers(0, len(names) - 1), min_size=1)
    rows = data.draw(st.lists(steps))
    text = "\n# a comment\n".join(" ".join(quoted(names[t]) for t in row) for row in rows)
    assert read_sequence(net, text, "selt") == rows


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("go@3", "a path that cannot be read: 'go@3'"),
        ("go{back}", "a path that cannot be read: 'go"),
        ("go {back", "a path that cannot be read: '{back'"),
        ("state 0: a", "a path with 'state', which is not a transition"),
        ("go L.deadlock", "a path that cannot be read: 'L.deadlock'"),
        ("go gone", "a path with 'gone', which is not a transition"),
    ],
)
def test_what_cannot_be_read_is_refused(text: str, says: str) -> None:
    with pytest.raises(TinaError, match="selt wrote " + says.replace(".", r"\.")) as error:
        read_sequence(RING, text, "selt")
    assert error.value.hint


class TestToGoal:
    def test_it_ends_at_the_goal(self) -> None:
        trace = to_goal(RING, [0, 1, 3, 0, 2], lambda marking: marking[1] > 0, "selt")
        assert trace == (0,)

    def test_what_the_net_cannot_fire_is_refused(self) -> None:
        with pytest.raises(
            TinaError, match="is not a firing sequence of the net: step 1: transition 'go' is not enabled"
        ):
            to_goal(RING, [0, 0], lambda marking: True, "pathto")

    def test_what_leads_elsewhere_is_refused(self) -> None:
        with pytest.raises(TinaError, match="does not reach the goal"):
            to_goal(RING, [0, 1], lambda marking: marking[2] > 0, "pathto")


class TestLasso:
    def read(self, rows: list[list[int]], text: str, weak: tuple[int, ...] = ()) -> object:
        formula = parse(text, "ltl")
        return lasso(RING, rows, formula, BoundAtoms(RING, formula, NetNames(RING)), weak)

    def test_the_last_line_repeats(self) -> None:
        assert self.read([[0, 1], [3]], "F c >= 1") == ((0, 1), (3,))

    def test_lines_need_not_tell(self) -> None:
        assert self.read([[0, 1, 3, 3]], "G F b >= 1") == ((0, 1, 3), (3,))

    def test_what_repeats_must_violate(self) -> None:
        """Waiting forever is not fair, going round is."""
        assert self.read([[3, 3]], "F b >= 1") == ((), (3, 3))
        assert self.read([[0, 1], [0, 1]], "G F fired(wait)", (0,)) == ((0, 1), (0, 1))
        with pytest.raises(TinaError, match="does not violate the formula"):
            self.read([[3, 3]], "F b >= 1", (0,))

    def test_a_run_that_ends(self) -> None:
        assert self.read([[0], [2]], "G !deadlock") == ((0, 2), ())

    @pytest.mark.parametrize("rows", [[[0]], [[]], []])
    def test_what_neither_returns_nor_ends_is_refused(self, rows: list[list[int]]) -> None:
        with pytest.raises(TinaError, match="does not violate the formula"):
            self.read(rows, "F c >= 1")

    def test_what_the_net_cannot_fire_is_refused(self) -> None:
        with pytest.raises(TinaError, match="the counterexample of selt is not a run of the net: step 0"):
            self.read([[1]], "F c >= 1")
