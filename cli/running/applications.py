"""The application to run: a system model with a file of handlers, or a generated workspace."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.metamodel.errors import DinerosError, Location

if TYPE_CHECKING:
    from dineros.analysis.conformance import Monitor
    from dineros.analysis.logic.language.conditions import Condition
    from dineros.metamodel import rtm, sym
    from dineros.runtime.nets.staleness import Expectation


@dataclass(frozen=True)
class Application:
    """What is run."""

    source: Path
    """The model's file or the workspace's folder, as the user named it."""
    system: sym.SystemModel | None
    """The system model; None for a workspace, whose model is read when needed."""
    models: tuple[rtm.RuntimeModel, ...]
    """One per node."""
    handlers: Path | None
    settings: tuple[str, ...]
    expected: dict[str, dict[str, Expectation]] = field(default_factory=dict)
    """Node -> id of a signal -> how long its source may be silent, and what is done then."""

    @property
    def title(self) -> str:
        """Its title."""
        return str(self.source)

    def condition(self, text: str) -> Condition:
        """Return a condition on its places and signals.

        Raises
        ------
        FormulaError
            It is not a condition, or names something unknown.
        """
        from dineros.analysis.logic.language.conditions import Condition
        from dineros.runtime.nets.structure import read_structure

        structures = [read_structure(model) for model in self.models]
        return Condition(
            text,
            [place for structure in structures for place in structure.places],
            [name for each in structures for signal in each.ports.signals for name in signal.formula_names],
        )

    def monitor(self) -> Monitor:
        """Return the monitor that replays its run on the model.

        Raises
        ------
        DinerosError
            It is a workspace that does not hold the system model.
        """
        from dineros.analysis.conformance import Monitor

        return Monitor(self.system_model())

    def system_model(self) -> sym.SystemModel:
        """Return the system model.

        Raises
        ------
        DinerosError
            It is a workspace that does not hold the system model.
        """
        from dineros.cli.models import load_system

        return self.system or load_system(self.source)


def application_of(
    path: Path, settings: Sequence[str], handlers: Path | None, stale_after: Sequence[str] = ()
) -> Application:
    """Read an application; `stale_after` are texts such as ``Door=2.5:false``.

    Raises
    ------
    DinerosError
        The file or folder holds nothing that can run, or the options do not fit it.
    """
    if path.is_dir():
        if settings or handlers is not None:
            raise DinerosError(
                "the workspace contains the model and the handlers",
                location=Location(path),
                hint="generate it again for a changed model",
            )
        parts = tuple(_workspace_models(path))
        return Application(path, None, parts, None, (), _expected(parts, stale_after))
    from dineros.cli.models import load_valid_system
    from dineros.transformations.flattening.split import split

    system = load_valid_system(path, settings)
    beside = path.with_name("handlers.py")
    if handlers is None and beside.is_file():
        handlers = beside
    parts = tuple(split(system))
    return Application(path, system, parts, handlers, tuple(settings), _expected(parts, stale_after))


def some_of(application: Application, only: Sequence[str], without: Sequence[str]) -> Application:
    """Return an application with some of its nodes; the others run elsewhere, or not at all.

    Parameters
    ----------
    application : Application
        With all nodes.
    only, without : sequence of str
        Nodes to run, by default all, and nodes to omit: by id, or by the full name in ROS.

    Raises
    ------
    DinerosError
        There is no such node, or none is left.
    """
    from dineros.metamodel.errors import UnknownElementError, near_matches
    from dineros.runtime.nets.structure import read_structure

    ids: dict[str, str] = {}
    for model in application.models:
        ports = read_structure(model).ports
        ids |= {str(model.node.id): str(model.node.id)}
        ids.setdefault(f"{(ports.namespace or '').rstrip('/')}/{ports.name}", str(model.node.id))
    for name in (*only, *without):
        if name not in ids:
            raise UnknownElementError(
                f"there is no node {name!r}",
                location=Location(application.source),
                hint=near_matches(name, ids),
            )
    wanted = {ids[name] for name in only} or set(ids.values())
    wanted -= {ids[name] for name in without}
    if not wanted:
        raise DinerosError("no node remains to be run", hint="name fewer nodes with --without")
    models = tuple(model for model in application.models if model.node.id in wanted)
    expected = {node: found for node, found in application.expected.items() if node in wanted}
    return replace(application, models=models, expected=expected)


def _expected(
    models: Sequence[rtm.RuntimeModel], stale_after: Sequence[str]
) -> dict[str, dict[str, Expectation]]:
    from dineros.metamodel.errors import UnknownElementError, near_matches
    from dineros.runtime.nets.staleness import parse_expectation
    from dineros.runtime.nets.structure import read_structure

    if not stale_after:
        return {}
    ports = {
        signal.id: (model.node.id, signal.values)
        for model in models
        for signal in read_structure(model).ports.signals
    }
    expected: dict[str, dict[str, Expectation]] = {}
    for text in stale_after:
        signal, equals, value = text.partition("=")
        if not equals:
            raise DinerosError(f"--stale-after {text!r} gives no time", hint="such as Door=2.5:false")
        if signal not in ports:
            raise UnknownElementError(
                f"no node has a signal {signal!r}", hint=near_matches(signal, list(ports))
            )
        node, values = ports[signal]
        expectation = parse_expectation(value)
        expectation.require(values)
        expected.setdefault(node, {})[signal] = expectation
    return expected


def _workspace_models(workspace: Path) -> list[rtm.RuntimeModel]:
    from dineros.generators.workspace.building import manifest_of
    from dineros.metamodel import rtm
    from dineros.metamodel.files import load

    models = []
    for node in manifest_of(workspace).nodes:
        path = workspace / "src" / node.package / node.package / "node.rtm.xmi"
        model = load(path)
        if not isinstance(model, rtm.RuntimeModel):
            raise DinerosError("holds no runtime model", location=Location(path))
        models.append(model)
    return models
