"""No bytes at all end in anything but a model or a `DinerosError` of one line."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from dineros.metamodel.base import EObject
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import find
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files import load_any, save
from dineros.metamodel.pn import Net, Transition
from tests.support.systems.small import small_net, small_system

SUFFIXES = ["xmi", "pnml", "net", "xml"]
quick = settings(max_examples=40, suppress_health_check=[HealthCheck.too_slow])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fuzz")


def judge(path: Path, content: bytes) -> EObject | None:
    """Return the model in a file, or None if it is refused properly; a model can be validated and saved."""
    path.write_bytes(content)
    try:
        root = load_any(path)
    except DinerosError as error:
        assert str(error).startswith(str(path))
        assert "\n" not in str(error)
        return None
    if isinstance(root, Net):
        validate(root)
    try:
        save(root, path.with_name(f"saved{path.suffix}"))
    except DinerosError as error:
        assert "\n" not in str(error)
    return root


@pytest.mark.parametrize("suffix", SUFFIXES)
@given(content=st.binary(max_size=300))
@example(content=b"")
@example(content=b"\xff\xfe<\x00")
def test_random_bytes(folder: Path, suffix: str, content: bytes) -> None:
    judge(folder / f"random.{suffix}", content)


WORDS = [
    "net",
    "tr",
    "pl",
    "lb",
    "pr",
    "nt",
    "a",
    "b",
    "{c d}",
    ":",
    "->",
    ">",
    "<",
    "(",
    ")",
    "3",
    "0",
    "9K",
    "w",
]
SIGNS = ["*", "?", "?-", "!", "[", "]", ",", "\\", "{", "}", "\n", "#", "'", "ä", "-1"]


@given(st.lists(st.sampled_from([*WORDS, *SIGNS]), max_size=25))
def test_random_words_of_the_net_format(folder: Path, words: list[str]) -> None:
    judge(folder / "words.net", " ".join(words).encode())


@pytest.fixture(scope="module")
def originals(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Return the content of small valid files of every format, by name."""
    folder = tmp_path_factory.mktemp("originals")
    plain, system = small_net(), small_system()
    find(plain, "start", Transition).interval = None
    for suffix in SUFFIXES:
        if suffix == "xml":  # Romeo's priorities order all transitions
            find(plain, "stop", Transition).overrides.clear()
        save(plain, folder / f"plain.{suffix}")
    for suffix in ("xmi", "pnml"):
        save(system, folder / f"system.{suffix}")
    return {path.name: path.read_bytes() for path in folder.iterdir()}


NAMES = ["plain.xmi", "plain.pnml", "plain.net", "plain.xml", "system.xmi", "system.pnml"]


@pytest.mark.parametrize("name", NAMES)
def test_the_originals_load(folder: Path, originals: dict[str, bytes], name: str) -> None:
    assert judge(folder / name, originals[name]) is not None


@pytest.mark.parametrize("name", NAMES)
@given(data=st.data())
@quick
def test_flipped_cut_and_repeated_bytes(
    folder: Path, originals: dict[str, bytes], name: str, data: st.DataObject
) -> None:
    content = bytearray(originals[name])
    for _ in range(data.draw(st.integers(1, 4), label="changes")):
        start = data.draw(st.integers(0, len(content)), label="from")
        end = min(len(content), start + data.draw(st.integers(0, 40), label="length"))
        change = data.draw(st.sampled_from(["flip", "remove", "cut", "repeat", "insert"]), label="change")
        if change == "flip" and start < len(content):
            content[start] ^= data.draw(st.integers(1, 255), label="bits")
        elif change == "remove":
            del content[start:end]
        elif change == "cut":
            del content[start:]
        elif change == "repeat":
            content[start:start] = content[start:end]
        else:
            content[start:start] = data.draw(st.binary(max_size=8), label="bytes")
    judge(folder / name, bytes(content))


VALUES = [
    "",
    "0",
    "-1",
    "1.5",
    "1e99",
    "9" * 30,
    "NaN",
    "true",
    "a b",
    "#",
    "/",
    "//@pages.0",
    "page",
    "idle",
    "talker",
]
_TAG = re.compile(r"<[^<>?]+>")
_ATTRIBUTE = re.compile(r' ([\w:]+)="([^"]*)"')
_TEXT = re.compile(r">([^<>]+)<")


@pytest.mark.parametrize("name", [name for name in NAMES if not name.endswith("net")])
@given(data=st.data())
@quick
def test_removed_repeated_and_renamed_elements_and_attributes(
    folder: Path, originals: dict[str, bytes], name: str, data: st.DataObject
) -> None:
    text = originals[name].decode()
    words = sorted({match[1] for match in _ATTRIBUTE.finditer(text)} | set(re.findall(r"<([\w:]+)", text)))
    values = sorted({match[2] for match in _ATTRIBUTE.finditer(text)} | set(VALUES))
    for _ in range(data.draw(st.integers(1, 3), label="changes")):
        pattern = data.draw(st.sampled_from([_TAG, _ATTRIBUTE, _TEXT]), label="what")
        found = list(pattern.finditer(text))
        if not found:
            continue
        match = data.draw(st.sampled_from(found), label="where")
        if pattern is _ATTRIBUTE:
            new = data.draw(
                st.sampled_from(
                    ["", match[0] * 2, *(f' {match[1]}="{value}"' for value in values)]
                    + [f' {word}="{match[2]}"' for word in words]
                ),
                label="new",
            )
        elif pattern is _TEXT:
            new = f">{data.draw(st.sampled_from(values), label='text')}<"
        else:
            new = data.draw(
                st.sampled_from(
                    ["", match[0] * 2, match[0].replace(">", "/>"), *(f"<{word}/>" for word in words)]
                ),
                label="new",
            )
        text = text[: match.start()] + new + text[match.end() :]
    judge(folder / name, text.encode())


@pytest.mark.parametrize("name", [name for name in NAMES if not name.endswith("net")])
@given(data=st.data())
@quick
def test_moved_and_removed_subtrees(
    folder: Path, originals: dict[str, bytes], name: str, data: st.DataObject
) -> None:
    from lxml import etree

    root = etree.fromstring(originals[name])
    for _ in range(data.draw(st.integers(1, 3), label="changes")):
        nodes = list(root.iter())
        node = data.draw(st.sampled_from(nodes[1:] or nodes), label="node")
        parent = node.getparent()
        if parent is None:
            continue
        other = data.draw(st.sampled_from(nodes), label="other")
        change = data.draw(st.sampled_from(["remove", "copy", "move"]), label="change")
        if change == "copy":
            other.append(etree.fromstring(etree.tostring(node)))
        else:
            parent.remove(node)
            if change == "move" and not any(ancestor is node for ancestor in [other, *other.iterancestors()]):
                other.append(node)
    judge(folder / name, etree.tostring(root))
