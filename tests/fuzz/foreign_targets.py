"""Files of other tools: PNML with what the standard does not know, and their property files."""

from __future__ import annotations

import shutil
import zlib
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from random import Random

from lxml import etree

from tests.fuzz import mutators
from tests.fuzz.judging import REFUSED, Outcome, run_command
from tests.support.pnml import PNML, PTNET
from tests.support.references.coloured import random_net

Attempt = Callable[[bytes], Outcome]

NODES = """<place id="a" {place}>{inplace}</place><place id="b"><name><text>Done</text></name></place>
<transition id="t" {transition}>{intransition}</transition>
<arc id="x" source="a" target="t" {arc}>{inarc}</arc><arc id="y" source="t" target="b"/>"""


def _file(start: str, end: str, **parts: str) -> bytes:
    names = ("place", "inplace", "transition", "intransition", "arc", "inarc")
    nodes = NODES.format(**{name: parts.get(name, "") for name in names})
    return f'<?xml version="1.0"?>\n{start}\n{nodes}\n{end}\n'.encode()


FILES = [
    _file(f'<pnml xmlns="{PNML}"><net id="n" type="{PTNET}"><page id="g">', "</page></net></pnml>"),
    _file(  # as TAPAAL writes it
        f'<pnml xmlns="{PNML}"><net active="true" id="n" type="P/T net">',
        "</net></pnml>",
        place='displayName="true" initialMarking="2" invariant="&lt; inf" name="a" positionX="1"',
        transition='angle="0" infiniteServer="false" name="t" player="0" priority="0" urgent="false"',
        arc='inscription="[0,inf)" type="tapnInhibitor" weight="2"',
        inarc='<arcpath arcPointType="false" id="0" xCoord="1" yCoord="2"/>',
    ),
    _file(  # as PIPE writes it
        '<pnml><net id="n" type="P/T net"><token id="Default" enabled="true" red="0" green="0" blue="0"/>',
        "</net></pnml>",
        inplace="<initialMarking><value>Default,2</value></initialMarking><capacity><value>3</value></capacity>",
        intransition="<rate><value>1.0</value></rate><timed><value>false</value></timed>"
        "<infiniteServer><value>false</value></infiniteServer><priority><value>1</value></priority>",
        inarc="<inscription><value>Default,2</value></inscription><tagged><value>false</value></tagged>"
        '<type value="normal"/>',
    ),
    _file(  # as PM4Py writes it
        '<pnml><net id="n" type="http://www.pnml.org/version-2009/grammar/pnmlcoremodel"><page id="g">',
        '</page><finalmarkings><marking><place idref="b"><text>1</text></place></marking></finalmarkings>'
        "</net></pnml>",
        inplace="<name><text>a</text></name><initialMarking><text>1</text></initialMarking>",
        intransition="<name><text>t</text></name><graphics><position x='1' y='2'/></graphics>",
        inarc="<arctype><text>inhibitor</text></arctype><inscription><text>2</text></inscription>",
    ),
    _file(  # as older tools write intervals
        f'<pnml xmlns="{PNML}"><net id="n" type="ptNetb"><name><value>n</value></name>',
        "</net></pnml>",
        intransition='<delay><interval xmlns="http://www.w3.org/1998/Math/MathML" closure="closed-open">'
        "<cn>1</cn><ci>infty</ci></interval></delay>",
    ),
]
ATTRIBUTES = [
    *(
        "type",
        "weight",
        "inscription",
        "marking",
        "initialMarking",
        "capacity",
        "priority",
        "urgent",
        "reset",
    ),
    *("invariant", "name", "positionX", "delay", "rate", "player", "distribution", "constant", "xyz"),
]
ELEMENTS = [
    *("type", "arctype", "weight", "inscription", "initialMarking", "capacity", "priority", "timed", "rate"),
    *(
        "delay",
        "name",
        "graphics",
        "toolspecific",
        "finalmarkings",
        "token",
        "tagged",
        "declaration",
        "hlmarking",
    ),
    *("referencePlace", "page", "xyz"),
]
VALUES = [
    *("0", "1", "2", "-1", "1.5", "inhibitor", "test", "read", "reset", "normal", "timed", "tapnInhibitor"),
    *("true", "false", "Default,2", "Default,2,Red,1", "Default,", ",2", "[0,inf)", "(1,2]", "[2,1]", "[0"),
    *("< inf", "<= 3", "a", "b", "", " 3 "),
]


def mutate_foreign(random: Random, originals: Sequence[bytes]) -> bytes:
    """Add attributes and elements such as other tools write, right or wrong; or damage a file."""
    if random.random() < 0.25:
        return mutators.mutate_xml(random, originals)
    root = etree.fromstring(random.choice(originals))
    for _ in range(random.choice([1, 1, 1, 2, 3])):
        node = random.choice(list(root.iter(etree.Element)))
        value = random.choice(VALUES if random.random() < 0.9 else mutators.NUMBERS)
        if random.random() < 0.5:
            node.set(random.choice(ATTRIBUTES), value)
            continue
        space = etree.QName(node).namespace if random.random() < 0.8 else "http://example.org/tool"
        name = random.choice(ELEMENTS)
        label = etree.SubElement(node, f"{{{space}}}{name}" if space else name)
        match random.randrange(4):
            case 0:
                label.set("value", value)
            case 1:
                label.text = value
            case 2:
                etree.SubElement(label, f"{{{space}}}text" if space else "text").text = value
            case _:
                etree.SubElement(label, f"{{{space}}}value" if space else "value").text = value
    return bytes(etree.tostring(root))


def foreign_pnml(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Read a net of another tool; what is read can be written in every format, and read again."""
    work = folder / "work"
    path = work / "case.pnml"

    def attempt(content: bytes) -> Outcome:
        shutil.rmtree(work, ignore_errors=True)
        work.mkdir()
        path.write_bytes(content)
        output = work / f"out.{('xmi', 'pnml', 'net')[zlib.crc32(content) % 3]}"
        questions: list[list[object]] = [
            ["convert", path, "-o", output],
            ["convert", path, "-o", output],
            ["validate", path, "--json"],
            ["find", path, "--marking", "Done >= 1", "--memory", "600M", "--timeout", "5"],
        ]
        outcome = run_command(*questions[zlib.crc32(content[::-1]) % len(questions)])
        if outcome.status == REFUSED and output.exists():
            return Outcome(-1, f"is refused, but there is {output.name}: {outcome.said}")
        if output.exists():
            again = run_command("validate", output)
            if again.status == REFUSED:
                return Outcome(-1, f"writes what it does not read: {again.said}")
        return outcome

    return FILES, attempt


def symmetric_pnml(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Read a coloured net, which is unfolded."""
    path, output = folder / "case.pnml", folder / "out.net"

    def attempt(content: bytes) -> Outcome:
        path.write_bytes(content)
        output.unlink(missing_ok=True)
        questions: list[list[object]] = [
            ["convert", path, "-o", output],
            ["validate", path],
            ["statespace", path, "--no-cache", "--memory", "600M", "--timeout", "5"],
        ]
        return run_command(*questions[zlib.crc32(content) % len(questions)])

    return [random_net(seed).pnml().encode() for seed in range(8)], attempt


COMPARISONS = ("le", "ge", "lt", "gt", "eq", "ne")


def foreign_properties(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Ask a property file of another tool."""
    path, model = folder / "case.xml", folder / "net.net"
    model.write_text("net n\npl a (2)\ntr t a -> b\ntr u b -> a\n")
    atoms = "".join(
        f"<integer-{name}><tokens-count><place>{place}</place></tokens-count>"
        f"<integer-constant>1</integer-constant></integer-{name}>"
        for name, place in zip(COMPARISONS, "abbaab", strict=True)
    )
    ways = "<exists-path><finally>{}</finally></exists-path>"
    formulas = [
        ways.format(f"<conjunction>{atoms}</conjunction>"),
        f"<all-paths><globally><disjunction>{atoms}</disjunction></globally></all-paths>",
        ways.format("<deadlock/>"),
        ways.format("<is-fireable><transition>t</transition></is-fireable>"),
    ]
    originals = _asked(formulas)

    def attempt(content: bytes) -> Outcome:
        path.write_bytes(content)
        return run_command("verify", model, "--properties", path, "--timeout", "0.5", "--memory", "600M")

    return originals, attempt


def symmetric_properties(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Ask a property file about a coloured net: its places and transitions stand for all their colours."""
    path, model = folder / "case.xml", folder / "net.pnml"
    net = random_net(3)
    model.write_bytes(net.pnml().encode())
    place, transition = next(iter(net.places)), next(iter(net.conditions))
    count = f"<tokens-count><place>{place}</place></tokens-count>"
    atom = f"<integer-le><integer-constant>1</integer-constant>{count}</integer-le>"
    fireable = f"<is-fireable><transition>{transition}</transition></is-fireable>"
    originals = _asked(
        [
            f"<exists-path><finally><conjunction>{atom}{fireable}</conjunction></finally></exists-path>",
            f"<all-paths><globally><disjunction>{atom}{fireable}</disjunction></globally></all-paths>",
            f"<place-bound><place>{place}</place></place-bound>",
        ]
    )

    def attempt(content: bytes) -> Outcome:
        path.write_bytes(content)
        return run_command("verify", model, "--properties", path, "--timeout", "0.5", "--memory", "600M")

    return originals, attempt


def _asked(formulas: Sequence[str]) -> list[bytes]:
    """Return property files with one formula each, in the name spaces of several tools."""
    spaces = ("http://mcc.lip6.fr/", "http://tapaal.net/", "")
    return [
        f'<property-set xmlns="{space}"><property><id>q{number}</id><description/>'
        f"<formula>{formula}</formula></property></property-set>".replace(' xmlns=""', "").encode()
        for space in spaces
        for number, formula in enumerate(formulas)
    ]
