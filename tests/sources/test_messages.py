"""Fields of messages and responses with certain truth values: what is tested, published and answered."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.sources.support import node_of

MADE = """
def __init__(self):
    super().__init__("robot")
    self.pub = self.create_publisher(Bool, "out", 1)
    self.create_subscription(Bool, "in", self.on_in, 1)
    self.create_service(Trigger, "ask", self.serve)
"""
IMPORTS = "from std_msgs.msg import Bool\nimport std_msgs.msg\nimport contextlib\n"
PUBLISHES = "self.pub.publish(Bool())"
MAKES = "m = Bool()\nm.data = True\n"


def read(folder: Path, received: str = "pass", served: str = "return response", more: str = "") -> Any:
    """Return the effects of a subscription's callback, and the certain answers of a service."""
    body = MADE
    for name, parameters, text in (("on_in", "msg", received), ("serve", "request, response", served)):
        lines = "\n".join(f"    {line}" for line in text.strip().splitlines())
        body += f"\ndef {name}(self, {parameters}):\n{lines}\n"
    callbacks = {each["name"]: each for each in node_of(folder, body + more, before=IMPORTS)["callbacks"]}
    effects = [each for each in callbacks["on_in"]["effects"] if each["do"] == "publish"]
    return effects, callbacks["serve"].get("answers", {})


def given(folder: Path, received: str, more: str = "") -> list[dict[str, bool]]:
    """Return the known fields of the received message for each publication."""
    return [each.get("if", {}) for each in read(folder, received, more=more)[0]]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (f"if msg.data:\n    {PUBLISHES}\nelse:\n    {PUBLISHES}", [{"data": True}, {"data": False}]),
        (f"if not msg.data:\n    return\n{PUBLISHES}", [{"data": True}]),
        (f"if msg.data and self.x:\n    {PUBLISHES}\nelse:\n    {PUBLISHES}", [{"data": True}, {}]),
        (f"if self.x or not msg.data:\n    {PUBLISHES}\nelse:\n    {PUBLISHES}", [{}, {"data": True}]),
        (f"if msg.data:\n    self.x = 1\n{PUBLISHES}", [{}]),
        (f"if msg.data:\n    if self.x:\n        return\n    {PUBLISHES}\n{PUBLISHES}", [{"data": True}, {}]),
        (f"for each in self.many:\n    if msg.data:\n        continue\n    {PUBLISHES}", [{"data": False}]),
        ("if msg.data:\n    self.tell()\nself.tell()", [{"data": True}, {}]),
    ],
)
def test_an_effect_has_the_tests_that_lead_to_it(
    tmp_path: Path, text: str, expected: list[dict[str, bool]]
) -> None:
    assert given(tmp_path, text, f"\ndef tell(self):\n    {PUBLISHES}\n") == expected


@pytest.mark.parametrize(
    "before",
    [
        "msg = self.other",
        "msg.data = not msg.data",
        "msg._data = False",
        "other = msg",
        "self.last = msg",
        "change(msg)",
        "setattr(msg, 'data', False)",
        "del msg.data",
        "for msg in self.many: pass",
        "[msg for msg in self.many]",
        "with self.lock as msg: pass",
        "import os as msg",
        "def change():\n    nonlocal msg\n    msg = None",
        "change = lambda: msg",
        "locals()['msg'] = 1",
        "try:\n    pass\nexcept Exception as msg:\n    pass",
    ],
)
def test_a_message_that_may_be_another_one_decides_nothing(tmp_path: Path, before: str) -> None:
    assert given(tmp_path, f"{before}\nif msg.data:\n    {PUBLISHES}") == [{}]
    assert given(tmp_path, f"if msg.data:\n    {PUBLISHES}\n{before}") == [{}]


def test_a_message_of_another_caller_decides_nothing(tmp_path: Path) -> None:
    assert given(tmp_path, f"if msg.data:\n    {PUBLISHES}\nself.on_in(Bool())") in (
        [{}],
        [{"data": True}, {}],
    )
    assert given(
        tmp_path, "self.use(self.other)", f"\ndef use(self, msg):\n    if msg.data:\n        {PUBLISHES}\n"
    ) == [{}]
    assert given(
        tmp_path, "self.use(msg)", f"\ndef use(self, msg):\n    if msg.data:\n        {PUBLISHES}\n"
    ) == [{}]


def test_an_error_that_a_context_may_catch_leaves_nothing_known(tmp_path: Path) -> None:
    text = f"with self.guard():\n    if msg.data:\n        raise ValueError\n{PUBLISHES}"
    assert given(tmp_path, text) == [{}]


def sends(folder: Path, text: str) -> list[dict[str, bool]]:
    """Return the certain fields of each published message."""
    return [each.get("sends", {}) for each in read(folder, text)[0]]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("self.pub.publish(Bool(data=True))", [{"data": True}]),
        ("self.pub.publish(std_msgs.msg.Bool(data=False))", [{"data": False}]),
        (f"{MAKES}self.pub.publish(m)", [{"data": True}]),
        ("m = Bool(data=True)\nm.data = False\nself.pub.publish(m)", [{"data": False}]),
        ("m = Bool(data=True)\nm.data = self.x\nself.pub.publish(m)", [{}]),
        ("for m in self.many:\n    self.pub.publish(m)", [{}]),
        (
            f"while self.x:\n    {MAKES.replace(chr(10), chr(10) + '    ')}self.pub.publish(m)",
            [{"data": True}],
        ),
        ("self.pub.publish(Bool(data=self.x))", [{}]),
        ("self.pub.publish(Bool(**self.x))", [{}]),
        ("self.pub.publish(self.make(data=True))", [{}]),
        ("self.pub.publish(make(data=True))", [{}]),
        ("self.pub.publish(msg)", [{}]),
        ("self.pub.publish(Bool(data=True)); self.pub.publish(Bool(data=False))", [{}]),
    ],
)
def test_a_published_message_has_the_fields_that_are_certain(
    tmp_path: Path, text: str, expected: list[dict[str, bool]]
) -> None:
    assert sends(tmp_path, text) == expected


@pytest.mark.parametrize(
    "between",
    [
        "if self.x:\n    m.data = False",
        "if self.x:\n    m = self.other",
        "m = self.other",
        "other = m\nother.data = False",
        "change(m)",
        "m._data = False",
        "m.data, self.x = False, 1",
        "m.data &= self.x",
        "for m.data in (True, False): pass",
        "def change():\n    m.data = False\nchange()",
        "def change():\n    nonlocal m\n    m = None\nchange()",
        "setattr(m, 'data', False)",
        "vars()['m'].data = False",
    ],
)
def test_a_message_that_may_change_is_open(tmp_path: Path, between: str) -> None:
    assert sends(tmp_path, f"{MAKES}{between}\nself.pub.publish(m)") == [{}]


def test_a_message_that_is_made_elsewhere_is_open(tmp_path: Path) -> None:
    assert sends(tmp_path, f"{MAKES}if self.x:\n    self.pub.publish(m)") == [{}]
    assert sends(tmp_path, f"{MAKES}self.pub.publish(m)\nm.data = False\nself.pub.publish(m)") == [{}, {}]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("response.success = True\nreturn response", {"success": True}),
        ("response.success = False\nresponse.message = 'no'\nreturn response", {"success": False}),
        ("response.success = True\nif self.x:\n    return response\nreturn response", {"success": True}),
        ("if self.x:\n    return response\nresponse.success = True\nreturn response", {}),
        ("if self.x:\n    response.success = True\nreturn response", {}),
        ("response.success = True\nif self.x:\n    response.success = False\nreturn response", {}),
        ("response.success = True\nresponse = self.other\nreturn response", {}),
        ("response.success = True\nreturn self.other", {}),
        ("response.success = True\nchange(response)\nreturn response", {}),
        ("response.success = True\nresponse._success = False\nreturn response", {}),
        ("response.success = True\nother = response\nother.success = False\nreturn response", {}),
        ("response.success = self.x\nreturn response", {}),
        ("response.success = True", {}),
        ("request.data = True\nreturn request", {}),
    ],
)
def test_answers_have_the_fields_that_each_run_assigns(
    tmp_path: Path, text: str, expected: dict[str, bool]
) -> None:
    assert read(tmp_path, served=text)[1] == expected
