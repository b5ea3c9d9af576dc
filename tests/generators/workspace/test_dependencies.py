"""What handlers need is declared by their developers, reaches the packages, and stays."""

from __future__ import annotations

import ast
from pathlib import Path
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner, Result

from dineros.cli.main import main
from dineros.metamodel.files import save
from tests.generators.models import add_transition, kitchen

DECLARED = """\
exec_depend = ["geometry_msgs", "python3-numpy", "std_msgs"]
test_depend = ["libstdc++-dev", "geometry_msgs", "python3-pytest"]
install_requires = ['transitions>=0.9; python_version < "3.13"']
"""


@pytest.fixture
def cook(tmp_path: Path) -> Path:
    """Return the package of a node in a new workspace."""
    save(kitchen(), tmp_path / "kitchen.sym.xmi")
    assert generate(tmp_path).exit_code == 0
    return tmp_path / "ws/src/kitchen_cook"


def generate(folder: Path, *options: str) -> Result:
    arguments = ["generate", str(folder / "kitchen.sym.xmi"), "-o", str(folder / "ws"), *options]
    return CliRunner().invoke(main, arguments)


def depends(package: Path, kind: str) -> list[str | None]:
    return [each.text for each in ElementTree.parse(package / "package.xml").iterfind(kind)]


def requirements(package: Path) -> list[str]:
    for node in ast.walk(ast.parse((package / "setup.py").read_text(encoding="utf-8"))):
        if isinstance(node, ast.keyword) and node.arg == "install_requires":
            return list(ast.literal_eval(node.value))
    raise AssertionError("setup() has no install_requires")


def test_they_reach_the_package_and_stay(cook: Path, tmp_path: Path) -> None:
    needed = ["rclpy", "diagnostic_msgs", "kitchen_interfaces", "std_msgs", "std_srvs"]
    assert (depends(cook, "exec_depend"), requirements(cook)) == (needed, ["setuptools", "dineros-runtime"])

    file = cook / "dependencies.toml"
    file.write_text(DECLARED, encoding="utf-8")
    check = generate(tmp_path, "--check")
    assert (check.exit_code, check.stdout.count("is stale\n")) == (1, 2)
    assert f"{cook}/package.xml: is stale\n" in check.stdout
    assert f"{cook}/setup.py: is stale\n" in check.stdout
    assert generate(tmp_path).exit_code == 0

    model = kitchen()
    add_transition(model)
    save(model, tmp_path / "kitchen.sym.xmi")
    assert generate(tmp_path).exit_code == 0
    assert generate(tmp_path, "--check").exit_code == 0
    assert file.read_text(encoding="utf-8") == DECLARED
    assert depends(cook, "exec_depend") == [*needed, "geometry_msgs", "python3-numpy"]
    assert depends(cook, "test_depend") == ["python3-pytest", "libstdc++-dev"]
    assert requirements(cook) == [
        "setuptools",
        "dineros-runtime",
        'transitions>=0.9; python_version < "3.13"',
    ]


@pytest.mark.long
@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("exec_depend = x", "dependencies.toml:1:15: is not TOML: Invalid value (see https://toml.io)"),
        ('exec_depends = ["a"]', "has an unknown key 'exec_depends' (did you mean 'exec_depend'"),
        ('exec_depend = "numpy"', 'exec_depend is not a list (exec_depend = ["NAME"])'),
        (
            'exec_depend = ["a</x><y>"]',
            "exec_depend has 'a</x><y>', which is not a name of a ROS package or key",
        ),
        ("test_depend = [3]", "test_depend has 3, which is not a name"),
        (r'install_requires = ["a\nb"]', r"install_requires has 'a\nb', which is not a name"),
        ('exec_depend = ["kitchen_cook"]', "exec_depend has 'kitchen_cook', the package itself"),
        (f"exec_depend = {'[' * 9999}", "dependencies.toml: is not TOML: "),
        (f"exec_depend = {'9' * 9999}", "dependencies.toml: is not TOML: "),
        ("# \udcff", "is not written in UTF-8"),
    ],
)
def test_what_cannot_be_depended_on_is_one_line(cook: Path, tmp_path: Path, text: str, said: str) -> None:
    (cook / "dependencies.toml").write_bytes(text.encode(errors="surrogateescape"))
    before = (cook / "package.xml").read_bytes()
    done = generate(tmp_path)
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    assert said in done.stderr
    assert (cook / "package.xml").read_bytes() == before
