"""A camera with a timer and a detector of its images: the model, and records of runs with known times."""

from __future__ import annotations

import random
from collections import deque
from dataclasses import dataclass, field

from dineros.metamodel import sym
from dineros.metamodel.build import callback, node_net, place, seconds, step
from dineros.metamodel.records import Checkpoint, Fire, Header, Publish, Record, Start, StoredToken, Take

PERIOD = 0.1


def camera() -> sym.SystemModel:
    """Return the model: all of its times are declared."""
    model = sym.SystemModel(id="watch", middleware="ros2")
    eye = node_net(model, "eye", execution="callbacks")
    on_timer = callback(eye, "OnTimer", "timer", PERIOD, duration=seconds(0.0, 0.02), jitter=0.01)
    image = place(on_timer, "Image")
    step(on_timer, "Grab", [], [image])
    brain = node_net(model, "brain", execution="callbacks")
    on_image = callback(brain, "OnImage", duration=seconds(0.002, 0.02))
    seen, half = place(on_image, "Seen"), place(on_image, "Half")
    step(on_image, "Look", [seen], [half])
    step(on_image, "Detect", [half], [])
    model.channels.append(
        sym.TopicChannel(
            id="Images",
            topic="images",
            latency=seconds(0.0, 0.03),
            publishers=[sym.PublisherPort(place=image)],
            subscribers=[sym.SubscriberPort(place=seen)],
        )
    )
    return model


@dataclass
class KnownRun:
    """What each node recorded of a run, and the true times, in the order in which they were over.

    `quick` gives no wait that hides a time: each node is idle when something comes.
    """

    seed: int
    ticks: int = 40
    quick: bool = False
    jitter: float = 0.0
    records: dict[str, list[Record]] = field(default_factory=dict)
    periods: list[float] = field(default_factory=list)
    latencies: list[float] = field(default_factory=list)
    durations: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        draw = random.Random(self.seed)
        most = 0.02 if self.quick else 0.25
        images = self._eye(draw, most)
        self._brain(draw, images, most)

    def _begin(self, node: str) -> list[Record]:
        at = {"node": node, "time": 1000.0}
        head = Header(sequence=0, kind="run", model="watch", **at)  # type: ignore[arg-type]
        rest = [Checkpoint(sequence=1, marking={}, signals={}, **at), Start(sequence=2, marking={}, **at)]  # type: ignore[arg-type]
        self.records[node] = [head, *rest]
        return self.records[node]

    def _eye(self, draw: random.Random, most: float) -> list[tuple[str, float]]:
        kept, free = self._begin("eye"), 1000.0
        images: list[tuple[str, float]] = []
        last: float | None = None
        strikes = [1000.05 + PERIOD * each + draw.uniform(0, self.jitter) for each in range(self.ticks)]
        waiting: float | None = None
        for number, strike in enumerate(strikes):
            if waiting is None:
                waiting = strike
            after = strikes[number + 1] if number + 1 < len(strikes) else 2000.0
            begin = max(waiting, free)
            if begin >= after:
                continue  # the tick waits, and the next one is lost
            took = draw.uniform(0, most)
            free = begin + took
            if last is not None:
                self.periods.append(waiting - last)
            last, waiting = waiting, None
            token = StoredToken(number, {})
            at = {"node": "eye", "time": free}
            made = {"Image": [token]}
            grab = {"transition": "Grab", "made": made, "change": {"Image": 1}, "duration": took}
            kept.append(Fire(sequence=len(kept), **grab, **at))  # type: ignore[arg-type]
            message = f"eye/Image/{len(images) + 1}"
            step = {"channel": "Images", "place": "Image", "token": number, "message": message}
            kept.append(Publish(sequence=len(kept), change={"Image": -1}, **step, **at))  # type: ignore[arg-type]
            images.append((message, free))
        return images

    def _brain(self, draw: random.Random, images: list[tuple[str, float]], most: float) -> None:
        kept, free, arrived = self._begin("brain"), 1000.0, 0.0
        queue: deque[tuple[str, float, float]] = deque()
        for message, sent in images:
            arrived = max(arrived, sent + draw.uniform(0, 0.02 if self.quick else 0.06))
            queue.append((message, sent, arrived))
        for number, (message, sent, arrival) in enumerate(queue):
            taken = max(arrival, free)
            self.latencies.append(arrival - sent)
            at = {"node": "brain", "time": taken}
            ports = {"channel": "Images", "place": "Seen", "token": 2 * number, "message": message}
            kept.append(Take(sequence=len(kept), change={"Seen": 1}, **ports, **at))  # type: ignore[arg-type]
            first, second = draw.uniform(0, most / 4), draw.uniform(0, most / 4)
            steps = (
                ("Look", "Seen", "Half", 2 * number, 2 * number + 1, first),
                ("Detect", "Half", None, 2 * number + 1, 0, second),
            )
            free = taken
            for name, before, after, token, next_token, took in steps:
                free += took
                made = {after: [StoredToken(next_token, {})]} if after else {}
                change = {before: -1, **({after: 1} if after else {})}
                kept.append(
                    Fire(
                        sequence=len(kept),
                        transition=name,
                        taken={before: [token]},
                        made=made,
                        change=change,
                        duration=took,
                        node="brain",
                        time=free,
                    )
                )
            self.durations.append(first + second)
