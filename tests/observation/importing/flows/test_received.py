"""Fields of messages decide about branches of callbacks, as far as the reader is certain."""

from __future__ import annotations

import itertools
import random
import types
from pathlib import Path
from typing import Any

import pytest

from dineros.metamodel import sym
from dineros.metamodel.elements import places, transitions
from dineros.metamodel.files import save
from dineros.observation.importing.building import to_model
from dineros.observation.importing.coded import Coded, coded
from dineros.observation.importing.correcting import merged
from dineros.observation.importing.flows.labels import Label, Received, Step
from dineros.observation.importing.given import Given, GivenCallback, GivenNode
from dineros.observation.systems import ObservedNode, TopicEndpoint
from dineros.sources.reading import read_source
from tests.support.flow_runs import accepts
from tests.support.programs.coded import run

HEAD = """
import random
import rclpy
from rclpy.node import Node
from std_msgs.msg import Bool, Empty
"""
TAIL = """
if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(Made())
"""
LAMP = """
class Made(Node):
    def __init__(self):
        super().__init__("lamp")
        self.a = self.create_publisher(Empty, "lit", 1)
        self.b = self.create_publisher(Empty, "alarm", 1)
        self.create_subscription(Bool, "switch", self.on_switch, 1)

    def on_switch(self, msg):
        if msg.data:
            self.a.publish(Empty())
        else:
            self.b.publish(Empty())
"""
SWITCH = """
class Made(Node):
    def __init__(self):
        super().__init__("{name}")
        self.out = self.create_publisher(Bool, "switch", 1)
        self.create_timer(1.0, self.tick)

    def tick(self):
        message = Bool()
{body}
        self.out.publish(message)
"""
TRUE = "        message.data = True"


def read(folder: Path, **programs: str) -> Coded:
    """Return what programs say."""
    for name, text in programs.items():
        (folder / f"{name}.py").write_text(HEAD + text + TAIL)
    return coded([("", read_source(folder))], "code")


def model_of(code: Coded, said: Given | None = None) -> sym.SystemModel:
    return to_model(code.system, merged(code.given, said or Given())).model


def switch(body: str = TRUE, name: str = "switch") -> str:
    return SWITCH.format(body=body, name=name)


def fired(folder: Path, model: sym.SystemModel) -> set[str]:
    """Return what the lamp publishes in some run."""
    path = folder / "model.sym.xmi"
    save(model, path)
    found = set()
    for name in ("lit", "alarm"):
        if not any(str(each.id).endswith(f".publishes_{name}") for each in transitions(model)):
            continue
        _, text = run("verify", "-q", path, "--ltl", f'G !fired("lamp.on_switch.publishes_{name}")')
        assert text.startswith(("holds", "violated")), text
        if text.startswith("violated"):
            found.add(name)
    return found


def guards(model: sym.SystemModel) -> list[str]:
    return [each.guard for each in transitions(model) if isinstance(each, sym.Transition) and each.guard]


# ------------------------------------------------------------------------------------------------ end to end


@pytest.mark.parametrize(("value", "expected"), [("True", {"lit"}), ("False", {"alarm"})])
def test_a_branch_for_a_value_that_is_never_sent_is_dead(
    tmp_path: Path, value: str, expected: set[str]
) -> None:
    model = model_of(read(tmp_path, lamp=LAMP, switch=switch(f"        message.data = {value}")))
    assert fired(tmp_path, model) == expected
    (channel,) = [each for each in model.channels if getattr(each, "topic", "") == "/switch"]
    assert channel.type is None
    typed = {each.tokenType.ros for each in places(model) if isinstance(each, sym.Place) and each.tokenType}
    assert typed == {"std_msgs/msg/Bool"}


@pytest.mark.parametrize(
    "body",
    [
        "        message.data = random.random() < 0.5",
        "        pass",
        "        message.data = True\n        if random.random() < 0.5:\n            message.data = False",
        "        message.data = True\n        other = message\n        other.data = False",
        "        message.data = True\n        message = self.last",
        "        message.data = True\n        self.change(message)",
    ],
)
def test_a_second_publisher_with_an_open_value_opens_the_branch(tmp_path: Path, body: str) -> None:
    code = read(tmp_path, lamp=LAMP, switch=switch(), other=switch(body, "other"))
    model = model_of(code)
    assert guards(model) == []
    assert fired(tmp_path, model) == {"lit", "alarm"}


def test_a_second_publisher_with_the_other_value_opens_the_branch(tmp_path: Path) -> None:
    other = switch("        message.data = False", "other")
    assert fired(tmp_path, model_of(read(tmp_path, lamp=LAMP, switch=switch(), other=other))) == {
        "lit",
        "alarm",
    }


def test_one_publisher_of_two_values_opens_the_branch(tmp_path: Path) -> None:
    body = TRUE + "\n        self.out.publish(Bool(data=False))"
    assert fired(tmp_path, model_of(read(tmp_path, lamp=LAMP, switch=switch(body)))) == {"lit", "alarm"}


@pytest.mark.parametrize("is_one", [True, False])
def test_with_short_queues_each_value_leads_to_its_branch(tmp_path: Path, is_one: bool) -> None:
    body = (
        "        if random.random() < 0.5:\n            self.out.publish(Bool(data={}))\n            return\n"
    )
    programs = {"lamp": LAMP, "switch": switch(TRUE if not is_one else body.format("False") + TRUE)}
    if not is_one:
        programs["other"] = switch("        message.data = False", "other")
    model = model_of(read(tmp_path, **programs))
    assert len(guards(model)) == 2
    assert fired(tmp_path, model) == {"lit", "alarm"}
    false, true = "switch.on_tick.publishes_switch", "switch.on_tick.publishes_switch_2"
    if not is_one:
        false, true = "other.on_tick.publishes_switch", false
    for sent, other, done in ((true, false, "lit"), (false, true, "alarm")):
        before = f'!((!fired("{sent}")) U fired("lamp.on_switch.publishes_{done}"))'
        assert run("verify", "-q", tmp_path / "model.sym.xmi", "--ltl", before)[1].startswith("holds")
        wrong = before.replace(sent, other)
        assert run("verify", "-q", tmp_path / "model.sym.xmi", "--ltl", wrong)[1].startswith("violated")


def test_two_values_in_long_queues_leave_both_branches(tmp_path: Path) -> None:
    deep = SWITCH.replace('"switch", 1)', '"switch", 10)')
    body = "        message.data = False"
    code = read(tmp_path, lamp=LAMP, a=deep.format(body=TRUE, name="a"), b=deep.format(body=body, name="b"))
    assert guards(model_of(code)) == []


def test_a_publisher_that_only_the_running_system_has_is_open(tmp_path: Path) -> None:
    code = read(tmp_path, lamp=LAMP, switch=switch())
    seen = ObservedNode("/stranger", publishers=(TopicEndpoint("/switch", "std_msgs/msg/Bool"),))
    system = type(code.system)(code.system.source, (*code.system.nodes, seen), is_partial=True)
    model = to_model(system, merged(code.given, Given())).model
    assert guards(model) == []
    assert fired(tmp_path, model) == {"lit", "alarm"}


def test_what_people_say_of_a_publisher_is_open(tmp_path: Path) -> None:
    said = GivenNode(callbacks={"tick": GivenCallback((Step("publish", "/switch"),))})
    model = model_of(read(tmp_path, lamp=LAMP, switch=switch()), Given({"/switch": said}))
    assert fired(tmp_path, model) == {"lit", "alarm"}


def test_what_people_say_of_the_callback_takes_the_place_of_its_branches(tmp_path: Path) -> None:
    said = GivenNode(callbacks={"/switch": GivenCallback((Step("publish", "/alarm"),))})
    model = model_of(read(tmp_path, lamp=LAMP, switch=switch()), Given({"/lamp": said}))
    assert fired(tmp_path, model) == {"alarm"}


# ----------------------------------------------------------------------------------- what stays as it is


@pytest.mark.parametrize(
    "lamp",
    [
        LAMP.replace("        if msg", "        msg = self.last\n        if msg"),
        LAMP.replace("        if msg", "        msg.data = not msg.data\n        if msg"),
        LAMP.replace("        if msg", "        change(msg)\n        if msg"),
        LAMP.replace("        if msg", "        self.last = msg\n        if msg"),
        LAMP.replace("if msg.data", "if self.ready"),
        LAMP.replace("def on_switch", "@random.choice\n    def on_switch"),
    ],
)
def test_a_test_that_is_not_certain_changes_nothing(tmp_path: Path, lamp: str) -> None:
    code = read(tmp_path, lamp=lamp, switch=switch())
    model = model_of(code)
    assert code.given.deciding == {}
    assert guards(model) == []
    assert list(model.otherTokenTypes) == []
    assert all(channel.type for channel in model.channels)
    assert fired(tmp_path, model) == {"lit", "alarm"}


def test_without_a_certain_publisher_nothing_changes(tmp_path: Path) -> None:
    code = read(tmp_path, lamp=LAMP, switch=switch("        message.data = self.x"))
    assert guards(model_of(code)) == []
    (tmp_path / "switch.py").unlink()
    assert read(tmp_path, lamp=LAMP).given.deciding == {}


@pytest.mark.parametrize(
    "lends",
    [
        "        random.seed(self.out)",
        "        random.seed([self.out])",
        "        self.register(self.out.publish)",
        "        random.holder.out = self.out",
        "        random.Helper(self)",
        "        random.Helper([self])",
    ],
)
def test_a_publisher_that_unknown_code_gets_is_open(tmp_path: Path, lends: str) -> None:
    model = model_of(read(tmp_path, lamp=LAMP, switch=switch(f"{TRUE}\n{lends}")))
    assert guards(model) == []
    assert fired(tmp_path, model) == {"lit", "alarm"}


def test_a_topic_of_another_type_in_the_running_system_has_no_data(tmp_path: Path) -> None:
    code = read(tmp_path, lamp=LAMP, switch=switch())
    seen = ObservedNode("/a_stranger", publishers=(TopicEndpoint("/switch", "std_msgs/msg/String"),))
    system = type(code.system)(code.system.source, (seen, *code.system.nodes), is_partial=True)
    assert guards(to_model(system, merged(code.given, Given())).model) == []


def test_a_field_that_is_no_truth_value_does_not_decide(tmp_path: Path) -> None:
    lamp, sender = (each.replace("Bool", "String") for each in (LAMP, switch("        message.data = True")))
    assert read(tmp_path, lamp=lamp, switch=sender).given.deciding == {}


# -------------------------------------------------------------------------------------- random programs

MOST_COINS = 5


class Writer:
    """Writes the body of a callback at random."""

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)

    def test(self, depth: int = 2) -> str:
        pick = self._random.random()
        if depth and pick < 0.25:
            return f"not ({self.test(depth - 1)})"
        if depth and pick < 0.5:
            return f"({self.test(depth - 1)} {self._random.choice(['and', 'or'])} {self.test(depth - 1)})"
        return "msg.data" if pick < 0.85 else "random.random() < 0.5"

    def block(self, indent: int, depth: int) -> list[str]:
        found = []
        for _ in range(self._random.randint(1, 3)):
            found += self.statement(" " * indent, indent, depth)
        return found

    def statement(self, space: str, indent: int, depth: int) -> list[str]:
        pick = self._random.random()
        if depth and pick < 0.5:
            lines = [f"{space}if {self.test()}:", *self.block(indent + 4, depth - 1)]
            if self._random.random() < 0.5:
                lines += [f"{space}else:", *self.block(indent + 4, depth - 1)]
            return lines
        if depth and pick < 0.6:
            return [f"{space}for _ in (1, 2):", *self.block(indent + 4, depth - 1)]
        if depth and pick < 0.7:
            end = self._random.choice([f"{space}except ValueError:", f"{space}finally:"])
            return [f"{space}try:", *self.block(indent + 4, depth - 1), end, *self.block(indent + 4, 0)]
        if pick < 0.75:
            return [f"{space}return"]
        return [f"{space}self.{self._random.choice('ab')}.publish(Empty())"]


def runs_of(body: list[str], value: bool) -> set[tuple[str, ...]]:
    """Return what a callback publishes, in each of its runs, when Python runs it."""
    found = set()
    for coins in itertools.product((0.0, 1.0), repeat=MOST_COINS):
        left, done = list(coins), list[str]()

        def port(name: str, done: list[str] = done) -> Any:
            return types.SimpleNamespace(publish=lambda _: done.append(name))

        def flip(left: list[float] = left) -> float:
            return left.pop(0)

        names: dict[str, Any] = {"random": types.SimpleNamespace(random=flip), "Empty": lambda: None}
        exec("\n".join(["def on_switch(self, msg):", *body]), names)
        try:
            names["on_switch"](
                types.SimpleNamespace(a=port("/lit"), b=port("/alarm")), types.SimpleNamespace(data=value)
            )
        except IndexError:
            continue  # it asked too often
        found.add(tuple(done))
    return found


def is_step(label: Label, name: str) -> bool:
    return isinstance(label, Step) and label.name == name


def test_random_callbacks_do_what_their_branches_allow(tmp_path: Path) -> None:
    decided = refused = 0
    for seed in range(150):
        body = Writer(seed).block(8, 3)
        folder = tmp_path / str(seed)
        folder.mkdir()
        code = read(
            folder, lamp=LAMP[: LAMP.index("        if msg")] + "\n".join(body) + "\n", switch=switch()
        )
        received = code.given.nodes["/lamp"].callbacks["/switch"].received
        if received is None:
            continue
        decided += 1
        assert isinstance(received, Received)
        runs = {value: runs_of(body, value) for value in (True, False)}
        assert len(received.branches) == 2
        for text, flow in received.branches:
            value = text == "true"
            for each in runs[value]:
                assert accepts(flow, each, is_step), (seed, value, each, "\n".join(body))
            refused += any(not accepts(flow, each, is_step) for each in runs[not value])
    assert decided > 40
    assert refused > 30
