"""Plans a ROS 2 workspace, from a system model and options."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dineros.generators.application.application import Application, NodePackage, Transition
from dineros.generators.application.collecting import application_of
from dineros.generators.application.naming import (
    NOTHING_RESERVED,
    Reserved,
    require_lifecycle_names,
    require_short_paths,
)
from dineros.generators.application.reserved import reserved_names
from dineros.generators.templates.filters import Name, Written
from dineros.generators.templates.rendering import TemplateError, Templates, generator
from dineros.generators.workspace import dependencies
from dineros.generators.workspace.handwritten import FIRINGS
from dineros.generators.workspace.manifest import Manifest, NodeEntry
from dineros.generators.workspace.plan import DeveloperFile, Plan
from dineros.generators.workspace.scripts import Script, read_script
from dineros.generators.workspace.system_model import file_name
from dineros.metamodel import sym
from dineros.metamodel.errors import Location
from dineros.metamodel.files.confined import ConfinedFolder
from dineros.metamodel.files.reading import resolved
from dineros.metamodel.files.xmi import xmi_bytes
from dineros.metamodel.ros_names import snake_case


@dataclass(frozen=True)
class Options:
    """Options of the generation.

    Attributes
    ----------
    source : str
        Name of the model's file, for the manifest.
    settings : tuple of str
        Settings that changed the model by ``--set``, for the manifest and for traces.
    lifecycle : bool or None
        Whether nodes are lifecycle nodes; None: as in the previous generation, else plain nodes.
    templates : Path or None
        Folder with templates that override built-in ones; required again if the workspace was generated with
        one.
    default_templates : bool
        Whether such a workspace returns to the built-in templates.
    maintainer, license : str or None
        For the packages' ``package.xml``, the maintainer as ``Name <address>``; None: as before.
    systemd, container : bool or None
        Whether to generate a unit of systemd, and a Containerfile; None: as before, else not.
    tests : tuple of Path
        Witnesses and recorded runs from which tests are written.
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
    "license": "TODO: License declaration",  # as `ros2 pkg create` writes
    "maintainer": "TODO <todo@example.org>",
    "systemd": False,
    "templates": None,
}


def plan(model: sym.SystemModel, workspace: Path, options: Options, known: Manifest | None) -> Plan:
    """Return the plan of a workspace, given its manifest."""
    chosen = _chosen(workspace, options, known)
    folder = options.templates
    if folder is None and chosen["templates"]:
        # Templates are programs, and the manifest that names their folder is untrusted.
        raise TemplateError(
            f"was generated with the templates of {chosen['templates']!r:.200}, which must be given again",
            location=Location(workspace),
            hint="use --templates DIR, or --default-templates for the built-in templates",
        )
    templates = Templates(model.id, folder)
    if chosen["lifecycle"]:
        require_lifecycle_names(model)

    def render(app: Application, module: str) -> bytes:
        probe = _Files(app, templates, _common(app, NOTHING_RESERVED, options, chosen))
        return probe.render(f"node/{module}.py", stubs=[], **_node_context(app.nodes[0]))

    reserved = reserved_names(render)
    application = application_of(model, reserved)
    files = _Files(application, templates, _common(application, reserved, options, chosen))
    files.add_interfaces()
    for node in application.nodes:
        own = dependencies.read_dependencies(workspace, node.package)
        files.add_node(node, own.without(("rclpy", *node.message_packages)))
    files.add_bringup()
    root = f"src/{application.bringup}"
    if chosen["systemd"]:
        files.add(f"{root}/systemd/{application.bringup}.service", "bringup/app.service")
    if chosen["container"]:
        files.add("Containerfile", "bringup/Containerfile")
    files.add_document(f"{root}/model/{file_name(model.id)}", "bringup/system_model.xml", xmi_bytes(model))
    files.add_tests(_scripts(workspace, options, application, known))
    require_short_paths([*files.generated, *files.developer])
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
    return Plan(manifest, files.generated, files.developer, instances)


def _token_fields(app: Application) -> dict[str, str]:
    """Return the fields of all token types, to be searched in handlers when they change."""
    types = app.interfaces.types
    return {field.name: field.kind for each in reversed(types) for field in each.fields}


def _common(app: Application, reserved: Reserved, options: Options, chosen: dict[str, Any]) -> dict[str, Any]:
    """Return the values that all templates may use."""
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


def _node_context(node: NodePackage) -> dict[str, Any]:
    """Return the additional values for the templates of a node's package."""
    return {"node": node, "executable": executable(node), "imports": _typing(node)}


def executable(node: NodePackage) -> Name:
    """Return the name of a node's executable, for ``ros2 run``."""
    return Name(snake_case(node.name))


def _entry(node: NodePackage) -> NodeEntry:
    return NodeEntry(node.id, node.package, executable(node), node.package, node.name, node.namespace)


def _chosen(workspace: Path, options: Options, known: Manifest | None) -> dict[str, Any]:
    """Return the effective options: given ones, else previous ones, else the defaults."""
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
    """Return a path relative to the workspace, so that it stays valid in a copy of both."""
    return Path(os.path.relpath(resolved(folder), resolved(workspace))).as_posix()


class _Files:
    """The files of a workspace, rendered from their templates.

    Parameters
    ----------
    app : Application
        The application.
    templates : Templates
        The templates.
    common : dict
        Values that all templates may use.

    Attributes
    ----------
    generated, developer : dict
        As in a `Plan`.
    """

    def __init__(self, app: Application, templates: Templates, common: dict[str, Any]) -> None:
        self._app, self._templates, self._common = app, templates, common
        self.generated: dict[str, bytes] = {}
        self.developer: dict[str, DeveloperFile] = {}

    def render(self, template: str, **more: Any) -> bytes:
        """Return the output of a template, with additional values."""
        return self._templates.render(f"{template}.j2", **self._common, **more)

    def add(self, path: str, template: str, **more: Any) -> None:
        """Add a generated file."""
        self.generated[path] = self.render(template, **more)

    def add_document(self, path: str, template: str, document: bytes, **more: Any) -> None:
        """Add an XML document with a comment after its declaration."""
        head = self.render(template, **more).strip()
        self.generated[path] = document.replace(b"?>\n", b"?>\n" + head + b"\n", 1)

    def add_interfaces(self) -> None:
        """Add the interface package."""
        interfaces = self._app.interfaces
        root = f"src/{interfaces.package}"
        for name in ("CMakeLists.txt", "package.xml"):
            self.add(f"{root}/{name}", f"interfaces/{name}")
        for each in interfaces.generated:
            self.add(f"{root}/msg/{each.name}.msg", "interfaces/token.msg", type=each)
        for entry, type_ in interfaces.entries:
            self.add(f"{root}/msg/{entry}.msg", "interfaces/entry.msg", entry=entry, value=type_)
        for service in interfaces.services:
            parts = {"service": service.name, "request": service.request, "response": service.response}
            self.add(f"{root}/srv/{service.name}.srv", "interfaces/service.srv", **parts)
        for action in interfaces.actions:
            parts = {"goal": action.goal, "result": action.result, "feedback": action.feedback}
            path = f"{root}/action/{action.name}.action"
            self.add(path, "interfaces/action.action", action=action.name, **parts)

    def add_node(self, node: NodePackage, own: dependencies.Dependencies) -> None:
        """Add the package of a node, with the dependencies of its handlers."""
        root = f"src/{node.package}"
        module = f"{root}/{node.package}"
        context = {**_node_context(node), "dependencies": own}
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
            self.add(path, f"node/{template}", **context)
        self.add_document(f"{module}/node.rtm.xmi", "node/runtime_model.xml", node.runtime_model, **context)

        def write_stub(transition: Transition, function: Name, firings: Name) -> Written:
            more = {"transition": transition, "function": function, "firings": firings}
            return Written(self.render("node/stub.py", **more, **context).decode().strip("\n") + "\n")

        stubs = [write_stub(each, each.function, Name(FIRINGS)) for each in node.transitions]
        handlers = self.render("node/handlers.py", stubs=stubs, **context)
        self.developer[f"{module}/handlers.py"] = DeveloperFile(
            handlers, node.id, node.package, node.transitions, write_stub
        )
        for path, template in (
            (f"{root}/test/conftest.py", "node/test_conftest.py"),
            (f"{root}/{dependencies.FILE}", "node/dependencies.toml"),
        ):
            self.developer[path] = DeveloperFile(self.render(template, **context), node.id, node.package)

    def add_bringup(self) -> None:
        """Add the package that starts the nodes."""
        bringup = self._app.bringup
        root = f"src/{bringup}"
        executables = {node.id: executable(node) for node in self._app.nodes}
        for template, path in (
            ("package.xml", f"{root}/package.xml"),
            ("setup.py", f"{root}/setup.py"),
            ("setup.cfg", f"{root}/setup.cfg"),
            ("marker", f"{root}/resource/{bringup}"),
            ("README.md", f"{root}/README.md"),
            ("app.launch.py", f"{root}/launch/{self._app.launch}"),
            ("__init__.py", f"{root}/{bringup}/__init__.py"),
            ("runner.py", f"{root}/{bringup}/runner.py"),
        ):
            self.add(path, f"bringup/{template}", executables=executables)
        for node in self._app.nodes:
            self.add(f"{root}/config/{node.package}.yaml", "bringup/parameters.yaml", node=node)
        local = DeveloperFile(self.render("bringup/local.yaml"), package=bringup)
        self.developer[f"{root}/config/local.yaml"] = local

    def add_tests(self, scripts: dict[str, Script]) -> None:
        """Add tests that run the nodes through the scripts, by path."""
        root = f"src/{self._app.bringup}/test"
        for path, script in scripts.items():
            self.generated[path] = script.to_json()
            self.add(f"{root}/test_{script.name}.py", "bringup/test_trace.py", script=script)
        if scripts:
            self.add(f"{root}/conftest.py", "bringup/test_conftest.py")


def _typing(node: NodePackage) -> list[Name]:
    """Return the names that the module `firings` imports from `typing`."""
    names = ["TypeAlias", "TypedDict", "Unpack"]
    if node.transitions:
        names.insert(0, "Literal")
    if len(node.transitions) != 1:
        names.insert(0, "Any")
    if len(node.transitions) > 1:
        names.append("overload")
    return [Name(name) for name in names]


def _scripts(
    workspace: Path, options: Options, app: Application, known: Manifest | None
) -> dict[str, Script]:
    """Return the scripts of existing and of requested tests, by path."""
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
