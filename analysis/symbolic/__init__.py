"""Symbolic engine: complete state spaces as decision diagrams."""

from typing import Any


def __getattr__(name: str) -> Any:
    """Return the engine's function on first access, because it needs the compiled kernels."""
    if name == "symbolic_state_space":
        from dineros.analysis.symbolic.engine import symbolic_state_space

        return symbolic_state_space
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
