"""Parsers from grammars: stored tables are used, and only where they belong to the grammar."""

import sys
from pathlib import Path

import lark
import pytest

from dineros.metamodel.grammars import parser_of

GRAMMAR = 'start: "a" "b"*\n'


@pytest.fixture
def grammar(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    (tmp_path / "__pycache__").mkdir()
    file = tmp_path / "some.lark"
    file.write_text(GRAMMAR)
    return file


def stored(grammar: Path) -> list[Path]:
    return list((grammar.parent / "__pycache__").iterdir())


def accepts(parser: lark.Lark, text: str) -> bool:
    try:
        parser.parse(text)
    except lark.exceptions.UnexpectedInput:
        return False
    return True


def test_tables_are_stored_and_used(grammar: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parser_of(grammar)
    (file,) = stored(grammar)
    before = file.read_bytes()
    monkeypatch.setattr(lark.lark, "load_grammar", lambda *_: pytest.fail("the grammar was read again"))
    parser = parser_of(grammar)
    assert accepts(parser, "abb")
    assert not accepts(parser, "ba")
    assert file.read_bytes() == before


def test_a_changed_grammar_gets_new_tables(grammar: Path) -> None:
    assert not accepts(parser_of(grammar), "c")
    grammar.write_text('start: "c"\n')
    parser = parser_of(grammar)
    assert accepts(parser, "c")
    assert not accepts(parser, "ab")


def test_other_options_get_other_tables(grammar: Path) -> None:
    grammar.write_text('start: "a"\nother: "b"\n')
    assert not accepts(parser_of(grammar), "b")
    assert accepts(parser_of(grammar, start="other"), "b")
    assert not accepts(parser_of(grammar), "b")


@pytest.mark.parametrize("cut", [0, 10, 70, 300])
def test_damaged_tables_are_replaced(grammar: Path, cut: int) -> None:
    parser_of(grammar)
    (file,) = stored(grammar)
    file.write_bytes(file.read_bytes()[:cut])
    assert accepts(parser_of(grammar), "abb")


def test_nothing_is_stored_without_compiled_modules(grammar: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    assert accepts(parser_of(grammar), "abb")
    assert stored(grammar) == []


def test_a_folder_that_cannot_be_written_does_no_harm(grammar: Path) -> None:
    (grammar.parent / "__pycache__" / f"some.{sys.implementation.cache_tag}.tables").mkdir()
    assert accepts(parser_of(grammar), "abb")
