"""Whatever a model's texts hold, they are text in what is generated: no code, no tag, no other line."""

from __future__ import annotations

import ast
import configparser
import contextlib
import io
import json
import re
import subprocess
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml  # type: ignore[import-untyped]
from hypothesis import given, settings
from hypothesis import strategies as st
from lxml import etree
from markdown_it import MarkdownIt
from pyecore.ecore import EAttribute
from rosidl_adapter.parser import (  # type: ignore[import-untyped]
    parse_action_string,
    parse_message_string,
    parse_service_string,
)

from dineros.generators import Options
from dineros.generators.workspace.planning import plan
from dineros.metamodel import pn, sym
from dineros.metamodel.base import EnumLiteral, EObject, features_of
from dineros.metamodel.build import suppress
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import find
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files import load, save
from tests.generators.models import kitchen
from tests.support.ros2_systems.deliveries import deliveries

EVIL = (
    'x"""\nopen("MARK", "w")\n"""\r'
    "'''\nimport evil\n''' \\\" \\' \\x \\N{x} \\u12 # */ /* --> --- <!-- ]]> & <b>tag</b> "
    "`| $(evil) ${EVIL} %(prog)s {{ 7 * 7 }} {% raw %} coding: utf-7 \t\x85\u2028\u202e\u200b é 🤖 : - \\"
)
ODD = "-x(evil)[0].__import__,*/#[[a]]=--%s@!?~^+:coding=utf-7--"
"""What an id may hold."""
HARMLESS = "odd-one"


def rich() -> sym.SystemModel:
    """Return a model with every kind of text, the layout and foreign parts included."""
    model = kitchen()
    place = find(model, "Hungry", sym.Place)
    place.name = "Guests"
    place.graphics = pn.Graphics(positions=[pn.Point(x=1, y=2)], style="<fill/>")
    place.toolInfos.append(pn.ToolInfo(tool="other", version="1", content="<a/>"))
    place.labels.append(pn.Label(kind="elementName"))
    suppress(place, "unbounded", "guests come and go", until="2999-12-31")
    news = sym.Place(id="News", page=find(model, "board", sym.NodeNet))
    sym.TopicChannel(
        id="Today",
        topic="/today",
        type="std_msgs/msg/String",
        latency=pn.TimeInterval(latest=0.1, source="recordings"),
        model=model,
        publishers=[sym.PublisherPort(place=news)],
        subscribers=[sym.SubscriberPort(place=find(model, "Dish", sym.Place))],
        mappings=[sym.FieldMapping(messageField="data", tokenField="dish")],
    )
    kitchen_page = find(model, "Kitchen", sym.CallbackPage)
    pn.ReferenceTransition(id="TCook@Kitchen", target=find(model, "TCook", pn.Transition), page=kitchen_page)
    find(model, "board", sym.NodeNet).objects.append(pn.Page(id="Empty"))
    find(model, "board", sym.NodeNet).callbackGroups.append(sym.CallbackGroup(id="Group"))
    model.properties.append(sym.Property(id="Fed", name="All eat", text="Served >= 2 stays possible"))
    model.assumptions.append(sym.Fairness(id="Fair", of="all"))
    model.assumptions.append(sym.SourceAssumption(id="Lacks", text="not read: kitchen.py"))
    signals = [sym.InputSignal(id=id, name=id) for id in ("Lit", "Dark")]
    find(model, "board", sym.NodeNet).signals.extend(signals)
    model.assumptions.append(sym.ExclusiveSignals(id="Apart", signals=signals))
    values = [sym.SignalValue(name=name) for name in ("idle", "busy")]
    find(model, "board", sym.NodeNet).signals.append(sym.InputSignal(id="Mode", start="idle", values=values))
    model.middleware = "ros2"
    outside = deliveries()
    model.pages.extend(list(outside.pages))
    model.channels.extend(list(outside.channels))
    return model


def is_text(feature: Any) -> bool:
    return isinstance(feature, EAttribute) and feature.eType.name == "EString"


def elements(model: EObject) -> Iterator[EObject]:
    yield model
    yield from model.eAllContents()


def texts() -> list[tuple[str, str]]:
    """Return every attribute of the metamodel that holds a text, as a class in the model has it."""
    found = {
        (type(element).__name__, name): None
        for element in elements(rich())
        for name, feature in features_of(type(element)).items()
        if is_text(feature)
    }
    return sorted(found)


def changed(kind: str, name: str, text: str) -> sym.SystemModel:
    model = rich()
    element = next(each for each in elements(model) if type(each).__name__ == kind)
    setattr(element, name, text)
    return model


def generated(model: sym.SystemModel, source: str = "a.sym.xmi", *settings: str) -> dict[str, bytes]:
    """Return all files, none of which is written."""
    made = plan(model, Path("nowhere"), Options(source=source, settings=settings), None)
    return {**made.generated, **{path: file.content for path, file in made.developer.items()}}


def accepted(model: sym.SystemModel) -> dict[str, bytes] | None:
    """Return all files; None where the model is refused, in one line that says how to fix it."""
    wrong = [violation for violation in validate(model) if violation.severity == "error"]
    if wrong:
        assert "\n" not in str(wrong[0])
        assert wrong[0].fix
        return None
    try:
        return generated(model)
    except DinerosError as error:
        assert "\n" not in str(error)
        assert error.hint
        return None


def shape(content: bytes) -> tuple[str, list[str]]:
    """Return the syntax tree of a module, with all texts and names masked, and what is called in it."""
    tree = ast.parse(content)
    calls = [node.func for node in ast.walk(tree) if isinstance(node, ast.Call) and not is_token(node)]
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            node.value = ""
    return re.sub("'[^']*'", "''", ast.dump(tree)), sorted(map(ast.unparse, calls))


def is_token(call: ast.Call) -> bool:
    """Tell whether a call is that of the function that makes tokens, which is called like their type."""
    return isinstance(call.func, ast.Attribute) and ast.unparse(call.func.value) == "tokens"


class Strict(yaml.SafeLoader):  # type: ignore[misc]
    """Refuses a key that stands twice."""

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
        keys = [self.construct_object(key) for key, _ in node.value]
        assert len(set(keys)) == len(keys), keys
        return dict(super().construct_mapping(node, deep))


def without_comments(content: bytes) -> list[str]:
    return [line for line in content.decode().splitlines() if line and not line.startswith("#")]


def outline(path: str, content: bytes) -> object:
    """Parse a file; return what must not depend on the texts of the model."""
    text = content.decode()
    match Path(path).suffix.removeprefix("."):
        case "py":
            return shape(content)
        case "xml" | "xmi":
            root = etree.fromstring(content)
            return [(node.tag, sorted(node.keys())) for node in root.iter()]
        case "yaml":
            values = yaml.load(text, Strict)["/**"]["ros__parameters"]
            return {key: len(value) if isinstance(value, dict) else value for key, value in values.items()}
        case "msg":
            message = parse_message_string("p", "M", text)
            return [(str(field.type), str(field.default_value)) for field in message.fields]
        case "srv":
            return len(parse_service_string("p", "S", text).request.fields)
        case "action":
            action = parse_action_string("p", "A", text)
            return [len(part.fields) for part in (action.goal, action.result, action.feedback)]
        case "cfg":
            parser = configparser.ConfigParser()
            parser.read_string(text)
            return parser.sections()
        case "txt":
            return len(without_comments(content))
        case "md":
            tokens = MarkdownIt().enable("table").parse(text)
            inner = [child.type for token in tokens for child in token.children or () if child.type != "text"]
            return [token.type for token in tokens], inner
        case _:
            return without_comments(content)


def files_by_role(files: dict[str, bytes]) -> list[tuple[str, object]]:
    """Return what files hold, in their order: their names may come from the model."""
    return [(Path(path).suffix, outline(path, content)) for path, content in files.items()]


def same(model: sym.SystemModel, kind: str, name: str) -> bool:
    """Tell whether a model is accepted; what is generated then differs from the harmless in texts only."""
    found = accepted(model)
    if found is None:
        return False
    harmless = accepted(changed(kind, name, HARMLESS)) or generated(rich())
    assert files_by_role(found) == files_by_role(harmless)
    return True


FREE = {("SystemModel", "name"), ("Place", "name"), ("CallbackPage", "name"), ("ClientPort", "client")}


@pytest.mark.long
@pytest.mark.parametrize(("kind", "name"), texts())
def test_a_hostile_text_anywhere_is_text_or_refused(kind: str, name: str, tmp_path: Path) -> None:
    is_accepted = same(changed(kind, name, EVIL), kind, name)
    same(changed(kind, name, ODD), kind, name)
    assert is_accepted or (kind, name) not in FREE
    for suffix in ("sym.xmi", "pnml"):
        path = tmp_path / f"model.{suffix}"
        with contextlib.suppress(DinerosError):  # what a format does not carry, it refuses
            save(changed(kind, name, EVIL), path)
            read = load(path)
            assert isinstance(read, sym.SystemModel)
            same(read, kind, name)


def test_every_attribute_of_the_metamodel_is_tried() -> None:
    classes = [each for module in (pn, sym) for each in vars(module).values() if isinstance(each, type)]
    known = {
        (each.__name__, name)
        for each in classes
        if issubclass(each, EObject)
        and not issubclass(each, (EnumLiteral, pn.Net))
        and not each.eClass.abstract
        for name, feature in features_of(each).items()
        if is_text(feature)
    }
    assert known <= set(texts())
    assert len(known) > 40


def value_of(tree: ast.AST, keyword: str) -> object:
    """Return the text of a keyword of a call."""
    return next(
        ast.literal_eval(node.value)
        for node in ast.walk(tree)
        if isinstance(node, ast.keyword) and node.arg == keyword
    )


def test_a_hostile_timer_is_text() -> None:
    def ticking(id: str) -> dict[str, bytes]:
        model, begin = rich(), sym.Transition(id=f"{id}2")
        page = sym.CallbackPage(id=id, kind="timer", timer=0.5, objects=[begin])
        find(model, "board", sym.NodeNet).objects.append(page)
        found = accepted(model)
        assert found is not None
        return found

    assert files_by_role(ticking(ODD)) == files_by_role(ticking(HARMLESS))


@pytest.mark.long
@settings(max_examples=40, deadline=None)
@given(
    st.just(EVIL)
    | st.text(st.characters(exclude_categories=["Cs", "Cc"]) | st.sampled_from("\n\t\"'\\"), min_size=1)
)
def test_a_name_arrives_unchanged_where_it_is_shown(name: str) -> None:
    model = kitchen()
    model.name = name
    files = accepted(model)
    if files is None:  # a character that XML has no place for
        return
    package = "src/kitchen_bringup/kitchen_bringup"
    docstring = ast.get_docstring(ast.parse(files[f"{package}/__init__.py"]), clean=False)
    assert docstring == f"Starts the nodes of {name}."
    description = etree.fromstring(files["src/kitchen_bringup/package.xml"]).findtext("description")
    assert description == f"Starts the nodes of {name}."
    setup = ast.parse(files["src/kitchen_bringup/setup.py"])
    assert value_of(setup, "description") == f"Starts the nodes of {' '.join(name.split())}"
    readme = MarkdownIt().parse(files["src/kitchen_bringup/README.md"].decode())
    shown = next(token for token in readme if token.type == "inline" and token.content.startswith("Starts"))
    text = "".join(child.content for child in shown.children or [])
    assert text == f"Starts the 3 nodes of {visible(name)}."


def visible(text: str) -> str:
    return "".join(each if each.isprintable() else f"<U+{ord(each):04X}>" for each in text)


SOURCES = [
    "a---b.sym.xmi",
    "a\nimport evil\n.sym.xmi",
    f"{EVIL} */ [m].sym.xmi",
    "coding=utf-7 .sym.xmi",
    "\udcff-\x00.sym.xmi",
]


@pytest.mark.long
@pytest.mark.parametrize("source", SOURCES, ids=range(len(SOURCES)))
def test_names_of_files_and_settings_are_text(source: str) -> None:
    settings = (f"{source}=---", "x.y=---")
    found, usual = generated(rich(), source, *settings), generated(rich(), "a.sym.xmi", "x=y", "x=y")
    assert files_by_role(found) == files_by_role(usual)
    bases = {path for path in found if path.endswith("/base.py")}
    assert {path for path in found if found[path] != usual[path]} == bases  # traces name the settings
    for path, content in found.items():
        if path.endswith(".py"):
            assert tokenize.detect_encoding(io.BytesIO(content).readline)[0] == "utf-8"
    base = ast.parse(found["src/waiter/waiter/base.py"])
    (given_settings,) = [
        node.value
        for node in base.body
        if isinstance(node, ast.AnnAssign) and ast.unparse(node.target) == "SETTINGS"
    ]
    assert given_settings is not None
    assert ast.literal_eval(given_settings) == list(settings)


# In a process of its own, since empy keeps the standard output that it finds.
TO_C = """
import json, pathlib, sys
from rosidl_adapter.msg import convert_msg_to_idl
from rosidl_parser.definition import IdlLocator, Message
from rosidl_parser.parser import parse_idl_file
here, found = pathlib.Path.cwd(), []
for name in sys.argv[1:]:
    made = convert_msg_to_idl(here, "kitchen_interfaces", pathlib.Path(name), here)
    idl = parse_idl_file(IdlLocator(here, made.relative_to(here)))
    (message,) = idl.content.get_elements_of_type(Message)
    structure = message.structure
    found.append([structure.get_comment_lines(), [member.name for member in structure.members]])
print(json.dumps(found))
"""


def test_comments_of_interfaces_stay_comments_in_c(tmp_path: Path) -> None:
    def message_of(model: sym.SystemModel) -> bytes:
        model.id += ODD
        (message,) = [content for path, content in generated(model).items() if path.endswith("/Meal.msg")]
        return message

    texts = SOURCES[:-1]  # the last one cannot stand in a file
    names = [f"Meal{number}.msg" for number in range(len(texts))]
    for name, text in zip(names, texts, strict=True):
        model = kitchen()
        model.name = f"{EVIL}{text}"
        (tmp_path / name).write_bytes(message_of(model))
    done = subprocess.run(
        [sys.executable, "-c", TO_C, *names], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    for lines, members in json.loads(done.stdout.splitlines()[-1]):
        assert "Generated by DiNeROS" in lines[0]
        assert members[:2] == ["dish", "table"]
        for line in lines:
            assert line.isprintable()
            assert "*/" not in line
            assert "\\" not in line  # at the end of a line, it would take the next one into the comment


def test_defaults_arrive_in_interfaces() -> None:
    for default in ('"a, b"', '"a]"', '""', '"[x]"', '"a\\"b"', '"#"', '"ä"', '" "', '"\'"', '"=", "b"'):
        model = kitchen()
        assert model.tokenType is not None
        model.tokenType.fields[0].default = default
        files = accepted(model)
        if files is not None:
            message = parse_message_string("p", "M", files["src/kitchen_interfaces/msg/Meal.msg"].decode())
            assert message.fields[0].default_value in (json.loads(default), None)
