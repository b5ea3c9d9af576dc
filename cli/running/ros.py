"""An application on ROS 2: one process per node, supervised, each with its own trace."""

from __future__ import annotations

import hashlib
import json
import os
import shlex
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from dineros.cli.console import note, summarise, warn, working
from dineros.cli.options import cache_folder
from dineros.cli.running.announcing import Announcer
from dineros.cli.running.watching import Ending, RosOptions, Wanted, observe_all, watch
from dineros.metamodel.clauses import setting_text
from dineros.metamodel.files import save
from dineros.metamodel.files.locking import held
from dineros.metamodel.files.reading import open_plain, resolved
from dineros.runtime.application.observer import FolderObserver
from dineros.runtime.application.remote import RemoteNode
from dineros.runtime.application.supervisor import (
    CANNOT_START,
    ProcessEvent,
    ProcessPlan,
    RestartPolicy,
    SupervisionError,
    Supervisor,
    status_text,
)

if TYPE_CHECKING:
    from dineros.cli.running.applications import Application
    from dineros.metamodel import sym
    from dineros.runtime.nets.ports import Ports
    from dineros.views.live import Steering

SUPERVISOR_LOG = "supervisor.log.jsonl"
"""File next to the traces with the starts and ends of processes, one JSON object per line."""


Commands = list[tuple[str, list[str]]]
"""Each node's name and the command that starts it, up to its ROS arguments."""


def run_on_ros(
    application: Application,
    wanted: Wanted,
    observer: FolderObserver,
    options: RosOptions,
    steering: Steering | None = None,
) -> Ending:
    """Run one process per node, and the further programs, until the run ends.

    `steering`: gets the nodes, for pages that steer them; without it, their processes get no line to this
    one.

    Raises
    ------
    DinerosError
        The interfaces cannot be built.
    """
    if application.system is None:
        commands, variables = _workspace_processes(application.source)
    else:
        commands, variables = _model_processes(application, application.system, wanted.folder)
    run = {model.node.id for model in application.models}
    commands = [(name, command) for name, command in commands if name in run]
    for name, command in commands:
        command.extend(_stale_parameters(application, name))
    from dineros.runtime.nets.structure import read_structure

    nodes = {model.node.id: read_structure(model).ports for model in application.models}
    remotes = {} if steering is None else {node: RemoteNode(node) for node in nodes}
    if steering is not None:
        steering.take(remotes)
    try:
        return _run_processes(commands, variables, nodes, wanted, observer, options, remotes)
    finally:
        for remote in remotes.values():
            remote.close()


def _stale_parameters(application: Application, node: str) -> list[str]:
    """Return the parameters for the time after which the signals of a node are stale."""
    from dineros.metamodel.ros_names import resource_names

    names = resource_names(
        signal.id for model in application.models if model.node.id == node for signal in model.node.signals
    )
    parameters: list[str] = []
    for signal, expectation in application.expected.get(node, {}).items():
        then = setting_text(expectation.then)
        parameters += ["-p", f"stale_after.{names[signal]}:={float(expectation.seconds)!r}"]
        parameters += ["-p", f"when_stale.{names[signal]}:={then}"]
    return parameters


def _workspace_processes(workspace: Path) -> tuple[Commands, dict[str, str]]:
    from dineros.generators.workspace.building import build_interfaces, environment, manifest_of

    manifest = manifest_of(workspace)
    with working("Building the interfaces"), held(workspace):
        build_interfaces(workspace)
    config = workspace.resolve() / "src" / manifest.bringup / "config"
    commands: Commands = []
    for node in manifest.nodes:
        files = [config / f"{node.package}.yaml", config / "local.yaml"]
        parameters = [part for file in files if file.is_file() for part in ("--params-file", str(file))]
        commands.append((node.node, [sys.executable, "-P", "-m", node.package, "--ros-args", *parameters]))
    variables = environment(workspace)
    # Packages that developers put next to the generated ones are found as well.
    known = variables.get("PYTHONPATH", "").split(os.pathsep)
    others = [str(path) for path in sorted((workspace.resolve() / "src").iterdir()) if path.is_dir()]
    variables["PYTHONPATH"] = os.pathsep.join([*known, *(path for path in others if path not in known)])
    return commands, variables


def _model_processes(
    application: Application, system: sym.SystemModel, folder: Path
) -> tuple[Commands, dict[str, str]]:
    """Build the interfaces in the user's cache, once for all runs with equal ones."""
    from dineros.generators import Options, generate
    from dineros.generators.workspace.building import build_interfaces, environment

    workspace = _cached_workspace(system)
    workspace.mkdir(parents=True, exist_ok=True)
    # Other nodes of the model may start in another run at the same time.
    with working("Building the interfaces"), held(workspace):
        generate(system, workspace, Options(source=application.source.name))
        build_interfaces(workspace)
    expected = _expected(system)
    commands: Commands = []
    for model in application.models:
        path = folder / "models" / f"{model.node.id}.rtm.xmi"
        path.parent.mkdir(parents=True, exist_ok=True)
        save(model, path)
        command = [sys.executable, "-P", "-m", "dineros.runtime.ros.node_main", str(path.resolve())]
        command += ["--source", str(application.source.resolve())]
        command += [word for setting in application.settings for word in ("--set", setting)]
        if application.handlers is not None:
            command += ["--handlers", str(application.handlers.resolve())]
        commands.append((model.node.id, [*command, "--ros-args", *expected[model.node.id]]))
    return commands, environment(workspace)


def _cached_workspace(system: sym.SystemModel) -> Path:
    """Return the folder in which the interfaces of a model are built.

    Its name has a hash of the interfaces and of the installed Python. So a run does not replace the
    interfaces of another run, if their models have the same id.
    """
    from dineros.generators.application.interfaces import interfaces_of

    interfaces = json.dumps(asdict(interfaces_of(system)), default=sorted)  # sets have no order
    key = hashlib.sha256(f"{interfaces} {sys.version} {sys.prefix}".encode()).hexdigest()[:12]
    return cache_folder() / "workspaces" / f"{system.id}-{key}"


def _expected(system: sym.SystemModel) -> dict[str, list[str]]:
    """Return the parameters by which each node waits at its start for subscribers."""
    from dineros.generators.application.collecting import application_of

    return {
        node.id: [
            word
            for name, subscribers in node.published
            for word in ("-p", f"expected_subscribers.{name}:={subscribers}")
        ]
        for node in application_of(system).nodes
    }


def _start_arguments(nodes: Mapping[str, Ports]) -> list[str]:
    """Return the arguments of the manager of managed nodes, in the start order."""
    from dineros.metamodel.lifecycles.start_order import in_order, start_argument

    steps = [(step, what, ports) for ports in nodes.values() for what, step in ports.start_steps.items()]
    return [
        start_argument(what, ports.namespace, ports.name)
        for _, what, ports in sorted(steps, key=lambda each: in_order(each[:2]))
    ]


def _run_processes(
    commands: Commands,
    variables: dict[str, str],
    nodes: Mapping[str, Ports],
    wanted: Wanted,
    observer: FolderObserver,
    options: RosOptions,
    remotes: Mapping[str, RemoteNode],
) -> Ending:
    from dineros.runtime.ros.process.environment import ros_environment
    from dineros.runtime.ros.process.memory import remove_abandoned

    folder = resolved(wanted.folder)
    variables = ros_environment(folder / "ros", options.domain, options.reach, variables)
    own = ["-p", f"journal:={folder}"]
    own += [] if wanted.options.watchdog is None else ["-p", f"watchdog:={wanted.options.watchdog!r}"]
    own += [] if wanted.options.seed is None else ["-p", f"seed:={wanted.options.seed}"]
    plans = [
        ProcessPlan(
            name,
            [*command, *own, "-p", f"resume:={str(wanted.options.is_resumed).lower()}"],
            variables,
            folder / f"{name}.log",
            resume=["-p", "resume:=true"],
            connect=remotes[name].connect if name in remotes else None,
            starts_together=True,
        )
        for name, command in commands
    ]
    steps = _start_arguments(nodes)
    if steps:
        command = [sys.executable, "-P", "-m", "dineros.runtime.ros.bringup", *steps]
        plans.append(ProcessPlan("bringup", command, variables, folder / "bringup.log", is_last=True))
    for number, program in enumerate(options.programs, 1):
        name = f"program-{number}"
        printed = folder / f"{name}.log"
        plans.append(ProcessPlan(name, _words(program), variables, printed, is_last=True))
    folder.mkdir(parents=True, exist_ok=True)
    flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND
    descriptor = open_plain(folder / SUPERVISOR_LOG, flags, follow_links=False)
    with os.fdopen(descriptor, "a", encoding="utf-8") as log:
        announcer = Announcer(nodes, variables, folder / "announcer.log")
        tell = _teller(log, announcer, remotes, observer)
        policy, logs = RestartPolicy(restarts=options.restarts), Path(variables["ROS_LOG_DIR"])
        supervisor = Supervisor(plans, policy, tell, logs)
        try:
            with supervisor:
                return watch(wanted, observer, supervisor)
        except SupervisionError as error:
            warn(str(error))
            return "failed"
        finally:
            announcer.close()
            observer.restarts = supervisor.restarts
            observe_all(wanted, observer)  # what the nodes wrote while they ended
            remove_abandoned()


def _teller(
    log: TextIO, announcer: Announcer, remotes: Mapping[str, RemoteNode], observer: FolderObserver
) -> Callable[[ProcessEvent], None]:
    """Return a function that stores events, and prints the important ones."""

    def tell(event: ProcessEvent) -> None:
        log.write(json.dumps(asdict(event)) + "\n")
        log.flush()
        announcer.tell(event)
        if event.name in remotes:
            remotes[event.name].tell(event)
        # The run may end while a process still tries to start: it is stopped, but it had already failed.
        cannot_start = event.event in ("failed", "stopped") and event.status == CANNOT_START
        if cannot_start:
            observer.refused.add(event.name)
        if event.event == "failed" or cannot_start:
            warn(
                f"{event.name} ended with {status_text(event.status)}{': ' if event.said else ''}{event.said}"
            )
        elif event.event == "restarted":
            summarise(f"{event.name} is started again, process {event.process}")
        else:
            note(f"{time.strftime('%H:%M:%S', time.localtime(event.time))} {event.name} {event.event}")

    return tell


def _words(program: str) -> list[str]:
    """Return the words of a command line; ``python`` is the interpreter that runs this."""
    words = shlex.split(program)
    return [sys.executable, *words[1:]] if words[:1] == ["python"] else words
