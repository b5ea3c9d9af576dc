"""Names of a plain net: ids, and the names of its elements where they are unique."""

from __future__ import annotations

import pytest

from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.model.names import unique_names
from dineros.analysis.model.subject import subject_of
from dineros.metamodel import pn
from dineros.metamodel.build import flow


def the_net() -> pn.Net:
    page = pn.Page(id="page", net=(net := pn.Net(id="n")))
    entry = pn.Place(id="c-1", name="Entry", tokens=1, page=page)
    both = pn.Place(id="c-2", name="Both", page=page)
    pn.Place(id="c-3", name="Both", page=page)
    pn.Place(id="c-4", name="c-1", page=page)  # the id of another place
    pn.Place(id="c-5", page=page)
    go = pn.Transition(id="c-6", name="Go", page=page)
    pn.Transition(id="c-7", name="Entry 2", page=page)
    flow(entry, go, both)
    return net


def test_names_that_are_unique() -> None:
    assert unique_names(the_net()) == {"c-1": "Entry", "c-6": "Go", "c-7": "Entry 2"}


def test_conditions_take_ids_and_unique_names() -> None:
    names = subject_of(the_net()).names
    assert names.places("Entry") == names.places("c-1") == (0,)
    assert names.transitions("Go") == names.transitions("c-6") == (0,)
    assert names.signal("Entry") == 0
    assert names.places("c-4") == (3,)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("Both", "2 places are named 'Both' (give the id: c-2, c-3)"),
        ("Etry", "no place is named 'Etry' (did you mean 'Entry'"),
        ("Go", "no place is named 'Go'"),
    ],
)
def test_other_names_are_refused(name: str, message: str) -> None:
    with pytest.raises(FormulaError) as caught:
        subject_of(the_net()).names.places(name)
    assert message in str(caught.value)


def test_answers_use_names_where_they_are_unique() -> None:
    subject = subject_of(the_net())
    assert [subject.place_text(index) for index in range(5)] == ["Entry", "c-2", "c-3", "c-4", "c-5"]
    assert [subject.transition_text(index) for index in range(2)] == ["Go", "Entry 2"]
