"""The messages of installed packages, as token types of a model."""

from __future__ import annotations

from collections.abc import Sequence

from dineros.metamodel import sym
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.token_types.installed import (
    UnknownInterfaceError,
    installed_fields,
    installed_messages,
)
from dineros.observation.importing.names import Ids


def token_types_of(packages: Sequence[str], id: str) -> tuple[sym.SystemModel, list[str]]:
    """Return a model whose token types are the messages of packages, and lines about unsupported messages.

    Raises
    ------
    DinerosError
        A package is not installed, or has no message that tokens can carry.
    """
    ids, types, left_out = Ids(), list[sym.TokenType](), list[str]()
    ids.new(id)
    for name in [name for package in dict.fromkeys(packages) for name in installed_messages(package)]:
        try:
            installed_fields(name)
        except UnknownInterfaceError as error:
            left_out.append(f"{name}: {error}")
        else:
            types.append(sym.TokenType(id=ids.new(name.rpartition("/")[2]), ros=name))
    if not types:
        raise DinerosError(f"{', '.join(packages)}: the package has no message that tokens can carry")
    first, *others = types
    return sym.SystemModel(id=id, middleware="ros2", tokenType=first, otherTokenTypes=others), left_out
