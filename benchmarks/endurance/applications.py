"""The applications of this repository as benchmarks run them: whole workspaces, with their worlds."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from dineros.generators import Options, generate
from dineros.metamodel import sym
from dineros.metamodel.files import load
from dineros.metamodel.settings import apply

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Application:
    """What is stopped and killed.

    Attributes
    ----------
    model : Path
        Its system model.
    handlers : Path
        Folder of its workspace, or of modules ``PACKAGE.py`` that become the handlers of a new one.
    beside : str
        Program that runs next to the nodes.
    work : tuple of str
        Places where pieces of work wait.
    node, done : str
        Node and place where the work is in the end.
    """

    model: Path
    handlers: Path
    beside: str
    work: tuple[str, ...]
    node: str
    done: str

    def settings(self, pieces: int) -> list[str]:
        """Return the settings of the model for so many pieces of work at each place where they wait."""
        return [f"{place}.tokens={pieces}" for place in self.work]

    def workspace(self, folder: Path, settings: Sequence[str]) -> None:
        """Generate the workspace around the handlers."""
        if (self.handlers / "src").is_dir():
            unwanted = shutil.ignore_patterns("build", "install", "log", "__pycache__")
            shutil.copytree(self.handlers, folder, ignore=unwanted)
        model = self.model_with(settings)
        generate(model, folder, Options(source=self.model.name))
        for path in self.handlers.glob("*.py"):
            shutil.copy(path, folder / "src" / path.stem / path.stem / "handlers.py")

    @property
    def lossy(self) -> frozenset[str]:
        """Topics on which nothing is sent again: their messages may be lost."""
        model = load(self.model)
        assert isinstance(model, sym.SystemModel)
        return frozenset(
            channel.id
            for channel in model.channels
            if isinstance(channel, sym.TopicChannel)
            and channel.qos is not None
            and channel.qos.reliability == sym.Reliability.bestEffort
        )

    def model_with(self, settings: Sequence[str]) -> sym.SystemModel:
        """Return the model with settings."""
        model = load(self.model)
        assert isinstance(model, sym.SystemModel)
        for setting in settings:
            apply(model, setting)
        return model


APPLICATIONS = {
    "sorting": Application(
        ROOT / "case_study/sorting.sym.xmi",
        ROOT / "case_study/workspace",
        "python -m sorting_cell --motion-time 0.1 --visit 3 --visit 7",
        ("RedObjects", "BlueObjects", "GreenObjects"),
        "feedback",
        "Shown",
    ),
    "fleet": Application(
        ROOT / "examples/fleet/fleet.sym.xmi",
        ROOT / "examples/fleet/handlers",
        f"python {ROOT / 'examples/fleet/world.py'}",
        ("Orders",),
        "dispatcher",
        "Closed",
    ),
    "mobile_robot": Application(
        ROOT / "examples/mobile_robot/mobile_robot.sym.xmi",
        ROOT / "examples/mobile_robot/handlers",
        f"python {ROOT / 'examples/mobile_robot/world.py'}",
        ("Waypoints",),
        "mission",
        "Closed",
    ),
    "sorting_actions": Application(
        ROOT / "examples/sorting_actions/cell.sym.xmi",
        ROOT / "examples/sorting_actions/handlers",
        f"python {ROOT / 'examples/sorting_actions/cell.py'} --motion-time 0.1 --visit-every 3 --stay 0.3",
        ("RedPieces", "BluePieces", "GreenPieces"),
        "display",
        "Shown",
    ),
}
