"""Models to run commands on, and the running itself."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from dineros.cli.main import main
from dineros.metamodel.files import save
from tests.support.programs.commands import NETS
from tests.support.systems.talker import talker

Run = Callable[..., Result]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch) -> Run:
    """Run the command line in this process; results have `exit_code`, `stdout` and `stderr`."""
    monkeypatch.delenv("DINEROS_DEBUG", raising=False)

    def invoke(*arguments: object) -> Result:
        return CliRunner().invoke(main, [str(argument) for argument in arguments])

    return invoke


@pytest.fixture
def model(tmp_path: Path) -> Path:
    """Return the file of a valid system model."""
    path = tmp_path / "greeting.sym.xmi"
    save(talker(), path)
    return path


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    """Return the file of a system model with a publisher that keeps nothing, which is an error."""
    net = talker()
    net.channels[0].publishers[0].limit = 0  # type: ignore[attr-defined]
    path = tmp_path / "broken.sym.xmi"
    save(net, path)
    return path


@pytest.fixture
def doubtful(tmp_path: Path) -> Path:
    """Return the file of a system model whose subscriber stands in no callback page, which is a warning."""
    net = talker()
    callback = net.pages[1].objects[0]
    listener = net.pages[1]
    for node in list(callback.objects):  # type: ignore[attr-defined]
        listener.objects.append(node)
    for arc in list(callback.arcs):  # type: ignore[attr-defined]
        listener.arcs.append(arc)
    listener.objects.remove(callback)
    path = tmp_path / "doubtful.sym.xmi"
    save(net, path)
    return path


@pytest.fixture
def net(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """Return the file of one of the nets."""
    path = tmp_path / f"{request.param}.net"
    path.write_text(NETS[request.param], encoding="utf-8")
    return path
