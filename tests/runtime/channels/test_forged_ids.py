"""Messages with ids that nobody would give: counted and dropped, while the true sender is heard."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.runtime.channels.local import LocalNetwork
from dineros.runtime.journal import JournalRecorder, resume_journal
from dineros.runtime.journal.recording import Recorder
from dineros.runtime.nets.ports import Message
from dineros.runtime.nodes.net import Net
from dineros.runtime.nodes.node import Node
from dineros.transformations.flattening.split import split
from tests.runtime.channels.test_services import clause_free, serving
from tests.support.systems.talker import talker

DIGITS = "9" * 5000


def listening(recorder: Recorder | None = None, **options: object) -> tuple[Net, Node]:
    (part,) = (part for part in split(talker()) if part.node.id == "listener")
    net = Net(part)
    node = Node(net, LocalNetwork().transport(), recorder, **options)  # type: ignore[arg-type]
    node.open()
    return net, node


def hear(node: Node, *ids: str, lost: int = 0) -> None:
    for id in ids:
        node.receiver.message_arrived(node.net.structure.ports.subscribers[0], Message(id, {}), lost)
        node.run_until_idle()


def test_implausible_ids_are_counted_and_said_once(caplog: pytest.LogCaptureFixture) -> None:
    net, node = listening()
    for _ in range(3):
        hear(node, f"talker/Said/{DIGITS}", "talker/Said/-1", "x" * 100_000, "a\nforged line/1")
    hear(node, "talker/Said/1")
    state = net.inspect()
    assert (state.count("Noted"), dict(state.refused), len(state.errors)) == (1, {"Chatter": 12}, 1)
    assert caplog.text.count("is dropped") == 1
    assert len(caplog.text) < 1000
    node.close()


def test_data_that_does_not_fit_is_counted_and_said_once(caplog: pytest.LogCaptureFixture) -> None:
    net, node = listening()
    for number in range(1, 1001):
        port = node.net.structure.ports.subscribers[0]
        node.receiver.message_arrived(port, Message(f"talker/Said/{number}", {"unknown": 1}), 0)
        node.run_until_idle()
    state = net.inspect()
    assert (state.count("Noted"), sum(state.refused.values()), len(state.errors)) == (0, 1000, 1)
    assert "does not fit the token type" in caplog.text and len(caplog.text) < 1000
    node.close()


def test_requests_wait_in_limited_number_where_no_depth_is_known(caplog: pytest.LogCaptureFixture) -> None:
    net, node, _, _ = serving(instances=1)
    clause_free(net)  # it does not end what it serves
    node.open()
    port = node.net.structure.ports.servers[0]
    for number in range(1, 2000):
        node.receiver.request_arrived(port, Message(f"c/request/{number}", {}), lambda response: None)
        node.run_until_idle()
    assert node.exchange is not None
    server = node.exchange.servers[port]
    assert len(server.waiting) == 1000
    assert sum(net.inspect().refused.values()) == 1999 - 1001
    assert caplog.text.count("requests wait already") == 1
    node.close()


def test_forged_id_takes_one_number_only() -> None:
    net, node = listening()
    hear(node, "talker/Said/1", "talker/Said/1000000", "talker/Said/9", "talker/Said/2", "talker/Said/2")
    assert net.count("Noted") == 4
    hear(node, "talker/Said/1000000", "talker/Said/3")
    assert net.count("Noted") == 5
    node.close()


def test_what_was_lost_and_counted_does_not_come_later() -> None:
    """A publisher that continues after a crash sends its last messages again, also those recorded as lost."""
    net, node = listening()
    hear(node, "talker/Said/1")
    hear(node, "talker/Said/4", lost=2)
    hear(node, *(f"talker/Said/{number}" for number in range(1, 6)))
    assert net.count("Noted") == 3
    node.close()


def test_journal_keeps_the_rule(tmp_path: Path) -> None:
    _, node = listening(JournalRecorder(tmp_path, "listener"))
    hear(node, "talker/Said/1", "talker/Said/1000000")
    hear(node, "talker/Said/5", lost=3)
    saved = node.checkpoint()
    assert saved["seen"] == {"Chatter/Heard": {"talker/Said": 5}}
    assert saved["seen_apart"] == {"Chatter/Heard": {"talker/Said": [[1000000, 1000000]]}}
    node.close()
    recorder, resume = resume_journal(tmp_path, "listener")
    assert resume is not None
    assert (resume["seen"], resume["seen_apart"]) == (saved["seen"], saved["seen_apart"])
    net, again = listening(recorder, resume=resume)
    hear(again, "talker/Said/3", "talker/Said/1000000", "talker/Said/6")
    assert net.count("Noted") == 4
    again.close()


def test_forged_requests() -> None:
    net, node, asked, _ = serving(instances=1)
    node.open()

    def ask(id: str) -> None:
        asked.ask(id, count=1)
        node.run_until_idle()

    for number in range(30):
        ask(f"a/p/{10**9 + 2 * number}")
    for id in (f"a/p/{DIGITS}", "a/p/1", "a/p/1", "a/p/2"):
        ask(id)
    assert [message.id for message in asked.answers][30:] == ["a/p/1", "a/p/1", "a/p/2"]
    assert net.inspect().refused == {"s": 1}
    node.close()
