"""A model may use any name that the templates use themselves: it gets another in Python, or is refused."""

from __future__ import annotations

import ast
import builtins
import contextlib
import keyword
import os
import re
import subprocess
import sys
from collections import Counter
from functools import cache
from pathlib import Path
from typing import TypedDict

import pytest
import yaml  # type: ignore[import-untyped]

from dineros.generators import Options, generate
from dineros.generators.application.collecting import application_of
from dineros.generators.application.naming import NamingError
from dineros.generators.workspace.planning import plan
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import find
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.ros_names import camel_case
from dineros.runtime.ros.channels.parameters import signal_parameters
from dineros.transformations.flattening.split import split
from tests.generators.models import kitchen

ROOT = Path(__file__).resolve().parents[3]


def files_of(model: sym.SystemModel, folder: str = "") -> dict[str, str]:
    """Return the Python files of a workspace that is not written."""
    made = plan(model, Path("nowhere"), Options(source="a.sym.xmi"), None)
    files = {**made.generated, **{path: file.content for path, file in made.developer.items()}}
    return {path: text.decode() for path, text in files.items() if path.endswith(".py") and folder in path}


@cache
def template_names(modules: str = "src/waiter/") -> list[str]:
    """Return every name that our templates define or use in some modules, and words of Python."""
    found = {*keyword.kwlist, *keyword.softkwlist}
    found |= {name for name in dir(builtins) if not name.endswith(("Error", "Warning", "Exception"))}
    for text in files_of(kitchen(), modules).values():
        for node in ast.walk(ast.parse(text)):
            for field in ("id", "attr", "name", "asname", "arg", "module"):
                name = getattr(node, field, None)
                found |= set(re.findall(r"\w+", name)) if isinstance(name, str) else set()
    # What types of transitions begin with, too.
    found |= {name.removesuffix(end) for name in found for end in ("Firing", "Inputs", "Outputs", "Changes")}
    return sorted(found - {""})


def chained(node: str, transitions: list[str], places: list[str]) -> sym.NodeNet:
    """Return a node net in which each transition takes from a place and puts to the next."""
    net = sym.NodeNet(id=node)
    ends = [sym.Place(id=place, page=net) for place in places]
    for number, id in enumerate(transitions):
        flow(ends[number], sym.Transition(id=id, page=net), ends[number + 1])
    return net


def model_of(role: str) -> sym.SystemModel:
    """Return a model with each name as a transition, a place, a signal or, where it can be one, a field."""
    plain = [f"{role}{number}" for number in range(len(template_names()) + 1)]
    net = chained(f"the_{role}", ["T1"], ["P1", "P2"])
    if role == "transition":
        net = chained("the_transition", template_names(), plain)
    if role == "place":
        net = chained("the_place", plain[1:], [*template_names(), plain[0]])
    if role == "signal":
        net.signals.extend(sym.InputSignal(id=name) for name in template_names())
    token_type = sym.TokenType(id="Datum", fields=fields() if role == "field" else [])
    return sym.SystemModel(id=f"by_{role}", tokenType=token_type, pages=[net])


def fields() -> list[sym.TokenField]:
    """Return a field of each name that can be one."""
    found: dict[str, sym.TokenField] = {}
    for name in template_names():
        field = sym.TokenField(name=name, kind="list", elementKind="number")
        model = sym.SystemModel(id="words", tokenType=sym.TokenType(id="Datum", fields=[field]))
        if validate(model) == []:
            with contextlib.suppress(NamingError):
                found.setdefault(str(application_of(model).interfaces.fields[0].message_name), field)
    assert len(found) > 150
    return list(found.values())


ROLES = ("transition", "place", "signal", "field")


@pytest.fixture(scope="module")
def workspaces(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return the package of the one node net of each model."""
    folder = tmp_path_factory.mktemp("reserved")
    packages = {}
    for role in ROLES:
        model = model_of(role)
        assert [violation for violation in validate(model) if violation.severity == "error"] == []
        generate(model, folder / role, Options(source="a.sym.xmi"))
        packages[role] = folder / role / "src" / f"the_{role}"
    return packages


def run(*command: object, folder: Path, **environment: str) -> str:
    done = subprocess.run(
        [str(part) for part in command],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


SHOW = """
import sys, types
from importlib import import_module
for role in sys.argv[1:]:
    base, handlers, tokens = (import_module(f"the_{role}.{name}") for name in ("base", "handlers", "tokens"))
    net = base.make_net()
    assert isinstance(handlers.firings, types.ModuleType)
    assert list(handlers.configure.__annotations__) == ["net", "return"]
    assert tokens.datum() == {name: [] for name in tokens.Datum.__annotations__}
    print(len(net.inspect().marking), len({each.function for each in handlers.firings.HANDLERS}))
"""


@pytest.mark.long
def test_packages_with_names_of_the_templates_work(workspaces: dict[str, Path]) -> None:
    path = os.pathsep.join(map(str, workspaces.values()))
    folder = workspaces["place"]
    out = run(sys.executable, "-B", "-c", SHOW, *ROLES, folder=folder, PYTHONPATH=path)
    counts = [line.split() for line in out.splitlines()]
    many = str(len(template_names()))
    assert [handlers for _, handlers in counts] == [many, many, "1", "1"]


@pytest.mark.long
def test_no_module_binds_a_name_twice(workspaces: dict[str, Path]) -> None:
    for package in workspaces.values():
        for module in ("base", "firings", "handlers", "tokens"):
            tree = ast.parse((package / package.name / f"{module}.py").read_text(encoding="utf-8"))
            names = [name for node in tree.body for name in bound(node)]
            assert [name for name, times in Counter(names).items() if times > 1 and name != "on"] == []


def bound(node: ast.stmt) -> list[str]:
    match node:
        case ast.FunctionDef(name=name) | ast.ClassDef(name=name) | ast.AnnAssign(target=ast.Name(id=name)):
            return [name]
        case ast.Import(names=aliases) | ast.ImportFrom(names=aliases):
            return [alias.asname or alias.name for alias in aliases]
        case ast.Assign(targets=[ast.Name(id=name)]):
            return [name]
    return []


@pytest.mark.long
def test_packages_with_names_of_the_templates_pass_mypy(workspaces: dict[str, Path], tmp_path: Path) -> None:
    check = tmp_path / "mypy.ini"
    check.write_text(
        "[mypy]\nstrict = true\npython_version = 3.11\nnamespace_packages = true\n"
        "explicit_package_bases = true\n[mypy-dineros.*]\nfollow_imports = silent\n"
    )
    links = tmp_path / "typed" / "dineros"
    links.mkdir(parents=True)
    for room in ("metamodel", "runtime"):
        (links / room).symlink_to(ROOT / room)
    path = os.pathsep.join(map(str, [links.parent, *workspaces.values()]))
    cache = ["--config-file", check, "--cache-dir", ROOT / ".mypy_cache/generated"]
    packages = [part for role in ROLES for part in ("-p", f"the_{role}")]
    run(sys.executable, "-m", "mypy", *cache, *packages, folder=tmp_path, MYPYPATH=path)


@pytest.mark.parametrize(
    "stem", ["TypedDict", "None", "Unpack", "Import", "Str", "Default", "NULL", "Float", "Datum"]
)
def test_a_token_type_works_or_is_refused(stem: str) -> None:
    model = kitchen()
    assert model.tokenType is not None
    model.tokenType.id = stem
    try:
        files = files_of(model, "waiter/tokens.py")
    except NamingError as error:
        assert stem in ("TypedDict", "None", "Unpack", "NULL")
        assert error.hint == f"rename the token type {stem!r}"
        return
    names: dict[str, object] = {}
    (text,) = files.values()
    exec(text, names)
    function = next(value for name, value in names.items() if name.rstrip("_") == stem.lower())
    assert callable(function)
    assert function(table=4)["table"] == 4
    assert isinstance(names["TypedDict"], type(TypedDict))


@pytest.mark.long
def test_every_name_as_a_token_type_gives_python_or_one_line() -> None:
    for name in sorted({camel_case(name) for name in template_names("waiter/tokens.py")}):
        model = chained_model(name)
        try:
            for text in files_of(model, "src/the_net/").values():
                ast.parse(text)
        except DinerosError as error:
            assert error.hint
            assert "\n" not in str(error)


def chained_model(token_type: str) -> sym.SystemModel:
    return sym.SystemModel(
        id="m", tokenType=sym.TokenType(id=token_type), pages=[chained("the_net", ["T1"], ["P1", "P2"])]
    )


@pytest.mark.parametrize("ids", [("a-b", "a_b", "A"), ("a.b", "a-b", "a@b"), ("On", "y", "null")])
def test_signals_are_told_apart_as_the_node_does(ids: tuple[str, ...]) -> None:
    model = kitchen()
    waiter = find(model, "waiter", sym.NodeNet)
    waiter.signals.extend(sym.InputSignal(id=id, initial=number % 2 == 0) for number, id in enumerate(ids))
    assert [violation for violation in validate(model) if violation.severity == "error"] == []
    made = plan(model, Path("nowhere"), Options(source="a.sym.xmi"), None)
    text = made.generated["src/kitchen_bringup/config/waiter.yaml"].decode()
    values = yaml.safe_load(text)["/**"]["ros__parameters"]["signals"]
    node = next(part.node for part in split(model) if part.node.id == "waiter")
    parameters = signal_parameters((signal.id, bool(signal.initial)) for signal in node.signals)
    assert {f"signals.{name}": value for name, value in values.items()} == {
        parameter.name: parameter.default for parameter in parameters.values()
    }
    assert len(values) == 1 + len(ids)
