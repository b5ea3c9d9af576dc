"""What a ROS 2 workspace should hold, from a system model and options."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dineros.generators.application.application import Application, NodePackage, Transition
from dineros.generators.application.collecting import application_of
from dineros.generators.application.naming import NOTHING_RESERVED, Reserved, require_short_paths
from dineros.generators.application.reserved import reserved_names
from dineros.generators.templates.filters import Name, Written
from dineros.generators.templates.rendering import TemplateError, Templates, generator
from dineros.generators.workspace import dependencies
from dineros.generators.workspace.handwritten import FIRINGS
from dineros.generators.workspace.manifest import Manifest, NodeEntry
from dineros.generators.workspace.plan import DeveloperFile, Plan, WriteStub
from dineros.generators.workspace.scripts import Script, read_script
from dineros.generators.workspace.system_model import file_name
from dineros.metamodel import sym
from dineros.metamodel.errors import Location
from dineros.metamodel.files.confined import ConfinedFolder
from dineros.metamodel.files.xmi import xmi_bytes
from dineros.metamodel.ros_names import snake_case


@dataclass(frozen=True)
class Options:
    """How a workspace is generated.

    Attributes
    ----------
    source : str
        Name of the model's file, for the manifest.
    settings : tuple of str
        How the model was changed by ``--set``, for the manifest and for traces.
    lifecycle : bool or None
        Whether nodes are lifecycle nodes; None: as the workspace was generated before, else plain nodes.
    templates : Path or None
        Folder with templates that override ours; a workspace that was generated with some needs them again.
    default_templates : bool
        Whether such a workspace goes back to ours.
    maintainer, license : str or None
        For the packages' ``package.xml``, the maintainer as ``Name <address>``; None: as before.
    systemd, container : bool or None
        Whether there is a unit of systemd, and a Containerfile; None: as before, else not.
    tests : tuple of Path
        Witnesses and recorded runs to write tests from.
    """

    source: str
    settings: tuple[str, ...] = ()
    lifecycle: bool | None = None
    templates: Path | None = None
    default_templates: bool = False
    maintainer: str | None = None
    license: str | None = None
    systemd: bool | None = None
    container: bool | None = None
    tests: tuple[Path, ...] = ()


DEFAULTS: dict[str, Any] = {
    "container": False,
    "lifecycle": False,
    "license": "TODO: License declaration",  # what `ros2 pkg create` writes
    "maintainer": "TODO <todo@example.org>",
    "systemd": False,
    "templates": None,
}


def plan(model: sym.SystemModel, workspace: Path, options: Options, known: Manifest | None) -> Plan:
    """Return what a workspace should hold, given what is known of it."""
    chosen = _chosen(workspace, options, known)
    folder = options.templates
    if folder is None and chosen["templates"]:
        # They are programs, and the manifest comes with the workspace, from whomever that is.
        raise TemplateError(
            f"was generated with the templates of {chosen['templates']!r:.200}, which must be named again",
            location=Location(workspace),
            hint="--templates DIR takes them, --default-templates does without",
        )
    templates = Templates(model.id, folder)

    def render(app: Application, module: str) -> bytes:
        context = _node_context(app.nodes[0], _common(app, NOTHING_RESERVED, options, chosen))
        return templates.render(f"node/{module}.py.j2", stubs=[], **context)

    reserved = reserved_names(render)
    application = application_of(model, reserved)
    common = _common(application, reserved, options, chosen)
    generated: dict[str, bytes] = {}
    developer: dict[str, DeveloperFile] = {}
    _plan_interfaces(application, templates, common, generated)
    for node in application.nodes:
        own = dependencies.read_dependencies(workspace, node.package)
        own = own.without(("rclpy", *node.message_packages))
        _plan_node(node, templates, {**common, "dependencies": own}, generated, developer)
    _plan_bringup(application, templates, common, generated, developer)
    if chosen["systemd"]:
        unit = f"src/{application.bringup}/systemd/{application.bringup}.service"
        generated[unit] = templates.render("bringup/app.service.j2", **common)
    if chosen["container"]:
        generated["Containerfile"] = templates.render("bringup/Containerfile.j2", **common)
    head = templates.render("bringup/system_model.xml.j2", **common)
    place = f"src/{application.bringup}/model/{file_name(model.id)}"
    generated[place] = _with_head(xmi_bytes(model), head)
    scripts = _scripts(workspace, options, application, known)
    _plan_tests(scripts, application, templates, common, generated)
    require_short_paths([*generated, *developer])
    manifest = Manifest(
        generator=generator(),
        model=application.id,
        source=options.source,
        settings=options.settings,
        options=chosen,
        interfaces=application.interfaces.package,
        bringup=application.bringup,
        token=_token_fields(application),
        nodes=tuple(_entry(node) for node in application.nodes),
    )
    instances = {
        node.id: {each.id: each.instances for each in node.transitions} for node in application.nodes
    }
    return Plan(manifest, generated, developer, instances)


def _token_fields(app: Application) -> dict[str, str]:
    """Return the fields of all token types, by which handlers are looked through when they change."""
    types = app.interfaces.types
    return {field.name: field.kind for each in reversed(types) for field in each.fields}


def _common(app: Application, reserved: Reserved, options: Options, chosen: dict[str, Any]) -> dict[str, Any]:
    """Return what all templates may use."""
    name, _, address = chosen["maintainer"].removesuffix(">").partition("<")
    return {
        "app": app,
        "lifecycle": chosen["lifecycle"],
        "license": chosen["license"],
        "maintainer": {"name": name.strip(), "email": address.strip()},
        "source": file_name(app.id),
        "settings": options.settings,
        "systemd": chosen["systemd"],
        "token": app.interfaces.token,
        "token_function": app.interfaces.types[0].function,
        "taken": reserved.firings | reserved.tokens,
    }


def _node_context(node: NodePackage, common: dict[str, Any]) -> dict[str, Any]:
    """Return what the templates of a node's package may use."""
    return {**common, "node": node, "executable": executable(node), "imports": _typing(node)}


def executable(node: NodePackage) -> Name:
    """Return the name of a node's program, as ``ros2 run`` takes it."""
    return Name(snake_case(node.name))


def _entry(node: NodePackage) -> NodeEntry:
    return NodeEntry(node.id, node.package, executable(node), node.package, node.name, node.namespace)


def _chosen(workspace: Path, options: Options, known: Manifest | None) -> dict[str, Any]:
    """Return the options that hold: those given, else those of before, else the defaults."""
    chosen = dict(DEFAULTS)
    if known is not None:
        chosen |= {name: value for name, value in known.options.items() if name in DEFAULTS}
    if options.default_templates:
        chosen["templates"] = None
    for name in DEFAULTS:
        given = getattr(options, name)
        if given is not None:
            chosen[name] = given
    if isinstance(chosen["templates"], Path):
        chosen["templates"] = _relative(chosen["templates"], workspace)
    return chosen


def _relative(folder: Path, workspace: Path) -> str:
    """Return a path as seen from the workspace, so that a copy of both finds it."""
    return Path(os.path.relpath(folder.resolve(), workspace.resolve())).as_posix()


def _plan_interfaces(
    app: Application, templates: Templates, common: dict[str, Any], generated: dict[str, bytes]
) -> None:
    root = f"src/{app.interfaces.package}"
    for name in ("CMakeLists.txt", "package.xml"):
        generated[f"{root}/{name}"] = templates.render(f"interfaces/{name}.j2", **common)
    for each in app.interfaces.generated:
        content = templates.render("interfaces/token.msg.j2", type=each, **common)
        generated[f"{root}/msg/{each.name}.msg"] = content
    for entry, type_ in app.interfaces.entries:
        content = templates.render("interfaces/entry.msg.j2", entry=entry, value=type_, **common)
        generated[f"{root}/msg/{entry}.msg"] = content
    for service in app.interfaces.services:
        parts = {"service": service.name, "request": service.request, "response": service.response}
        content = templates.render("interfaces/service.srv.j2", **parts, **common)
        generated[f"{root}/srv/{service.name}.srv"] = content
    for action in app.interfaces.actions:
        parts = {
            "action": action.name,
            "goal": action.goal,
            "result": action.result,
            "feedback": action.feedback,
        }
        content = templates.render("interfaces/action.action.j2", **parts, **common)
        generated[f"{root}/action/{action.name}.action"] = content


def _plan_node(
    node: NodePackage,
    templates: Templates,
    common: dict[str, Any],
    generated: dict[str, bytes],
    developer: dict[str, DeveloperFile],
) -> None:
    root = f"src/{node.package}"
    context = _node_context(node, common)
    module = f"{root}/{node.package}"
    for template, path in (
        ("package.xml", f"{root}/package.xml"),
        ("setup.py", f"{root}/setup.py"),
        ("setup.cfg", f"{root}/setup.cfg"),
        ("marker", f"{root}/resource/{node.package}"),
        ("README.md", f"{root}/README.md"),
        ("__init__.py", f"{module}/__init__.py"),
        ("__main__.py", f"{module}/__main__.py"),
        ("py.typed", f"{module}/py.typed"),
        ("base.py", f"{module}/base.py"),
        ("firings.py", f"{module}/firings.py"),
        ("tokens.py", f"{module}/tokens.py"),
        ("conftest.py", f"{root}/conftest.py"),
        ("test_node.py", f"{root}/test/test_{node.package}.py"),
        ("test_package.pyi", f"{root}/test/__init__.pyi"),
    ):
        generated[path] = templates.render(f"node/{template}.j2", **context)
    head = templates.render("node/runtime_model.xml.j2", **context)
    generated[f"{module}/node.rtm.xmi"] = _with_head(node.runtime_model, head)

    def write_stub(transition: Transition, function: Name, firings: Name) -> Written:
        stub = templates.render(
            "node/stub.py.j2", transition=transition, function=function, firings=firings, **context
        )
        return Written(stub.decode().strip("\n") + "\n")

    developer[f"{module}/handlers.py"] = DeveloperFile(
        templates.render("node/handlers.py.j2", stubs=_stubs(node, write_stub), **context),
        node=node.id,
        package=node.package,
        transitions=node.transitions,
        write_stub=write_stub,
    )
    developer[f"{root}/test/conftest.py"] = DeveloperFile(
        templates.render("node/test_conftest.py.j2", **context), node=node.id, package=node.package
    )
    developer[f"{root}/{dependencies.FILE}"] = DeveloperFile(
        templates.render("node/dependencies.toml.j2", **context), node=node.id, package=node.package
    )


def _typing(node: NodePackage) -> list[Name]:
    """Return what the module `firings` takes from `typing`."""
    names = ["TypeAlias", "TypedDict", "Unpack"]
    if node.transitions:
        names.insert(0, "Literal")
    if len(node.transitions) != 1:
        names.insert(0, "Any")
    if len(node.transitions) > 1:
        names.append("overload")
    return [Name(name) for name in names]


def _stubs(node: NodePackage, write_stub: WriteStub) -> list[Written]:
    return [write_stub(transition, transition.function, Name(FIRINGS)) for transition in node.transitions]


def _plan_bringup(
    app: Application,
    templates: Templates,
    common: dict[str, Any],
    generated: dict[str, bytes],
    developer: dict[str, DeveloperFile],
) -> None:
    root, module = f"src/{app.bringup}", f"src/{app.bringup}/{app.bringup}"
    context = {**common, "executables": {node.id: executable(node) for node in app.nodes}}
    for template, path in (
        ("package.xml", f"{root}/package.xml"),
        ("setup.py", f"{root}/setup.py"),
        ("setup.cfg", f"{root}/setup.cfg"),
        ("marker", f"{root}/resource/{app.bringup}"),
        ("README.md", f"{root}/README.md"),
        ("app.launch.py", f"{root}/launch/{app.launch}"),
        ("__init__.py", f"{module}/__init__.py"),
        ("runner.py", f"{module}/runner.py"),
    ):
        generated[path] = templates.render(f"bringup/{template}.j2", **context)
    for node in app.nodes:
        content = templates.render("bringup/parameters.yaml.j2", node=node, **context)
        generated[f"{root}/config/{node.package}.yaml"] = content
    developer[f"{root}/config/local.yaml"] = DeveloperFile(
        templates.render("bringup/local.yaml.j2", **context), package=app.bringup
    )


def _with_head(document: bytes, head: bytes) -> bytes:
    """Return an XML document with a comment after its declaration."""
    return document.replace(b"?>\n", b"?>\n" + head.strip() + b"\n", 1)


def _scripts(
    workspace: Path, options: Options, app: Application, known: Manifest | None
) -> dict[str, Script]:
    """Return the scripts of the tests there are, and of those asked for, by their paths."""
    root = f"src/{app.bringup}/test/steps"
    scripts = {}
    for path in known.generated if known else ():
        content = ConfinedFolder(workspace).read(path) if path.startswith(f"{root}/") else None
        if content is not None:
            scripts[path] = Script.from_json(workspace / path, content)
    for trace in options.tests:
        script = read_script(trace, app)
        scripts[f"{root}/{script.name}.json"] = script
    return dict(sorted(scripts.items()))


def _plan_tests(
    scripts: dict[str, Script],
    app: Application,
    templates: Templates,
    common: dict[str, Any],
    generated: dict[str, bytes],
) -> None:
    root = f"src/{app.bringup}/test"
    for path, script in scripts.items():
        generated[path] = script.to_json()
        content = templates.render("bringup/test_trace.py.j2", script=script, **common)
        generated[f"{root}/test_{script.name}.py"] = content
    if scripts:
        generated[f"{root}/conftest.py"] = templates.render("bringup/test_conftest.py.j2", **common)
