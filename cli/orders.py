"""The option ``--no-cache``: whether orders of levels are kept beside the model."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from dineros.analysis.symbolic.order_cache import OrderCache

F = TypeVar("F", bound=Callable[..., Any])


def cache_option(function: F) -> F:
    """Add `--no-cache`, passed as `no_cache`."""
    option = click.option(
        "--no-cache",
        is_flag=True,
        help="Neither use nor keep orders for decision diagrams, in .dineros/ beside the model.",
    )
    return option(function)


def orders_beside(model: Path, no_cache: bool) -> OrderCache | None:
    """Return the orders kept beside a model."""
    if no_cache:
        return None
    from dineros.analysis.symbolic.order_cache import OrderCache

    return OrderCache(model)
