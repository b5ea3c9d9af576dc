"""Transitions with guards, and a check for functions that do not support guards yet."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import transitions
from dineros.metamodel.errors import GuardError


def guarded(model: pn.Net) -> list[sym.Transition]:
    """Return the transitions of a model with a guard or assignments."""
    found = [each for each in transitions(model) if isinstance(each, sym.Transition)]
    return [each for each in found if each.guard is not None or each.assigns is not None]


def require_no_guards(model: pn.Net, what: str) -> None:
    """Raise an error for a model with guards, in functions that would ignore them.

    Parameters
    ----------
    model : pn.Net
        The model.
    what : str
        Name of the function without support, such as ``dineros run``.

    Raises
    ------
    GuardError
        A transition has a guard or assignments.
    """
    for transition in guarded(model):
        raise GuardError(
            f"transition {transition.id} has a guard or assignments, which {what} does not support",
            element=transition.id,
            hint="guards decide in find, verify, check, statespace and sweep, and in runs",
        )
