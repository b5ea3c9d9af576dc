"""What code says of time: in which order an executor takes callbacks, and how long they sleep."""

from __future__ import annotations

from dineros.sources.facts import CallbackFact, NodeFact


def order_of(fact: NodeFact) -> str | None:
    """Return in which order the executor of a node takes callbacks; None where the code does not say it.

    Executors with one thread that wait for a set of what is ready have the order of their client library. Of
    a component, its container decides, and what else it contains.
    """
    if fact.threads != 1 or fact.plugin:
        return None
    words = fact.executor.partition(" (")[0]
    if fact.at.file.endswith(".py"):
        return "rclpy" if words in ("rclpy.spin", "SingleThreadedExecutor, spin") else None
    return "rclcpp" if words == "SingleThreadedExecutor" else None


def sleeps_of(fact: CallbackFact) -> tuple[float, None] | None:
    """Return the seconds that a callback takes at least, as it sleeps so long whatever happens."""
    sleeps = [
        effect.timeout or 0.0
        for effect in fact.effects
        if (effect.do, effect.when) == ("sleep", "always") and effect.how in ("", "time.sleep")
    ]
    return (round(sum(sleeps), 9), None) if sum(sleeps) > 0 else None
