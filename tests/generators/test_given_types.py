"""What a handler gives to places: the data of tokens that it took, some fields, or a mixture."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.generators import Options, generate
from dineros.metamodel import sym
from dineros.metamodel.build import node_net, place, step
from tests.support.type_checker import strict_mypy

HANDLER = """
@firings.on("Move")
def move(firing: firings.MoveFiring) -> firings.Outcome:
    taken = firing.inputs["Here"][0].data
    if not taken["text"]:
        return firing.give({{"There": taken, "Noted": [taken, {{"text": "again"}}]}})
    if firing.instance:
        return firing.give({{"There": [each.data for each in firing.inputs["Here"]]}})
    if firing.still_enabled:
        return firing.give({{"Noted": {{"text": "some"}}}})
    return firing.give({given})
"""


@pytest.mark.long
def test_the_data_of_a_token_can_be_given(tmp_path: Path) -> None:
    token = sym.TokenType(id="Word", fields=[sym.TokenField(name="text"), sym.TokenField(name="language")])
    model = sym.SystemModel(id="mover", tokenType=token)
    node = node_net(model, "moving")
    here, there, noted = (place(node, id, tokens=int(id == "Here")) for id in ("Here", "There", "Noted"))
    step(node, "Move", [here], [there, noted])
    generate(model, tmp_path, Options(source="mover.sym.xmi"))
    file = tmp_path / "src/moving/moving/handlers.py"
    head = file.read_text().partition("@firings.on")[0]
    right = '{"There": firing.inputs["Here"][0].data}'
    file.write_text(head + HANDLER.format(given=right).lstrip())
    said = strict_mypy(tmp_path, "src/moving")
    assert said.startswith("Success: no issues found"), said
    for wrong in (
        '{"There": 3}',
        '{"There": {"txt": ""}}',
        '{"There": {"text": 3}}',
        '{"Her": {"text": ""}}',
    ):
        file.write_text(head + HANDLER.format(given=wrong).lstrip())
        assert "error:" in strict_mypy(tmp_path, "src/moving"), wrong
