"""A robot of 12 nodes with times, simulated for 100 seconds: processor time and firings.

Four sensors at 10 to 50 Hz, a filter each, a fusion of every two, a planner and a driver. Run it as
``python benchmarks/analysis/simulated_times.py``.
"""

from __future__ import annotations

import time

from dineros.analysis.timed_runs.simulating import simulate_times
from dineros.metamodel import sym
from dineros.metamodel.build import callback, node_net, place, seconds, step

SECONDS = 100.0


def robot() -> sym.SystemModel:
    """Return the model."""
    model = sym.SystemModel(id="robot", middleware="ros2")
    outputs: dict[str, sym.Place] = {}
    topics: dict[str, sym.TopicChannel] = {}

    def node(name: str, inputs: list[str], period: float | None, least: float, most: float) -> None:
        net = node_net(model, name, execution="callbacks")
        callbacks = [(f"{name}_{source}", source) for source in inputs] or [(f"{name}_tick", "")]
        for number, (id, source) in enumerate(callbacks):
            kind = "subscriber" if source else "timer"
            page = callback(net, id, kind, None if source else period, duration=seconds(least, most))
            taken = [place(page, f"{id}_in")] if source else []
            is_last = number == len(callbacks) - 1
            put = [place(page, f"{id}_out")] if is_last else []
            step(page, f"{id}_step", taken, put)
            if source:
                topics[source].subscribers.append(sym.SubscriberPort(place=taken[0], limit=5))
            if put:
                outputs[name] = put[0]
        if name in outputs:
            topics[name] = sym.TopicChannel(
                id=f"{name}_topic",
                topic=name,
                latency=seconds(0.0002, 0.001),
                publishers=[sym.PublisherPort(place=outputs[name])],
                model=model,
            )

    for number, period in enumerate((0.02, 0.02, 0.05, 0.1)):
        node(f"sensor{number}", [], period, 0.001, 0.003)
        node(f"filter{number}", [f"sensor{number}"], None, 0.002, 0.008)
    node("front", ["filter0", "filter1"], None, 0.001, 0.005)
    node("rear", ["filter2", "filter3"], None, 0.001, 0.005)
    node("planner", ["front", "rear"], None, 0.001, 0.004)
    node("driver", ["planner"], None, 0.0005, 0.001)
    return model


def main() -> None:
    """Print what a simulation costs."""
    begun = time.process_time()
    found = simulate_times(robot(), SECONDS, seed=1)
    spent = time.process_time() - begun
    longest = max(found.chains, key=lambda each: max(each.values))
    print(f"{SECONDS:g} s of 12 nodes: {found.firings:,} firings, {spent:.2f} s of the processor")
    print(
        f"{len(found.chains)} chains; slowest {longest.first} to {longest.last}: {max(longest.values):.4f} s"
    )


if __name__ == "__main__":
    main()
