"""Tables of idioms that are not as the guide describes them: refused with one line that names the entry."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.metamodel.errors import DinerosError
from dineros.sources.cpp.programs import cpp_idioms
from dineros.sources.launch.vendors import known_vendors
from dineros.sources.libraries.idioms import known_idioms, read_idioms
from dineros.sources.reading import Launch, read_source

WRONG = {
    'node = "a"': "idiom 1 has no path",
    "path = 3": "idiom 1: path is not a string",
    'path = ""': "idiom 1: path is not a string",
    'path = "a"\nwhich = 1': "idiom a: which is unknown",
    'path = "a"\nnode = 3': "idiom a: node is not a string",
    'path = "a"\narguments = "node"': "idiom a: arguments is not a list of strings",
    'path = "a"\nalso = [1]': "idiom a: also is not a list of strings",
    'path = "a"\nmakes = "publishers"': "idiom a: makes is not a list of tables",
    'path = "a"\nmakes = { kind = "publishers" }': "idiom a: makes is not a list of tables",
    'path = "a"\nmakes = ["publishers"]': "idiom a: makes is not a list of tables",
    'path = "a"\nmakes = [{ name = "x", type = "a/msg/B" }]': "idiom a: makes[0] has no kind",
    'path = "a"\nmakes = [{ kind = "publisher", name = "x", type = "y" }]': "idiom a: makes[0]: kind is not",
    'path = "a"\nmakes = [{ kind = ["publishers"], name = "x", type = "y" }]': "makes[0]: kind is not",
    'path = "a"\nmakes = [{ kind = "publishers", name = 1, type = "y" }]': "makes[0]: name is not a string",
    'path = "a"\nmakes = [{ kind = "publishers", name = "x" }]': "makes[0] has no name or no type",
    'path = "a"\nmakes = [{ kind = "timers" }]': "makes[0] is a timer without a period",
    'path = "a"\nmakes = [{ kind = "timers", period = true }]': "makes[0]: period is not",
    'path = "a"\nmakes = [{ kind = "publishers", name = "x", type = "y", depth = -1 }]': "depth is not a",
    'path = "a"\nmakes = [{ kind = "publishers", name = "x", type = "y", depth = true }]': "depth is not a",
    'path = "a"\nmakes = [{ kind = "publishers", name = "x", type = "y", reliability = "x" }]': "reliability",
    'path = "a"\nmakes = [{ kind = "publishers", each = "rows", name = "x", type = 1 }]': "is not the number",
    'path = "a"\nmakes = [{ kind = "timers", period = 1.0, publishes = 0 }]': "is not an earlier publisher",
    'path = "a"\nmethods = "beat"': "idiom a: methods is not a table",
    'path = "a"\nmethods.beat = "publish"': "idiom a: methods.beat is not a table",
    'path = "a"\nmethods.beat = { entity = 0 }': "methods.beat has neither `do` nor `callback`",
    'path = "a"\nmethods.beat = { do = "publish", entity = 1 }': "methods.beat: entity is not an entity",
    'path = "a"\nmethods.beat = { do = 3 }': "methods.beat: do is not a string",
    'path = "a"\nquality = "latched"': "idiom a: quality is not a table",
    'path = "a"\nquality.depth = "1"': "idiom a: quality: depth is not a whole number",
    'path = "a"\nmanaged = "yes"': "idiom a: managed is not true or false",
    'path = "a"\nwhat = "x"': "idiom a has `what` or `how` without `do`",
}


@pytest.mark.parametrize("entry", WRONG)
def test_an_entry_of_another_shape_is_refused(tmp_path: Path, entry: str) -> None:
    table = tmp_path / "own.toml"
    table.write_text(f"[[idiom]]\n{entry}\n")
    (tmp_path / "robot.launch.xml").write_text('<launch><node pkg="mine" exec="driver"/></launch>')
    with pytest.raises(DinerosError) as raised:
        read_source(tmp_path, [table], Launch("robot.launch.xml"))
    assert WRONG[entry] in raised.value.message
    assert raised.value.hint and raised.value.location is not None
    assert raised.value.location.file == table and "\n" not in str(raised.value)


def test_a_list_of_rows_without_all_columns_is_left_out(tmp_path: Path) -> None:
    table = tmp_path / "own.toml"
    table.write_text(
        '[[idiom]]\npath = "lib.Many"\narguments = ["node", "rows"]\n'
        'makes = [{ kind = "publishers", each = "rows", attribute = 0, name = 1, type = 4, latched = 2 }]\n'
    )
    (tmp_path / "robot.py").write_text(
        "import rclpy\nfrom rclpy.node import Node\nfrom lib import Many\n"
        'rclpy.init()\nnode = Node("robot")\nMany(node, [("a", "b", 3)])\nrclpy.spin(node)\n'
    )
    facts = read_source(tmp_path, [table])
    assert [each.of("publishers") for each in facts.nodes] == [[]]


def test_our_own_tables_are_as_described() -> None:
    for table in (known_idioms(), cpp_idioms(), known_vendors()):
        assert len(table) > 10
    with pytest.raises(DinerosError, match=r"is unknown"):
        read_idioms(Path(__file__).parents[2] / "pyproject.toml")


def test_lidars_and_controllers_have_names_of_their_own() -> None:
    """What was an alias of another node has the name under which it runs."""
    known = known_vendors()
    assert known["sllidar_ros2/sllidar_node"].node == "sllidar_node"
    assert known["joy/game_controller_node"].node == "game_controller_node"
    assert "rplidar_ros/rplidar_composition" not in known
