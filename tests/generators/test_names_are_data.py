"""Whatever a model's texts hold, they are text in what is generated: no code, no tag, no other line."""

from __future__ import annotations

import ast
import configparser
import contextlib
import io
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import markdown  # type: ignore[import-untyped]
import pytest
import yaml  # type: ignore[import-untyped]
from hypothesis import given, settings
from hypothesis import strategies as st
from lxml import etree
from rosidl_adapter.msg import convert_msg_to_idl  # type: ignore[import-not-found]
from rosidl_adapter.parser import parse_message_string, parse_service_string  # type: ignore[import-not-found]
from rosidl_parser.definition import IdlLocator  # type: ignore[import-not-found]
from rosidl_parser.parser import parse_idl_file  # type: ignore[import-not-found]

from dineros.generators import Options
from dineros.generators.workspace import plan
from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject, features_of
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import find
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files import load, save
from tests.generators.models import kitchen

EVIL = (
    'x"""\nopen("MARK", "w")\n"""\r\'\'\'\nimport evil\n\'\'\' \\" \\\' \\x \\N{x} \\u12 # */ /* --> --- <!-- ]]>'
    " & <b>tag</b> `| $(evil) ${EVIL} %(prog)s {{ 7 * 7 }} {% raw %} coding: utf-7 \t\x85\u2028\u202e\u200b é 🤖 : - \\"
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
    news = sym.Place(id="News", page=find(model, "board", sym.NodeNet))
    sym.TopicChannel(
        id="Today",
        topic="/today",
        type="std_msgs/msg/String",
        model=model,
        publishers=[sym.PublisherPort(place=news)],
        subscribers=[sym.SubscriberPort(place=find(model, "Dish", sym.Place))],
        mappings=[sym.FieldMapping(messageField="data", tokenField="dish")],
    )
    find(model, "board", sym.NodeNet).groups.append(sym.CallbackGroup(id="Group"))
    return model


def elements(model: EObject) -> Iterator[EObject]:
    yield model
    yield from model.eAllContents()


def texts() -> list[tuple[str, str]]:
    """Return every attribute of the metamodel that holds a text, as a class in the model has it."""
    found = {
        (type(element).__name__, name): None
        for element in elements(rich())
        for name, feature in features_of(type(element)).items()
        if getattr(feature.eType, "name", "") == "EString" and hasattr(feature, "iD")
    }
    return list(found)


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
    """Return all files; None where the model is refused, in one line that says how to mend it."""
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


class Shape(ast.NodeTransformer):
    """Forgets all texts and all names but those of what is called or imported."""

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        return ast.Constant("" if isinstance(node.value, str) else node.value)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.name = ""
        return self.generic_visit(node)

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        node.name = ""
        return self.generic_visit(node)


MADE_OF_NAMES = re.compile(r"\b(OddOne|odd_one|[xX][a-zA-Z0-9_]*?)(?=Firing|Inputs|Outputs|Changes|_|\b)")


def shape(content: bytes) -> str:
    """Return the syntax tree of a module, texts and names of the model masked."""
    tree = ast.parse(content)
    assert not [node for node in ast.walk(tree) if isinstance(node, (ast.Name, ast.alias)) and "evil" in ast.dump(node)]
    calls = sorted(
        ast.unparse(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call) and not is_token(node)
    )
    nodes = re.sub(r"'[^']*'", "''", ast.dump(Shape().visit(tree)))
    return f"{nodes}\n{calls}"


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
    suffix = path.rpartition(".")[2]
    text = content.decode()
    match suffix:
        case "py":
            return shape(content)
        case "xml" | "xmi":
            root = etree.fromstring(content)
            return [(node.tag, sorted(node.keys())) for node in root.iter()]
        case "yaml":
            values = yaml.load(text, Strict)["/**"]["ros__parameters"]  # noqa: S506  (a safe loader)
            return {key: len(value) if isinstance(value, dict) else value for key, value in values.items()}
        case "msg":
            message = parse_message_string("p", "M", text)
            return [(str(field.type), str(field.default_value)) for field in message.fields]
        case "srv":
            return len(parse_service_string("p", "S", text).request.fields)
        case "cfg":
            parser = configparser.ConfigParser()
            parser.read_string(text)
            return parser.sections()
        case "txt":
            return len(without_comments(content))
        case "md":
            html = markdown.markdown(text, extensions=["tables"])
            assert "<b>" not in html
            return len(text.splitlines())
        case _:
            return without_comments(content)


def files_by_role(files: dict[str, bytes]) -> list[tuple[str, object]]:
    """Return what files hold, in their order: their names may come from the model."""
    return [(path.rpartition(".")[2], outline(path, content)) for path, content in files.items()]


def same(model: sym.SystemModel, kind: str, name: str) -> bool:
    """Tell whether a model is accepted; then what it gives differs from that of a harmless one in its texts only."""
    found = accepted(model)
    if found is None:
        return False
    harmless = accepted(changed(kind, name, HARMLESS)) or generated(rich())
    assert files_by_role(found) == files_by_role(harmless)
    return True


FREE = {("SystemModel", "name"), ("Place", "name"), ("CallbackPage", "name"), ("ClientPort", "client")}


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
    assert len(texts()) > 40
