"""Code that is broken, huge, of another time, or wants to be executed."""

from __future__ import annotations

import os
import time
import tracemalloc
from pathlib import Path

import pytest

from dineros.metamodel.errors import DinerosError
from dineros.sources.reading import Launch, read_source
from tests.sources.support import HEAD, facts_of, written

BROKEN = {
    "f(" * 10_000 + ")" * 10_000: "its code is nested more than 400 levels deep",
    "x = a" + ".b()" * 10_000: "its code is nested more than 400 levels deep",
    "x = " + "+".join(["1"] * 10_000): "its code is nested more than 400 levels deep",
    'print "hello"': "cannot parse it in line 1",
    "x = 1\0": "null bytes",
    "x = 1\n" * 400_000: "is larger than 2 MiB",
}


@pytest.mark.parametrize(("text", "expected"), BROKEN.items(), ids=range(len(BROKEN)))
def test_files_that_cannot_be_read_are_named_and_hide_no_others(
    tmp_path: Path, text: str, expected: str
) -> None:
    (tmp_path / "bad.py").write_text(text)
    facts = facts_of(
        tmp_path, 'def main():\n    rclpy.init(); Node("good")\nif __name__ == "__main__": main()\n'
    )
    assert [node.name for node in facts.nodes] == ["good"]
    (line,) = facts.unread
    assert line.startswith("bad.py: ") and expected in line


def test_nothing_is_executed_or_imported(tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    text = f"import pathlib\npathlib.Path({str(mark)!r}).touch()\nopen({str(mark)!r}, 'w')\n"
    facts = facts_of(
        tmp_path, f'{text}\nrclpy.init()\nNode("there")\n', setup=text, conftest=text, rclpy=text
    )
    assert [node.name for node in facts.nodes] == ["there"]
    assert not mark.exists()


def test_links_out_of_the_folder_are_not_followed(tmp_path: Path) -> None:
    inside, outside = tmp_path / "in", tmp_path / "out"
    written(outside, other='import rclpy\nrclpy.init()\nrclpy.create_node("outside")\n')
    inside.mkdir()
    (inside / "link.py").symlink_to(outside / "other.py")
    (inside / "folder").symlink_to(outside)
    (inside / "again").symlink_to(".")
    facts = read_source(inside)
    assert facts.nodes == [] and facts.unread == [
        "link.py: it is a symbolic link to a path outside of the folder"
    ]


def test_pipes_and_links_to_nothing_are_left_alone(tmp_path: Path) -> None:
    for name in ("pipe.py", "pipe", "pipe.launch.xml"):
        os.mkfifo(tmp_path / name)
    (tmp_path / "gone.py").symlink_to("nowhere.py")
    for name in ("itself.py", "itself", "itself.launch.xml", "CMakeLists.txt"):
        (tmp_path / name).symlink_to(name)
    facts = facts_of(tmp_path, 'rclpy.init()\nNode("there")\n')
    assert [node.name for node in facts.nodes] == ["there"] and facts.unread == []


def test_files_of_50_megabytes_are_not_read(tmp_path: Path) -> None:
    for name in ("big.py", "big.launch.xml", "big.launch.yaml", "package.xml", "CMakeLists.txt"):
        with (tmp_path / name).open("wb") as file:
            file.truncate(50 << 20)
    tracemalloc.start()
    facts = facts_of(tmp_path, 'rclpy.init()\nNode("there")\n')
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert [node.name for node in facts.nodes] == ["there"]
    assert {line.partition(": ")[0] for line in facts.unread} >= {"big.py", "big.launch.xml"}
    assert most < 60 << 20


INCLUDE = "launch.actions.IncludeLaunchDescription"
CIRCLES = {
    "python": {
        f"{name}.launch.py": "import launch, launch.actions\ndef generate_launch_description():\n"
        f'    twice = [{INCLUDE}("{other}.launch.py"), {INCLUDE}("{other}.launch.py")]\n'
        "    return launch.LaunchDescription(twice)\n"
        for name, other in (("a", "b"), ("b", "a"))
    },
    "xml": {"a.launch.xml": '<launch><include file="a.launch.xml"/><include file="a.launch.xml"/></launch>'},
    "yaml": {
        "a.launch.yaml": "launch:\n- include: {file: a.launch.yaml}\n- include: {file: a.launch.yaml}\n"
    },
}


@pytest.mark.parametrize("kind", CIRCLES)
def test_launch_files_that_include_each_other_end_in_one_line(tmp_path: Path, kind: str) -> None:
    for name, text in CIRCLES[kind].items():
        (tmp_path / name).write_text(text)
    written(tmp_path, program=f'{HEAD}\nrclpy.init()\nNode("there")\n')
    first = next(iter(CIRCLES[kind]))
    facts = read_source(tmp_path, launch=Launch(first))
    assert facts.nodes == []
    assert facts.unread == [
        f"{first}: it does not start any node whose code is in this folder",
        f"{first}: it includes itself, and is not read again",
    ]


def test_launch_files_that_include_very_much_end(tmp_path: Path) -> None:
    for level in range(8):
        text = f'<include file="f{level + 1}.launch.xml"/>' * 10
        (tmp_path / f"f{level}.launch.xml").write_text(f"<launch>{text}</launch>")
    (tmp_path / "f8.launch.xml").write_text("<launch/>")
    facts = read_source(tmp_path, launch=Launch("f0.launch.xml"))
    assert any("more than 1000 includes" in line for line in facts.unread)


DOUBLED = {
    "xml": (
        "<launch><let name='v0' value='aaaaaaaaaa'/>",
        "<let name='v{to}' value='$(var v{of})$(var v{of})$(var v{of})$(var v{of})'/>",
        "<node pkg='p' exec='program.py' name='$(var v{last})'/></launch>",
    ),
    "py": (
        "from launch.substitutions import TextSubstitution\nfrom launch_ros.actions import Node as N\n"
        "from launch import LaunchDescription\ndef generate_launch_description():\n    v0 = ['']\n",
        "    v{to} = [v{of}, v{of}, v{of}, v{of}]\n",
        "    return LaunchDescription([N(package='p', executable='program.py', name=v{last})])\n",
    ),
}


@pytest.mark.parametrize("kind", DOUBLED)
def test_texts_of_launch_files_that_grow_take_neither_memory_nor_time(tmp_path: Path, kind: str) -> None:
    first, step, last = DOUBLED[kind]
    steps = "".join(step.format(of=n, to=n + 1) for n in range(20))
    (tmp_path / f"a.launch.{kind}").write_text(f"{first}{steps}{last.format(last=20)}")
    (tmp_path / "package.xml").write_text("<package format='3'><name>p</name></package>")
    written(tmp_path, program=f'{HEAD}\nrclpy.init()\nNode("there")\n')
    begin = time.process_time()
    tracemalloc.start()
    facts = read_source(tmp_path, launch=Launch(f"a.launch.{kind}"))
    taken = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert [node.name for node in facts.nodes] == ["open: {a long text}"] or facts.nodes
    assert taken < 100 << 20
    assert time.process_time() - begin < 10


def test_a_program_that_never_ends_is_followed_for_a_while(tmp_path: Path) -> None:
    functions = "".join(f"def f{i}():\n    {'; '.join([f'f{i + 1}()'] * 8)}\n" for i in range(20))
    begin = time.process_time()
    facts = facts_of(
        tmp_path,
        f'{functions}\ndef f20(): pass\nrclpy.init()\nnode = Node("there")\nf0()\nwhile True: f0()\n',
    )
    assert [node.name for node in facts.nodes] == ["there"]
    assert facts.unread == ["program.py: the program program.py is too large to be read completely"]
    assert time.process_time() - begin < 30


@pytest.mark.parametrize(
    "code",
    [
        "x = 'a' * 10**10",
        "x = 9 ** 9 ** 9",
        "x = '{:>1000000000}'.format(1)",
        "x = f'{1:>1000000000}'",
        "x = ['a'] * 10**10",
        "x = list(range(10**12))",
        "class A(A): pass",
        "class A:\n    def __init__(self): self.b = A()\nA()",
        "f = lambda g: g(g)\nf(f)",
        "x = []\nx.append(x)\nfor y in x: pass\nx + x",
        "def f(*a, **k): return f(*a, a, **k)\nf(1, b=2)",
        "x = int('9' * 5000)",
        "x = int(1e999), round(1e999), int(float('nan')), '{:c}'.format(10**20), '{:d}'.format(1e999)",
        f"x = '{{{'9' * 5000}}}'.format(1)",
        *(
            f"n = Node('n')\nn.create_timer({number}, print)\ntime.sleep({number})\nx = f'{{{number}}}'\n"
            f"n.create_publisher(String, '/x', {number})\nwhile x < {number}: pass\nx = {number} / 7 // 2\n"
            f"n.create_publisher(String, f'/x{{{number}}}', 1)\nn.declare_parameter('p', {number})"
            for number in ("9" * 400, "9" * 4000, f"0x{'f' * 5000}", "1e999", "1e999j", "-1e999", "1e-999")
        ),
        "x, *y = z = [a := 1, *b]\ndel x\nmatch x:\n    case [1, *r]: pass\n    case {'a': k, **rest}: pass",
        "async def f():\n    async with a as b: pass\n    async for i in x: yield i\nf()",
        "x[1:2], x[...], x[a, b]\nlambda *a, k=1, **q: (yield)\n@a.b(c)\nclass C(metaclass=M): x: int = 3",
        "from . import x\nfrom .. import y\nfrom ..... import z\nfrom program import *\nimport program",
        "getattr(x, 'y')(1); setattr(x, 'y', 2); setattr(x, y, 2); vars(x).update(a=1)",
        "try:\n    pass\nexcept* ValueError as e:\n    raise\nelse:\n    x = 1\nfinally:\n    x = 2",
    ],
)
def test_odd_code_stops_nothing(tmp_path: Path, code: str) -> None:
    facts = read_source(written(tmp_path, program=f'{HEAD}\n{code}\nrclpy.init()\nNode("there")\n'))
    assert "there" in [node.name for node in facts.nodes]


@pytest.mark.parametrize("number", ["9" * 400, "9" * 5000, f"0x{'f' * 5000}", "1e999", "1e999f", "-1", "1'0"])
def test_odd_numbers_of_cpp_stop_nothing(tmp_path: Path, number: str) -> None:
    (tmp_path / "program.cpp").write_text(
        "#include <rclcpp/rclcpp.hpp>\n"
        'class There : public rclcpp::Node {\npublic:\n  There() : Node("there") {\n'
        f"    timer_ = create_wall_timer(std::chrono::milliseconds({number}), [this]() {{ tick(); }});\n"
        f"    other_ = create_wall_timer(std::chrono::duration<double>({number}), [this]() {{ tick(); }});\n"
        f'    int n = {number}; double d = {number}; declare_parameter("p", {number});\n'
        f'    pub_ = create_publisher<std_msgs::msg::String>("/x" + std::to_string(n), {number}); }}\n'
        f"  void tick() {{\n"
        f"    while (left_ < {number}) {{ rclcpp::sleep_for(std::chrono::seconds({number})); }}\n"
        f"    while (left_ != {number}) {{}}\n"
        f"    auto m = std_msgs::msg::UInt8(); m.data = {number}; pub_->publish(m); }}\n"
        "  rclcpp::TimerBase::SharedPtr timer_, other_; int left_ = 0;\n};\n"
        "int main(int c, char** v) { rclcpp::init(c, v); rclcpp::spin(std::make_shared<There>()); }\n"
    )
    facts = read_source(tmp_path)
    assert [node.name for node in facts.nodes] == ["there"]


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(DinerosError, match="this folder of source code does not exist"):
        read_source(tmp_path / "nowhere")


@pytest.mark.long
def test_many_files_are_read_in_seconds(tmp_path: Path) -> None:
    text = HEAD + "".join(
        f"""
class Robot{i}(Node):
    def __init__(self):
        super().__init__("robot{i}")
        self.pub = self.create_publisher(String, "out{i}", 10)
        self.create_timer(0.1, self.tick)
    def tick(self):
        for each in range(10):
            self.help(each)
    def help(self, each):
        if each > 3: self.pub.publish(String(data=str(each)))
"""
        for i in range(2)
    )
    main = "def main():\n    rclpy.init()\n    rclpy.spin(Robot1())\nif __name__ == '__main__': main()\n"
    written(tmp_path, **{f"package{n // 10}__module{n}": text + main for n in range(250)})
    begin = time.process_time()
    assert len(read_source(tmp_path).nodes) == 500
    assert time.process_time() - begin < 10
