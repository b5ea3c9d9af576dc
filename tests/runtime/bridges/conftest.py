"""A net, a broker and certificates for the tests of bridges."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from dineros.metamodel import sym
from dineros.runtime.bridges.security import Tls
from dineros.runtime.nodes.net import Net
from dineros.transformations.flattening.split import split
from tests.runtime.bridges.broker import MOSQUITTO, Broker
from tests.support.programs.system_packages import require
from tests.support.systems.talker import talker


@pytest.fixture
def net() -> Iterator[Net]:
    """A node that says its three words once its button is pressed."""
    (part,) = (part for part in split(talker()) if part.node.id == "talker")
    with Net(part) as running:
        yield running


@pytest.fixture
def pair() -> Iterator[Net]:
    """The same with a second signal, the bell."""
    model = talker()
    (node,) = (page for page in model.pages if isinstance(page, sym.NodeNet) and page.id == "talker")
    node.signals.append(sym.InputSignal(id="Bell"))
    (part,) = (part for part in split(model) if part.node.id == "talker")
    with Net(part) as running:
        yield running


@pytest.fixture
def moded() -> Iterator[Net]:
    """The first with a second signal that has values."""
    model = talker()
    (node,) = (page for page in model.pages if isinstance(page, sym.NodeNet) and page.id == "talker")
    values = [sym.SignalValue(name=each) for each in ("mute", "low", "loud")]
    node.signals.append(sym.InputSignal(id="Mode", values=values))
    (part,) = (part for part in split(model) if part.node.id == "talker")
    with Net(part) as running:
        yield running


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Broker]:
    if MOSQUITTO is None:
        require("mosquitto")
    made = Broker(tmp_path)
    yield made
    made.stop()


@pytest.fixture(scope="session")
def certificates(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with ca.pem, server.pem for 127.0.0.1, client.pem, and other.pem of another authority."""
    if os.environ.get("CI"):
        import trustme
    else:
        trustme = pytest.importorskip("trustme")
    folder = tmp_path_factory.mktemp("certificates")
    authority, other = trustme.CA(), trustme.CA()
    authority.cert_pem.write_to_path(folder / "ca.pem")
    other.cert_pem.write_to_path(folder / "other.pem")
    for name in ("server", "client"):
        made = authority.issue_cert("127.0.0.1", "localhost")
        made.private_key_and_cert_chain_pem.write_to_path(folder / f"{name}.pem")
    return folder


@pytest.fixture
def server_tls(certificates: Path) -> Tls:
    return Tls(certificate=certificates / "server.pem", key=certificates / "server.pem")
