"""Fields of responses decide about branches of clients, as far as the reader is certain."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.metamodel import sym
from dineros.metamodel.elements import places, transitions
from dineros.metamodel.files import save
from dineros.observation.importing.building import to_model
from dineros.observation.importing.coded import Coded, coded
from dineros.observation.importing.correcting import merged
from dineros.observation.importing.flows.labels import Step
from dineros.observation.importing.given import Given, GivenCallback, GivenNode
from dineros.observation.systems import Endpoint, ObservedNode
from dineros.sources.reading import read_source
from tests.support.programs.coded import run

HEAD = """
import random
import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Empty
from std_srvs.srv import SetBool, Trigger
"""
TAIL = """
if __name__ == "__main__":
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=3)
    executor.add_node(Made())
    executor.spin()
"""
SERVER = """
class Made(Node):
    def __init__(self):
        super().__init__("{name}")
        self.b = self.create_publisher(Empty, "served", 1)
        self.a = self.create_publisher(Empty, "asked", 1)
        self.create_service(Trigger, "dock", self.serve)

    def serve(self, request, response):
{body}
"""
CLIENT = """
class Made(Node):
    def __init__(self):
        super().__init__("client")
        self.dock = self.create_client(Trigger, "dock", callback_group=ReentrantCallbackGroup())
        self.a = self.create_publisher(Empty, "docked", 1)
        self.b = self.create_publisher(Empty, "alarm", 1)
        self.create_timer(1.0, self.tick)

"""
CALLS = """
    def tick(self):
        response = self.dock.call(Trigger.Request())
        if response.success:
            self.a.publish(Empty())
        else:
            self.b.publish(Empty())
"""
ASKS = """
    def tick(self):
        if self.dock.call(Trigger.Request()).success:
            self.a.publish(Empty())
        else:
            self.b.publish(Empty())
"""
AWAITS = CALLS.replace("def", "async def").replace("self.dock.call(", "await self.dock.call_async(")
DONE = """
    def tick(self):
        self.dock.call_async(Trigger.Request()).add_done_callback(self.done)

    def done(self, future):
        response = future.result()
        if response.success:
            self.a.publish(Empty())
        else:
            self.b.publish(Empty())
"""
DONE_AT_ONCE = DONE.replace("        response = future.result()\n", "").replace(
    "response.", "future.result()."
)
FORMS = {"calls": CALLS, "asks": ASKS, "awaits": AWAITS, "done": DONE, "done_at_once": DONE_AT_ONCE}
TRUE = "        response.success = True\n        return response"
FALSE = TRUE.replace("True", "False")
EITHER = """        if random.random() < 0.5:
            response.success = True
            self.a.publish(Empty())
        else:
            response.success = False
            self.b.publish(Empty())
        return response"""


def read(folder: Path, server: str = TRUE, client: str = CALLS, **more: str) -> Coded:
    """Return what the programs say."""
    files = {"server": SERVER.format(name="server", body=server), "client": CLIENT + client, **more}
    for name, text in files.items():
        (folder / f"{name}.py").write_text(HEAD + text + TAIL)
    return coded([("", read_source(folder))], "code")


def model_of(code: Coded, said: Given | None = None) -> sym.SystemModel:
    return to_model(code.system, merged(code.given, said or Given())).model


def guards(model: sym.SystemModel) -> list[str]:
    return [each.guard for each in transitions(model) if isinstance(each, sym.Transition) and each.guard]


def published(model: sym.SystemModel, name: str) -> list[str]:
    """Return the transitions that publish on a topic."""
    found = [str(each.id) for each in transitions(model)]
    return [each for each in found if each.partition("_2")[0].endswith(f".publishes_{name}")]


def ask(folder: Path, model: sym.SystemModel, formula: str) -> bool:
    path = folder / "model.sym.xmi"
    save(model, path)
    _, text = run("verify", "-q", path, "--ltl", formula)
    assert text.startswith(("holds", "violated")), text
    return str(text).startswith("holds")


def fired(folder: Path, model: sym.SystemModel) -> set[str]:
    """Return what the client publishes in some run."""
    names = {name: published(model, name) for name in ("docked", "alarm")}
    assert all(len(each) == 1 for each in names.values())
    return {name for name, (id,) in names.items() if not ask(folder, model, f'G !fired("{id}")')}


# ------------------------------------------------------------------------------------------------ end to end


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    ("server", "expected"), [(TRUE, {"docked"}), (FALSE, {"alarm"}), (EITHER, {"docked", "alarm"})]
)
def test_the_answer_decides(tmp_path: Path, form: str, server: str, expected: set[str]) -> None:
    model = model_of(read(tmp_path, server, FORMS[form]))
    assert fired(tmp_path, model) == expected
    assert len(guards(model)) == 2
    (channel,) = [each for each in model.channels if isinstance(each, sym.ServiceChannel)]
    assert channel.type is None
    typed = [each.tokenType for each in places(model) if isinstance(each, sym.Place) and each.tokenType]
    assert {tuple((field.name, str(field.kind)) for field in each.fields) for each in typed} == {
        (("success", "boolean"),)
    }


@pytest.mark.parametrize("form", FORMS)
def test_what_the_server_did_and_what_the_client_does_belong_together(tmp_path: Path, form: str) -> None:
    model = model_of(read(tmp_path, EITHER, FORMS[form]))
    for sent, done, other in (("asked", "docked", "alarm"), ("served", "alarm", "docked")):
        (before,), (after,), (wrong,) = (published(model, each) for each in (sent, done, other))
        assert not ask(tmp_path, model, f'G !fired("{after}")')
        assert not ask(tmp_path, model, f'(!fired("{wrong}")) U fired("{before}")')
        assert ask(tmp_path, model, f'!((!fired("{before}")) U fired("{after}"))')


def test_a_flag_decides_about_the_answer(tmp_path: Path) -> None:
    flag = 'self.is_ready = False\n        self.create_subscription(Empty, "go", self.go, 1)'
    body = "        response.success = self.is_ready\n        return response"
    server = SERVER.replace("self.a =", f"{flag}\n        self.a =").format(name="server", body=body)
    read(tmp_path)
    (tmp_path / "server.py").write_text(
        f"{HEAD}{server}\n    def go(self, message):\n        self.is_ready = True\n{TAIL}"
    )
    model = model_of(coded([("", read_source(tmp_path))], "code"))
    (docked,) = published(model, "docked")
    assert not ask(tmp_path, model, f'G !fired("{docked}")')
    assert ask(tmp_path, model, f'!((!fired("server.on_go.begins")) U fired("{docked}"))')


# ------------------------------------------------------------------------------------------ what stays open


RETURNS = "return response"
OPEN_SERVERS = [
    ("response.success = random.random() < 0.5", RETURNS),
    (RETURNS,),
    (
        "response.success = True",
        "if random.random() < 0.5: return response",
        "response.success = self.x",
        RETURNS,
    ),
    ("response.success = True", "other = response", "other.success = False", RETURNS),
    ("response.success = True", "random.shuffle(response)", RETURNS),
    ("response.success = True", "response.success &= self.x", RETURNS),
    ("response.success = True", "response.success, x = self.x", RETURNS),
    ("response.success = True", "for response.success in self.x: pass", RETURNS),
    ("response.success = True", "setattr(response, 'success', False)", RETURNS),
    ("response.success = True", "def change(): response.success = False", "change()", RETURNS),
    ("response.success = True", "vars()['response'].success = False", RETURNS),
    ("response.success = True", "response = self.x", RETURNS),
    ("response.success = True", "return self.x"),
    ("response.success = x = True", RETURNS),
    (
        "response.success = True",
        *("try: self.x()", "except* ValueError: response.success = False", RETURNS),
    ),
    (
        "response.success = True",
        *("match self.x:", "    case 1: response.success = False", RETURNS),
    ),
    (
        'if self.declare_parameter("sim", True).value: response.success = True',
        *("else: response.success = False", RETURNS),
    ),
    (
        'if self.get_parameter("sim").value: response.success = True',
        *("else: response.success = False", RETURNS),
    ),
]


@pytest.mark.parametrize("server", OPEN_SERVERS)
def test_an_open_answer_leaves_both_branches(tmp_path: Path, server: tuple[str, ...]) -> None:
    body = "\n".join(f"        {line}" for line in server)
    assert fired(tmp_path, model_of(read(tmp_path, body, DONE))) == {"docked", "alarm"}


@pytest.mark.parametrize(
    "client",
    [
        CALLS.replace("        if", "        response = self.other\n        if"),
        CALLS.replace("        if", "        response.success = not response.success\n        if"),
        CALLS.replace("        if", "        other = response\n        other.success = False\n        if"),
        CALLS.replace("        if", "        random.shuffle(response)\n        if"),
        CALLS.replace("        if", "        vars()['response'] = self.x\n        if"),
        CALLS.replace("        if", "        for response in self.x: pass\n        if"),
        CALLS.replace("response.success", "self.x"),
        CALLS.replace(
            "        response =",
            "        first = self.dock.call(Trigger.Request()); response =",
        ).replace("if response", "if first"),
        DONE.replace("        if", "        response = self.last\n        if"),
        DONE.replace("        response", "        future = self.last\n        response"),
        DONE.replace("        response", "        future.set_result(self.last)\n        response", 1),
        DONE.replace("future.result()", "self.last.result()"),
        DONE.replace("        if", "        self.last = future\n        if"),
    ],
)
def test_a_test_that_is_not_certain_changes_nothing(tmp_path: Path, client: str) -> None:
    model = model_of(read(tmp_path, client=client))
    assert guards(model) == []
    assert list(model.otherTokenTypes) == []
    assert all(channel.type for channel in model.channels)


LOOP = """
    def tick(self):
        for client in (self.dock, self.undock):
            {first}
            if self.x:
                response = client.call(Trigger.Request())
            {last}
"""
TESTS = "if response.success: self.a.publish(Empty())\n            else: self.b.publish(Empty())"


@pytest.mark.parametrize("where", ["first", "last"])
def test_a_response_of_an_earlier_turn_is_open(tmp_path: Path, where: str) -> None:
    more = 'self.undock = self.create_client(Trigger, "undock")'
    client = CLIENT.replace("self.create_timer", f"{more}\n        self.create_timer")
    body = LOOP.format(**{"first": "pass", "last": "pass", where: TESTS})
    undock = SERVER.replace('"dock"', '"undock"').format(name="other", body=FALSE)
    read(tmp_path, undocks=undock)
    (tmp_path / "client.py").write_text(HEAD + client + body + TAIL)
    assert guards(model_of(coded([("", read_source(tmp_path))], "code"))) == []


def test_a_second_server_leaves_both_branches(tmp_path: Path) -> None:
    other = SERVER.format(name="other", body=FALSE)
    model = model_of(read(tmp_path, other=other))
    assert guards(model) == []
    assert fired(tmp_path, model) == {"docked", "alarm"}


def test_a_server_that_only_the_running_system_has_leaves_both_branches(tmp_path: Path) -> None:
    code = read(tmp_path)
    seen = ObservedNode("/stranger", servers=(Endpoint("/dock", "std_srvs/srv/Trigger"),))
    system = type(code.system)(code.system.source, (*code.system.nodes, seen), is_partial=True)
    for form in ("calls", "done"):
        system = type(code.system)(
            code.system.source, (*read(tmp_path, client=FORMS[form]).system.nodes, seen), is_partial=True
        )
        model = to_model(system, merged(code.given, Given())).model
        assert guards(model) == []


def test_what_people_say_of_the_server_leaves_both_branches(tmp_path: Path) -> None:
    said = GivenNode(callbacks={"/dock": GivenCallback((Step("publish", "/served"),))})
    model = model_of(read(tmp_path), Given({"/server": said}))
    assert fired(tmp_path, model) == {"docked", "alarm"}


def test_a_callback_of_a_response_may_set_an_attribute(tmp_path: Path) -> None:
    client = CLIENT.replace(
        "        self.create_timer", "        self.busy = False\n        self.create_timer"
    )
    body = """
    def tick(self):
        if not self.busy:
            self.busy = True
            self.dock.call_async(Trigger.Request()).add_done_callback(self.done)

    def done(self, future):
        self.busy = False
        if future.result().success:
            self.a.publish(Empty())
        else:
            self.b.publish(Empty())
"""
    read(tmp_path)
    (tmp_path / "client.py").write_text(HEAD + client + body + TAIL)
    code = coded([("", read_source(tmp_path))], "code")
    assert list(code.given.nodes["/client"].variables) == ["busy"]
    assert fired(tmp_path, model_of(code)) == {"docked"}
