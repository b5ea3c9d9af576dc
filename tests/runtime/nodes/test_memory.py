"""Memory stays flat, however long a net runs."""

from __future__ import annotations

import gc
import tracemalloc

import pytest

from dineros.runtime import Net, Node
from dineros.runtime.channels.transport import Receiver, Transport
from dineros.runtime.nets.ports import ClientPort, Message, Ports, PublisherPort
from dineros.transformations.flattening.split import split
from tests.runtime.tiny import case_study


class Echo(Transport):
    """Answers every request at once with what was asked."""

    def open(self, ports: Ports, receiver: Receiver) -> None:
        self.receiver = receiver

    def publish(self, port: PublisherPort, message: Message) -> bool:
        return True

    def request(self, port: ClientPort, message: Message) -> None:
        self.receiver.response_arrived(port, message)

    def close(self) -> None:
        pass


@pytest.mark.long
def test_memory_is_flat_over_many_firings() -> None:
    controller = next(part for part in split(case_study()) if part.node.id == "controller")
    net = Net(controller, seed=1)
    node = Node(net, Echo())
    node.open()
    subscribers = net.structure.ports.subscribers
    number = 0

    def run(objects: int) -> int:
        nonlocal number
        for _ in range(objects):
            number += 1
            message = Message(f"selector/SortRed/{number}", {"color": "red"})
            node.receiver.message_arrived(subscribers[number % 2], message, 0)
            node.run_until_idle()
        gc.collect()
        return tracemalloc.get_traced_memory()[0]

    tracemalloc.start()
    try:
        run(300)
        before = run(300)
        after = run(1000)
    finally:
        tracemalloc.stop()
    assert net.inspect().firings == 1600 * 5
    assert after - before < 20_000, "bytes per 5 000 firings"
    node.close()
