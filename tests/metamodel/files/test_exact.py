"""Bounds keep their decimal or rational text from file to file."""

from __future__ import annotations

import copy
import pickle
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.metamodel import pn
from dineros.metamodel.build import flow, read
from dineros.metamodel.elements import find, transitions
from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files import load, save
from dineros.metamodel.files.exact import ExactNumber, exact_number, exact_text, fraction_of, nearest
from tests.support.equality import differences

fractions = st.fractions(min_value=0, max_value=10**9, max_denominator=10**6)
decimals = st.tuples(st.integers(0, 10**25), st.integers(0, 25)).map(
    lambda pair: Fraction(pair[0], 10 ** pair[1])
)


@given(st.one_of(fractions, decimals))
def test_a_number_survives_its_text(number: Fraction) -> None:
    made = nearest(number)
    assert fraction_of(made) == number
    assert fraction_of(exact_number(exact_text(number))) == number
    assert abs(float(made) - float(number)) == 0
    for again in (copy.deepcopy(made), pickle.loads(pickle.dumps(made))):
        assert (fraction_of(again), again == made) == (number, True)


@given(st.floats(0, 1e300, allow_subnormal=False))
def test_a_float_stands_for_its_shortest_text(number: float) -> None:
    assert type(exact_number(repr(number))) is float
    assert exact_number(repr(number)) == number


def test_numbers_that_only_differ_in_what_a_float_rounds_away_are_not_equal() -> None:
    tenth, more = exact_number("0.1"), exact_number("0.10000000000000000001")
    assert (type(tenth), type(more)) == (float, ExactNumber)
    assert float(tenth) == float(more)
    assert fraction_of(tenth) < fraction_of(more)
    assert exact_number("1/3") != exact_number("0.33333333333333333333")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        *((text, "takes a number") for text in ("", "x", "1/0", "1/", "/2", "1/3/5", "nan", "0x1", "1_0")),
        *((text, "range of a double") for text in ("1e999", "1e-999", "1e9999999999", "1e-9999999999")),
        ("9" * 401, "takes a number"),
    ],
)
def test_what_is_no_number(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        exact_number(text)


bounds = st.one_of(st.integers(0, 5).map(Fraction), st.fractions(0, 3, max_denominator=7), decimals)


@st.composite
def exact_intervals(draw: st.DrawFn) -> pn.TimeInterval:
    """Return an interval that is not empty, with decimal and rational bounds."""
    low = draw(bounds)
    interval = pn.TimeInterval(earliest=nearest(low), earliestExcluded=draw(st.booleans()))
    if draw(st.booleans()):
        high = low + draw(bounds)
        interval.latest = nearest(high)
        interval.latestExcluded = draw(st.booleans())
        if high == low:
            interval.earliestExcluded = interval.latestExcluded = False
    return interval


Bounds = tuple[Fraction, Fraction | None, bool, bool]


def bounds_of(net: pn.Net) -> list[Bounds | None]:
    """Return the intervals of a net, by transition."""
    found: list[Bounds | None] = []
    for transition in transitions(net):
        given = transition.interval
        if given is None:
            found.append(None)
            continue
        latest = None if given.latest is None else fraction_of(given.latest)
        opens = latest is not None and bool(given.latestExcluded)
        found.append((fraction_of(given.earliest), latest, bool(given.earliestExcluded), opens))
    return found


def timed_net(*intervals: pn.TimeInterval | None) -> pn.Net:
    """Return a net in which each transition takes from one place, reads another and puts the token back."""
    net = pn.Net(id="n")
    page = pn.Page(id="page", net=net)
    place, other = pn.Place(id="p", tokens=1, page=page), pn.Place(id="q", tokens=2, page=page)
    for number, interval in enumerate(intervals):
        step = pn.Transition(id=f"t{number}", interval=interval, page=page)
        flow(place, step, place)
        read(other, step)
    return net


@given(st.lists(exact_intervals(), min_size=1, max_size=4), st.permutations([".net", ".pnml", ".xml"]))
def test_bounds_are_the_same_in_all_formats(
    tmp_path_factory: pytest.TempPathFactory, intervals: list[pn.TimeInterval], order: list[str]
) -> None:
    folder = tmp_path_factory.mktemp("formats")
    net = timed_net(*intervals)
    # Romeo says [0, inf) of each transition, so that it does not tell it from no interval.
    free: Bounds = (Fraction(0), None, False, False)
    expected = [None if one == free else one for one in bounds_of(net)]
    for suffix in order:
        save(net, folder / f"net{suffix}")
        net = load(folder / f"net{suffix}")
    assert bounds_of(net) == expected


@given(st.lists(exact_intervals(), min_size=1, max_size=3))
def test_xmi_keeps_decimals_and_refuses_what_has_no_end(
    tmp_path_factory: pytest.TempPathFactory, intervals: list[pn.TimeInterval]
) -> None:
    path = tmp_path_factory.mktemp("xmi") / "net.xmi"
    net = timed_net(*intervals)
    texts = [exact_text(bound) for one in bounds_of(net) if one for bound in one[:2] if bound is not None]
    if any("/" in text for text in texts):
        with pytest.raises(ModelFileError, match="has no end"):
            save(net, path)
    else:
        save(net, path)
        assert bounds_of(load(path)) == bounds_of(net)


MATHML = '<interval xmlns="http://www.w3.org/1998/Math/MathML" closure="{}">'


@pytest.mark.parametrize(
    ("interval", "closure", "bounds"),
    [
        (pn.TimeInterval(earliest=4.0, latest=9.0), "closed", "<cn>4</cn>\n            <cn>9</cn>"),
        (pn.TimeInterval(earliest=3.0, latest=5.0, earliestExcluded=True), "open-closed", "<cn>3</cn>"),
        (pn.TimeInterval(earliest=3.0, latest=5.0, latestExcluded=True), "closed-open", "<cn>5</cn>"),
        (pn.TimeInterval(earliest=4.0), "closed-open", "<ci>infty</ci>"),
        (pn.TimeInterval(earliest=0.5, earliestExcluded=True), "open", "<cn>0.5</cn>"),
        (pn.TimeInterval(latest=exact_number("1/3")), "closed", '<cn type="rational">1<sep/>3</cn>'),
    ],
)
def test_intervals_stand_in_pnml_as_tina_writes_them(
    tmp_path: Path, interval: pn.TimeInterval, closure: str, bounds: str
) -> None:
    net = timed_net(interval)
    save(net, tmp_path / "net.pnml")
    text = (tmp_path / "net.pnml").read_text(encoding="utf-8")
    assert "<delay>" in text and MATHML.format(closure) in text and bounds in text
    # A loop would restart the clocks of others, so a read arc is a test arc, and our own blocks add nothing.
    assert text.count('<type value="test"/>') == 1
    assert "toolspecific" not in text
    assert differences(load(tmp_path / "net.pnml"), net) == []


def test_without_intervals_a_read_arc_stays_a_pair_of_normal_arcs(tmp_path: Path) -> None:
    save(timed_net(None), tmp_path / "net.pnml")
    text = (tmp_path / "net.pnml").read_text(encoding="utf-8")
    assert 'value="test"' not in text and "half=" in text


def test_an_interval_that_delays_cannot_say_stands_in_our_own_block(tmp_path: Path) -> None:
    upside_down = timed_net(pn.TimeInterval(earliest=3.0, latest=1.0))
    save(upside_down, tmp_path / "net.pnml")
    assert "<delay>" not in (tmp_path / "net.pnml").read_text(encoding="utf-8")
    assert bounds_of(load(tmp_path / "net.pnml")) == [(Fraction(3), Fraction(1), False, False)]


PNML = """<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml"><net id="n"
 type="http://www.pnml.org/version-2009/grammar/ptnet"><page id="g">
<place id="p"/><referencePlace id="r" ref="p"/><transition id="t"/>
<arc id="a" source="p" target="t"><inscription><text>2</text></inscription></arc>
<arc id="b" source="r" target="t"><type value="test"/><inscription><text>{}</text></inscription></arc>
</page></net></pnml>"""


@pytest.mark.parametrize(("weight", "read_weight"), [(5, 3), (2, None), (1, None)])
def test_a_test_arc_beside_a_normal_arc_is_what_tina_means(
    tmp_path: Path, weight: int, read_weight: int | None
) -> None:
    (tmp_path / "net.pnml").write_text(PNML.format(weight), encoding="utf-8")
    net = load(tmp_path / "net.pnml")
    assert find(net, "a", pn.Arc).weight == 2
    found = [arc.weight for arc in net.pages[0].arcs if str(arc.kind) == "read"]
    assert found == ([] if read_weight is None else [read_weight])
