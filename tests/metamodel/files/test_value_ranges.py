"""Ranges of token fields in files: what is saved is what is loaded, in XMI and in PNML."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.files import load, save


@pytest.mark.parametrize("suffix", [".sym.xmi", ".pnml"])
def test_ranges_are_saved(suffix: str, tmp_path: Path) -> None:
    door = sym.TokenType(
        id="Door",
        fields=[
            sym.TokenField(name="state", kind="integer", values="SHUT=0, OPEN=1"),
            sym.TokenField(name="percent", kind="integer", minimum=0, maximum=100),
        ],
    )
    hall = sym.Place(id="Hall", tokens=1, balloons=[sym.BalloonToken(data='{"state": "OPEN"}')])
    model = sym.SystemModel(id="doors", tokenType=door, pages=[sym.NodeNet(id="gate", objects=[hall])])
    save(model, tmp_path / f"doors{suffix}")
    read = load(tmp_path / f"doors{suffix}")
    assert isinstance(read, sym.SystemModel) and read.tokenType is not None
    state, percent = read.tokenType.fields
    assert (state.values, state.minimum, state.maximum) == ("SHUT=0, OPEN=1", None, None)
    assert (percent.values, percent.minimum, percent.maximum) == (None, 0, 100)
    assert not [each for each in validate(read) if each.severity == "error"]
