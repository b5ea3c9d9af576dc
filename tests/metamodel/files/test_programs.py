"""Python programs that build models: parameters, their values, and what goes wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.metamodel import pn
from dineros.metamodel.errors import DinerosError, FeatureValueError, UnknownFeatureError
from dineros.metamodel.files.programs import ModelProgram, is_of_parameter, load_program

RING = '''
from dineros.metamodel import pn

def build(stations: int = 3, name: str = "ring", load: float = 0.5, closed: bool = True) -> pn.Net:
    """Return stations."""
    page = pn.Page(id="page")
    for number in range(stations):
        page.objects.append(pn.Place(id=f"station{number}", tokens=round(stations * load)))
    return pn.Net(id=name if closed else "line", pages=[page])
'''


def program(folder: Path, text: str = RING) -> ModelProgram:
    path = folder / "ring.py"
    path.write_text(text, encoding="utf-8")
    return load_program(path)


def test_a_program_has_the_parameters_of_its_function(tmp_path: Path) -> None:
    assert program(tmp_path).parameters == {"stations": 3, "name": "ring", "load": 0.5, "closed": True}


def test_values_of_parameters_build_the_model(tmp_path: Path) -> None:
    ring = program(tmp_path)
    model = ring.model(["stations=5", "load=0.4", "name=five"])
    assert (model.id, [tokens(each) for each in model.pages[0].objects]) == ("five", [2] * 5)
    assert ring.model(["closed=false"]).id == "line"
    assert len(ring.model().pages[0].objects) == 3
    assert len(ring.model(["stations=1", "stations=2"]).pages[0].objects) == 2  # the last one counts


def tokens(node: object) -> int:
    assert isinstance(node, pn.Place)
    return node.tokens


def test_settings_of_elements_are_none_of_parameters() -> None:
    settings = ["robots=3", "Orders.tokens=3", "middleware=ros1", "a b=3"]
    assert [is_of_parameter(each) for each in settings] == [True, False, False, False]


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("stations=many", "stations: takes a whole number, not 'many'"),
        ("stations=1.5", "stations: takes a whole number, not '1.5'"),
        ("load=inf", "load: takes a number, not 'inf'"),
        ("closed=yes", "closed: takes true or false, not 'yes'"),
    ],
)
def test_values_of_another_kind_are_refused(tmp_path: Path, setting: str, message: str) -> None:
    with pytest.raises(FeatureValueError, match=message):
        program(tmp_path).model([setting])


def test_an_unknown_parameter_is_named_with_what_is_near(tmp_path: Path) -> None:
    with pytest.raises(UnknownFeatureError, match="build has no parameter 'station'") as caught:
        program(tmp_path).model(["station=2"])
    assert caught.value.hint == "did you mean 'stations'?"


@pytest.mark.parametrize(
    ("text", "message", "line"),
    [
        ("def build(:", "is not Python", 1),
        ("x = 1\ny = 1 / 0\n", "ZeroDivisionError: division by zero", 2),
        ("model = 1\n", "defines no function build", None),
        ("def build(n: int = 1):\n    raise ValueError('no')\n", "ValueError: no", 2),
        ("def build():\n    return 3\n", "build returns 3, not a model", None),
        ("def build(n):\n    return None\n", "the parameter 'n' of build has no default", None),
        ("def build(*n):\n    return None\n", "the parameter 'n' of build has no default", None),
        ("def build(n=None):\n    return None\n", "the parameter 'n' of build has no default", None),
    ],
)
def test_what_is_wrong_with_a_program_is_said_with_its_line(
    tmp_path: Path, text: str, message: str, line: int | None
) -> None:
    with pytest.raises(DinerosError, match=message.replace("(", "\\(")) as caught:
        program(tmp_path, text).model()
    assert caught.value.location is not None
    assert (caught.value.location.file, caught.value.location.line) == (tmp_path / "ring.py", line)
