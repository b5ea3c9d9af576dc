"""Romeo's language ``.cts``: what Romeo writes is read, and what else the language can say is refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import assume, given

from dineros.metamodel import pn
from dineros.metamodel.elements import transitions
from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files import load, save
from dineros.metamodel.files.romeo import cts_text, net_from_cts
from dineros.metamodel.files.tina import net_text
from dineros.metamodel.positions import location_of
from tests.metamodel.files.romeo.test_romeo import meaning
from tests.support.systems.models import plain_nets

PATH = Path("example.cts")

CELL = """// TPN name=cell.cts

typedef int place;

// insert here your type definitions using C-like syntax

initially {
 // insert here the state variables declarations
place  Idle=1, Parts=3, Busy=0, Alarm=0; }

 transition [ priority=2, intermediate {  Parts =  Parts  - 2 , Idle =  Idle  - 1; }]  Begin [0,0]
      when (Idle >= 1 and Parts >= 2 and Alarm < 1)
      {  Idle = Idle  - 1 , Parts = Parts  - 2 , Busy = Busy + 1; }
 transition [ control=u, cost=3, intermediate {  Busy =  Busy  - 1; }, speed= 1 ]  End (1,2.5)
      when (Busy >= 1 and (Idle <= 0))
      {  Busy =  Busy  - 1 +  1 , Idle = Idle + 1; }
 transition  Watch [1/3,inf)
      when (Busy > 1)
      {  Alarm = Alarm + 1; }
 transition  Tick [10,inf]
      when (true)
      {   }

  cost_rate 3*Busy
  // insert TCTL formula here : check formula
graph [passed=eq]
"""
"""In Romeo's own layout, with both ways in which its versions write an interval without an end."""

EXPECTED = """net example
pl Idle (1)
pl Parts (3)
pl Busy
pl Alarm
tr Begin [0,0] Idle Parts*2 Alarm?-1 -> Busy
tr End ]1,2.5[ Idle?-1 Busy -> Idle Busy
tr Watch [1/3,w[ Busy?2 -> Alarm
tr Tick [10,w[
pr Begin > End Watch Tick
"""


def parse(text: str) -> pn.Net:
    return net_from_cts(text.encode(), PATH)


def test_what_romeo_writes_is_read() -> None:
    net = parse(CELL)
    assert net_text(net) == EXPECTED
    watch = next(one for one in transitions(net) if one.id == "Watch")
    assert str(location_of(watch)) == "example.cts:17:14"


@given(plain_nets())
def test_reading_what_was_written_gives_a_net_of_the_same_meaning(net: pn.Net) -> None:
    try:
        text = cts_text(net)
    except ModelFileError as error:
        assert "priorities" in str(error)
        assume(False)
    again = parse(text)
    assert meaning(again) == meaning(net)
    assert cts_text(again) == text


def test_old_versions_declare_places_as_numbers() -> None:
    assert cts_text(parse(CELL.replace("place  Idle", "int Idle"))) == cts_text(parse(CELL))


def test_files_by_their_suffix(tmp_path: Path) -> None:
    save(parse(CELL), tmp_path / "cell.cts")
    assert meaning(load(tmp_path / "cell.cts")) == meaning(parse(CELL))


def one(transition: str, places: str = "place P=1, Q=0;") -> str:
    return f"initially {{ {places} }}\n{transition}"


def step(
    guard: str = "P >= 1", effect: str = "P = P - 1;", options: str = "intermediate { P = P - 1; }"
) -> str:
    return one(f"transition [{options}] T [0,1] when ({guard}) {{ {effect} }}")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("transition T [0,1] when (true) { }", "'initially' is expected"),
        (
            one("", "bool x = true; place P=1;"),
            "1:13: unexpected 'bool': 'place' is expected (a net has places only",
        ),
        ("typedef int[2] place;" + one(""), "only 'typedef int place;' is read"),
        ("const int n = 2; " + one(""), "unexpected 'const'"),
        ("parameters a > 2 " + one(""), "unexpected 'parameters'"),
        (one("", "place P={1,2};"), "tokens with colours are not read"),
        (one("", "place P=1, P=2;"), "place 'P' is declared twice"),
        (one("", "place P=99999999999;"), "a whole number of 32 bits is expected"),
        (one("", "place P=-1;"), "unexpected '-'"),
        (one("for $any = 0, 2 { transition T [0,1] when (true) { } }"), "unexpected 'for'"),
        (one("transition T [2,1] when (true) { }"), "2:14: the interval of transition 'T' is empty"),
        (one("transition T [1,1) when (true) { }"), "the interval of transition 'T' is empty"),
        (one("transition T [a,2] when (true) { }"), "parametric nets are not analysed"),
        (one("transition T [1,-2] when (true) { }"), "unexpected '-'"),
        (one("transition T [1/0,2] when (true) { }"), "unexpected '1/0'"),
        (one("transition T [inf,inf) when (true) { }"), "unexpected 'inf'"),
        (one("transition T [0,1] when (true) { } transition T [0,1] when (true) { }"), "'T' is taken"),
        (one("transition [speed= min(1,P)] T [0,1] when (true) { }"), "a speed is not read (clocks that run"),
        (one("transition [speed=0] T [0,1] when (true) { }"), "a speed is not read"),
        (one("transition [priority=P] T [0,1] when (true) { }"), "priorities that change are not read"),
        (one("transition [urgent=1] T [0,1] when (true) { }"), "the option 'urgent' is not supported"),
        (step("R >= 1"), "there is no place 'R'"),
        (step("P == 1"), "unexpected '=='"),
        (step("P >= Q"), "a place is compared with a number"),
        (step("P >= 1 or Q >= 1"), "unexpected 'or'"),
        (step("(P >= 1 and Q < 2"), "unexpected '{'"),
        (step("Q < 0 and P >= 1"), "Q < 0 is never true"),
        (step(effect="P = 0;"), "unexpected '0': 'P' is expected (only changes such as"),
        (step(effect="P = P - 2;"), "transition 'T' takes tokens from 'P', which 'intermediate' keeps"),
        (step(options="cost=1"), "transition 'T' takes tokens from 'P', which 'intermediate' keeps"),
        (step("true"), "takes 1 from 'P', and its guard asks for 0 (write P >= 1)"),
        (step(options="intermediate { P = P + 1; }"), "the intermediate marking adds tokens to 'P'"),
        (step(effect="if (P > 1) { P = P - 1; }"), "there is no place 'if'"),
        (
            step() + " check EF (P == 0) transition U [0,1] when (true) { }",
            "'transition' follows 'check'",
        ),
        (step() + " {", "a transition, or a formula to check is expected"),
        (step()[:-1], "unexpected the end of the file"),
    ],
)
def test_what_a_net_cannot_say_is_refused(text: str, message: str) -> None:
    with pytest.raises(ModelFileError) as caught:
        parse(text)
    assert message in str(caught.value)
    assert str(caught.value).startswith("example.cts:")
