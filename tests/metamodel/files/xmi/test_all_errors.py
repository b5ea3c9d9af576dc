"""XMI: everything that is wrong is said at once; what people write by hand needs no normal form."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.metamodel import pn, sym
from dineros.metamodel.clauses import cnf_text
from dineros.metamodel.constraints import validate
from dineros.metamodel.errors import CollectedModelFileError, ModelFileError
from dineros.metamodel.files import load, save

HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<sym:SystemModel xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI" \
xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xmlns:pn="{pn}" xmlns:sym="{sym}" id="model">
"""


def written(folder: Path, body: str) -> Path:
    path = folder / "model.sym.xmi"
    pn_uri, sym_uri = (kind.eClass.ePackage.nsURI for kind in (pn.Place, sym.NodeNet))
    path.write_text(f"{HEAD.format(pn=pn_uri, sym=sym_uri)}{body}\n</sym:SystemModel>\n", encoding="utf-8")
    return path


WRONG = """  <pages xsi:type="sym:NodeNet" id="node" threads="many">
    <objects xsi:type="sym:Place" id="A" token="3"/>
    <objects xsi:type="sym:Plaice" id="B"/>
    <objects xsi:type="sym:Transition" id="T"/>
    <arcs id="one" source="A" target="T"/>
    <arcs id="two" source="B" target="T"/>
    <arcs id="three" source="T" target="Nowhere"/>
    <arcs id="four" source="T"/>
    stray
  </pages>"""


def test_every_error_is_said(tmp_path: Path) -> None:
    with pytest.raises(CollectedModelFileError) as caught:
        load(written(tmp_path, WRONG))
    said = [(error.location.line if error.location else None, error.message) for error in caught.value.errors]
    assert [line for line, _ in said] == [3, 4, 5, 9, 10, 10]
    text = "\n".join(message for _, message in said)
    for part in ("threads", "no feature 'token'", "Plaice", "Nowhere", "has no target", "stray"):
        assert part in text
    # What is missing only because its element could not be read is not an error of its own.
    assert "'B'" not in text
    assert len(said) == 6
    assert str(caught.value).startswith(f"{tmp_path / 'model.sym.xmi'}:3: threads of")
    assert "; and 5 more errors" in str(caught.value)


def test_one_error_is_what_it_was(tmp_path: Path) -> None:
    body = '  <pages xsi:type="sym:NodeNet" id="node" threads="many"/>'
    with pytest.raises(ModelFileError) as caught:
        load(written(tmp_path, body))
    assert not isinstance(caught.value, CollectedModelFileError)


CLAUSE = """  <pages xsi:type="sym:NodeNet" id="node">
    <objects xsi:type="sym:Transition" id="T">
      <clause text="{text}"/>
    </objects>
    <signals id="Danger"/>
    <signals id="s2" name="Idle"/>
  </pages>"""


def test_a_clause_may_be_text_alone(tmp_path: Path) -> None:
    path = written(tmp_path, CLAUSE.format(text="not (Danger or Idle) -&gt; Danger"))
    model = load(path)
    (clause,) = (element for element in model.eAllContents() if isinstance(element, sym.InputClause))
    assert cnf_text(clause) == "Danger | Idle"
    again = tmp_path / "again.sym.xmi"
    save(model, again)
    assert "disjunctions" in again.read_text()
    assert validate(load(again)) == validate(model)


@pytest.mark.parametrize(
    ("text", "says"), [("Danger &amp;", "expected a signal"), ("Danger &amp; Idel", "did you mean 'Idle'?")]
)
def test_text_that_is_no_clause(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(ModelFileError, match=r"model\.sym\.xmi:5: clause of .*") as caught:
        load(written(tmp_path, CLAUSE.format(text=text)))
    assert says in str(caught.value)
