"""Developers' modules: what is found in them, and adding to them without changing a byte."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.generators.workspace.developers import (
    DeveloperFileError,
    Module,
    append,
    handlers,
    instance_of,
    module_name,
    names,
    read_module,
    texts,
)

MODULE = '''\
"""Handlers."""

import asyncio

from . import firings as f
from . import helpers

THRESHOLD = 3
low, high = 1, 2


@f.on("TPick", priority=2)
@helpers.logged
def pick(firing):
    firing.data["pose"] = [0.0]
    return {"color": "red"}


@f.on("Pick[2].TPick")
async def second(firing):
    await asyncio.sleep(0)


class Calls:
    @f.on("TPlace")
    def place(self, firing):
        return dict(color="blue")


f.on("TStop")(lambda firing: None)
for name in ("TA", "TB"):
    f.on(name)(pick)
print("on", f.off("TNever"))
'''


def module(text: str | bytes = MODULE) -> Module:
    return read_module(Path("handlers.py"), text.encode() if isinstance(text, str) else text)


def test_handlers_are_found_with_their_lines() -> None:
    found = [(each.transition, each.function, each.line, each.end) for each in handlers(module())]
    assert found == [
        ("TPick", "pick", 12, 16),
        ("Pick[2].TPick", "second", 19, 21),
        ("TPlace", "place", 25, 27),
        ("TStop", "", 30, 30),
    ]


def test_an_instances_transition_is_the_models() -> None:
    assert [each.model_transition for each in handlers(module())] == ["TPick", "TPick", "TPlace", "TStop"]
    assert instance_of("Pick[12].T[1]") == ("Pick", 12, "T[1]")
    assert instance_of("TPick") is None


def test_names_of_the_top_level() -> None:
    assert names(module()) == {
        "asyncio",
        "f",
        "helpers",
        "THRESHOLD",
        "low",
        "high",
        "pick",
        "second",
        "Calls",
        "name",
    }


@pytest.mark.parametrize(
    ("line", "name"),
    [
        ("from . import firings", "firings"),
        ("from . import firings as f", "f"),
        ("from selector import firings", "firings"),
        ("from selector import other, firings as g", "g"),
        ("from other import firings", None),
        ("from .. import firings", None),
        ("import firings", None),
    ],
)
def test_what_a_module_calls_its_neighbour(line: str, name: str | None) -> None:
    assert module_name(module(line), "selector", "firings") == name


def test_words_are_found_as_texts_and_keywords() -> None:
    assert texts(module(), ["pose", "color", "name"]) == [("pose", 15), ("color", 16), ("color", 27)]


STUB = "@f.on('T')\ndef t(firing):\n    return {}\n"


@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"x = 1",
        b"x = 1\n",
        b"x = 1\r\ny = 2\r\n",
        b"\xef\xbb\xbfx = '\xc3\xa9'\n",
        b"# -*- coding: latin-1 -*-\nx = '\xe9'\n",
        b"if True:\n\tx = 1\n\t# end",
        b'"""Text."""',
        b"x = (1,\n     2)  # no end of line",
    ],
)
def test_what_was_there_stays_and_what_results_is_python(text: bytes) -> None:
    before = read_module(Path("handlers.py"), text)
    after = append(before, [STUB, STUB.replace("def t", "def u")])
    assert after.startswith(text)
    added = handlers(read_module(Path("handlers.py"), after))
    assert [each.function for each in added] == ["t", "u"]
    assert (b"\r\n" in after) == (b"\r\n" in text)
    assert after.count(b"\n") == after.count(b"\r\n") or b"\r\n" not in after


@given(st.text(st.characters(codec="utf-8"), max_size=60))
def test_any_text_is_extended_or_refused(text: str) -> None:
    content = text.encode()
    try:
        before = read_module(Path("handlers.py"), content)
    except DeveloperFileError:
        return
    after = append(before, [STUB])
    assert after.startswith(content)
    assert len(ast.parse(after).body) == len(before.tree.body) + 1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"def t(:\n", "handlers.py:1: is not Python: "),
        (b"x = 1\ny = '\n", "handlers.py:2: is not Python: "),
        (b"x = '\xe9'\n", "handlers.py: is not Python: "),
        (b"# coding: nonsense\n", "handlers.py: is not Python: "),
    ],
)
def test_what_is_no_python_is_refused(text: bytes, said: str) -> None:
    with pytest.raises(DeveloperFileError) as error:
        read_module(Path("handlers.py"), text)
    assert str(error.value).startswith(said)


def test_an_encoding_that_cannot_write_the_stub_is_refused() -> None:
    before = read_module(Path("handlers.py"), b"# coding: latin-1\n")
    with pytest.raises(DeveloperFileError, match=r"is written in iso-8859-1, .*write it in UTF-8"):
        append(before, ["x = '→'\n"])
