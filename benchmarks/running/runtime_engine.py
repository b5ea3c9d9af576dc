"""Speed and memory of the Petri Net Engine, in process and without handlers, on the case study's controller.

``python -m benchmarks.running.runtime_engine`` runs a million firings; ``--firings 10000000`` shows that
memory stays flat.

* *engine*: marking and enabling alone; arrivals and departures are done by the benchmark, one call each.
* *node*: a whole node with its loop, ports and a transport that answers every request at once. Five firings
are one
  object through a cell: besides the firings, the node takes a message, sends four requests, takes four
  responses and publishes a result.
* *recorded*: the same, with a recorder that keeps nothing; so every record is built.

Times are CPU seconds of this process, so that other work on the machine counts little.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from benchmarks._processes import mebibytes
from dineros.metamodel.files import load
from dineros.metamodel.sym import SystemModel
from dineros.metamodel.token_data import Value
from dineros.runtime import Net, Node
from dineros.runtime.channels.transport import Receiver, Transport
from dineros.runtime.journal.recording import Recorder
from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.ports import ClientPort, Message, Ports, PublisherPort
from dineros.transformations.flattening.split import split

MODEL = Path(__file__).resolve().parents[2] / "case_study/sorting.sym.xmi"


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


class Forgetful:
    """Has every record built and keeps none."""

    def open(self, ports: Ports, checkpoint: object) -> None:
        pass

    def record(self, event: str, **fields: object) -> None:
        pass

    def close(self) -> None:
        pass


def controller() -> Net:
    model = load(MODEL)
    assert isinstance(model, SystemModel)
    return Net(next(part for part in split(model) if part.node.id == "controller"), seed=1)


def engine_alone(firings: int) -> float:
    structure = controller().structure
    engine = Engine(structure)
    number = {id: index for index, id in enumerate(structure.places)}
    services = [(number[port.request], number[port.response]) for port in structure.ports.clients]
    publishers = [number[port.place] for port in structure.ports.publishers]
    subscribers = [number[port.place] for port in structure.ports.subscribers]
    data = engine.passing.checkers[0].complete({"color": "red"})
    fired = 0
    start = time.process_time()
    while fired < firings:
        for place in subscribers:
            engine.put(place, engine.new_token(data))
        while engine.ready:
            while engine.ready:
                engine.fire(engine.ready[-1])
                fired += 1
            for request, response in services:
                while engine.count(request):
                    engine.put(response, engine.take(request))
            for place in publishers:
                while engine.count(place):
                    engine.take(place)
    return fired / (time.process_time() - start)


def whole_node(firings: int, recorder: Recorder | None = None, report: bool = False) -> float:
    net = controller()
    node = Node(net, Echo(), recorder)
    node.open()
    subscribers = net.structure.ports.subscribers
    data: dict[str, Value] = {"color": "red", "pose": [0.5] * 6}
    objects, tenth = firings // 5, max(1, firings // 50)
    start = time.process_time()
    for number in range(1, objects + 1):
        node.receiver.message_arrived(subscribers[number % 2], Message(f"selector/Sort/{number}", data), 0)
        while node.step():
            pass
        if report and number % tenth == 0:
            print(f"  {number * 5:>12,} firings: {mebibytes():.1f} MiB", flush=True)
    elapsed = time.process_time() - start
    fired = net.inspect().firings
    node.close()
    return fired / elapsed


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--firings", type=int, default=1_000_000)
    firings = parser.parse_args().firings
    print(f"engine:   {engine_alone(firings):>10,.0f} firings/s")
    print(f"recorded: {whole_node(min(firings, 200_000), Forgetful()):>10,.0f} firings/s")
    print("node, memory:")
    print(f"node:     {whole_node(firings, report=True):>10,.0f} firings/s")


if __name__ == "__main__":
    main()
