"""Damage to inputs: of bytes, of words, and of the structure of XML and JSON."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from copy import deepcopy
from random import Random
from typing import Any

from lxml import etree

NAMES = [
    "",
    " ",
    "x",
    "..",
    "../../x",
    "/etc/passwd",
    "/dev/zero",
    "a\nb",
    'x"""',
    "{{ 7*7 }}",
    "$(id)",
    "None",
    "import",
    "__class__",
    "CON",
    "ä\u202e\u0301",
    "\U0001f600",
    "<b>&amp;",
    "a.b",
    "a/b/1",
    "#",
    "//@pages.0",
    "-o",
    "x" * 300,
]
"""What a name should not be."""

NUMBERS = [
    "0",
    "-1",
    "1",
    "1.5",
    "1e999",
    "NaN",
    "-Infinity",
    "1_0",
    "\u0661",
    str(2**31 - 1),
    str(2**64),
    "9" * 5000,
]
"""What a number should not be."""

_JSON_VALUES: list[Any] = [
    None,
    True,
    False,
    0,
    -1,
    1.5,
    2**31,
    2**70,
    1e308,
    "",
    "x",
    [],
    {},
    [[]],
    {"": None},
]
_RAW = "@@raw%d@@"
_RAW_TEXTS = [
    "9" * 5000,
    "-" + "9" * 5000,
    "1e999",
    "NaN",
    "[" * 3000 + "]" * 3000,
    '{"a":' * 2000 + "1" + "}" * 2000,
    '"\\ud800"',
    '"\\u0000"',
]
_BYTES = [
    b"\0",
    b"\xed\xa0\x80",
    b"\xff\xfe",
    b"\xef\xbb\xbf",
    b"\r",
    b"\n\n",
    b"\\ud800",
    b"\x1b[2J",
    b"<",
    b'"',
    b"&#0;",
    b"&x;",
    b"{",
    b"}",
]
_WORD = re.compile(r"\w+|\s+|[^\w\s]")

Mutator = Callable[[Random, Sequence[bytes]], bytes]


def mutate_bytes(random: Random, seeds: Sequence[bytes]) -> bytes:
    """Flip, delete, repeat, splice and insert bytes."""
    content = bytearray(random.choice(seeds))
    for _ in range(random.randint(1, 4)):
        start = random.randint(0, len(content))
        end = min(len(content), start + random.choice([1, 2, 8, 40, 400]))
        match random.randrange(9):
            case 0 if start < len(content):
                content[start] ^= random.randint(1, 255)
            case 1:
                del content[start:end]
            case 2:
                content[start:start] = content[start:end] * random.choice([1, 2, 50])
            case 3:
                other = random.choice(seeds)
                content[start:] = other[random.randint(0, len(other)) :]
            case 4:
                content[start:end] = bytes([random.randrange(256)]) * random.choice([10, 1000, 70_000])
            case 5:
                content[start:start] = random.choice(NUMBERS).encode()
            case 6:
                content[start:start] = random.choice(_BYTES)
            case 7:
                opening = random.choice([b"[", b"(", b"{", b"<a>", b'{"a":', b"!", b"G ", b"not "])
                content[start:start] = opening * random.choice([10, 500, 5000])
            case _:
                del content[start:]
    return bytes(content)


def mutate_words(random: Random, seeds: Sequence[bytes]) -> bytes:
    """Drop, repeat, swap and replace the words and signs of a text."""
    if random.random() < 0.15:
        return mutate_bytes(random, seeds)[:100_000]
    words = [_WORD.findall(seed.decode("utf-8", "replace")) for seed in seeds]
    known = sorted({word for text in words for word in text})
    content = list(random.choice(words))
    mild = random.random() < 0.6  # what is refused at once shows little
    for _ in range(1 if mild else random.randint(1, 4)):
        at = random.randint(0, max(0, len(content) - 1))
        match random.choice([0, 1, 2, 2, 3, 6] if mild else range(7)):
            case 0:
                del content[at : at + random.randint(1, 2 if mild else 5)]
            case 1:
                content[at:at] = content[at : at + random.randint(1, 8)] * random.choice(
                    [1] if mild else [1, 3, 30]
                )
            case 2:
                content[at : at + 1] = [random.choice(known)]
            case 3:
                content.insert(at, random.choice(known))
            case 4:
                content[at : at + 1] = [random.choice(NUMBERS + NAMES)]
            case 5:
                times = random.choice([2, 60, 2000])
                left, right = random.choice([("(", ")"), ("!", ""), ("not ", ""), ("-", ""), ("[", "]")])
                content[at : at + 1] = [left * times, *content[at : at + 1], right * times]
            case _:
                other = random.choice(words)
                content[at:] = other[random.randint(0, len(other)) :]
    return "".join(content).encode("utf-8", "surrogatepass")


def mutate_xml(random: Random, seeds: Sequence[bytes]) -> bytes:
    """Drop, repeat and move elements, swap and replace attributes; or damage bytes."""
    if random.random() < 0.2:
        return mutate_bytes(random, seeds)
    root = etree.fromstring(random.choice(seeds))
    if random.random() < 0.5:
        _change_values(random, root)
        return bytes(etree.tostring(root))
    for _ in range(random.choice([1, 1, 1, 1, 2, 4])):
        nodes = list(root.iter(etree.Element))
        node, other = random.choice(nodes), random.choice(nodes)
        parent = node.getparent()
        names = sorted(map(str, node.attrib))
        match random.randrange(9):
            case 0 if parent is not None:
                parent.remove(node)
            case 1:
                other.append(etree.fromstring(etree.tostring(node, with_tail=False)))
            case 2 if parent is not None and node is not other and node not in other.iterancestors():
                other.append(node)
            case 3 if names and other.attrib:
                _set(node, random.choice(names), str(random.choice(list(other.attrib.values()))))
            case 4 if names:
                _set(node, random.choice(names), random.choice(NUMBERS))
            case 5 if names:
                _set(node, random.choice(names), random.choice(NAMES))
            case 6 if names:
                del node.attrib[random.choice(names)]
            case 7:
                node.tag = other.tag
            case _ if other.attrib:
                name = random.choice(sorted(map(str, other.attrib)))
                _set(node, name, str(other.get(name)))
    if random.random() < 0.02:
        inner = random.choice(list(root.iter(etree.Element)))
        for _ in range(random.choice([50, 300, 3000])):
            inner = etree.SubElement(inner, inner.tag)
    return bytes(etree.tostring(root))


def _change_values(random: Random, root: etree._Element) -> None:
    """Change values only, to such of the same form: what is refused at once shows little."""
    holders = [(node, name) for node in root.iter(etree.Element) for name in map(str, node.attrib)]
    texts = [node for node in root.iter(etree.Element) if (node.text or "").strip()]
    for _ in range(random.choice([1, 1, 2])):
        if texts and (not holders or random.random() < 0.3):
            random.choice(texts).text = random.choice(["0", "1", "2", "99", random.choice(texts).text or ""])
            continue
        node, name = random.choice(holders)
        value = str(node.get(name))
        same = [str(each.get(name)) for each, other in holders if other == name]
        if value.isdecimal():
            value = random.choice(["0", "1", "2", "7", "99", "2147483647"])
        elif random.random() < 0.5:
            value = random.choice(same)
        else:
            value += random.choice(["x", "_", ".", "-", "\u00e4", " ", "/", "'", "1"])
        _set(node, name, value)


def _set(node: etree._Element, name: str, value: str) -> None:
    try:
        node.set(name, value)
    except ValueError:  # what no XML can hold
        node.set(name, ascii(value))


def mutate_json(random: Random, seeds: Sequence[bytes]) -> bytes:
    """Drop, repeat, move and replace values, keys and numbers; or damage bytes."""
    if random.random() < 0.2:
        return mutate_bytes(random, seeds)
    value = json.loads(random.choice(seeds))
    raw: list[str] = []
    for _ in range(random.choice([1, 1, 1, 1, 2, 4])):
        value = _changed(random, value, raw)
    text = json.dumps(value)
    for number, each in enumerate(raw):
        text = text.replace(f'"{_RAW % number}"', each)
    return text.encode()


def _changed(random: Random, value: Any, raw: list[str]) -> Any:
    places = _places(value)
    if not places:
        return deepcopy(random.choice(_JSON_VALUES))  # it is changed, perhaps put into itself
    holder, key = random.choice(places)
    match random.randrange(8):
        case 0:
            del holder[key]
        case 1:
            holder[key] = deepcopy(random.choice(_JSON_VALUES))
        case 2:
            other, name = random.choice(places)
            holder[key] = json.loads(json.dumps(other[name]))
        case 3 if isinstance(holder, dict):
            holder[random.choice(NAMES)] = holder.pop(key)
        case 4 if isinstance(holder, list):
            holder.extend(json.loads(json.dumps([holder[key]])) * random.choice([1, 5, 2000]))
        case 5:
            raw.append(random.choice(_RAW_TEXTS))
            holder[key] = _RAW % (len(raw) - 1)
        case 6:
            holder[key] = {"x": holder[key]} if random.random() < 0.5 else [holder[key]]
        case _:
            holder[key] = random.choice(NAMES + NUMBERS)
    return value


def _places(value: Any) -> list[tuple[Any, Any]]:
    """Return every container in a value, with each of its keys or positions."""
    found: list[tuple[Any, Any]] = []
    waiting = [value]
    while waiting:
        each = waiting.pop()
        keys = list(each) if isinstance(each, dict) else range(len(each)) if isinstance(each, list) else ()
        for key in keys:
            found.append((each, key))
            waiting.append(each[key])
    return found


def mutate_json_lines(random: Random, seeds: Sequence[bytes]) -> bytes:
    """Change, drop, repeat, swap and tear lines, each of which is JSON."""
    if random.random() < 0.15:
        return mutate_bytes(random, seeds)
    lines = [line for line in random.choice(seeds).split(b"\n") if line]
    for _ in range(random.choice([1, 1, 2, 3])):
        at = random.randrange(len(lines)) if lines else 0
        match random.randrange(6):
            case 0 if lines:
                del lines[at]
            case 1 if lines:
                lines.insert(random.randint(0, len(lines)), lines[at])
            case 2 if lines:
                other = random.randrange(len(lines))
                lines[at], lines[other] = lines[other], lines[at]
            case _ if lines:
                try:
                    lines[at] = mutate_json(random, [lines[at]])
                except (ValueError, RecursionError):  # was damaged before
                    lines[at] = mutate_bytes(random, [lines[at]])
    return b"\n".join(lines) + random.choice([b"\n", b"\n", b"\n", b"", b"\n\n", b"\n{"])
