"""Values that handlers keep besides tokens: JSON values by name, stored in the journal."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator, Mapping, MutableMapping
from typing import Any, TypeAlias, TypeVar, cast

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.json_text import decode_json

Json: TypeAlias = "bool | int | float | str | list[Json] | dict[str, Json] | None"

T = TypeVar("T", bool, int, float, str, list[Any], dict[str, Any])


class KeepError(DinerosError):
    """A value cannot be kept."""


class Memory(MutableMapping[str, Any]):
    """The values kept by a node's handlers, as one firing sees them.

    A change takes effect when the firing commits. A firing that fails, is withdrawn or is interrupted by a
    crash changes nothing. Values that are read are copies; assign a value to keep it.

    Examples
    --------
    >>> memory = Memory({"picked": 2})
    >>> memory["picked"] = memory.value("picked", 0) + 1
    >>> memory["picked"], memory.value("placed", 0), memory.changes
    (3, 0, {'picked': 3})
    """

    def __init__(self, kept: Mapping[str, Json] | None = None) -> None:
        self._kept = kept or {}
        self.changes: dict[str, Json] = {}

    def value(self, name: str, default: T) -> T:
        """Return a kept value of the default's type; the default if no value is kept.

        Raises
        ------
        KeepError
            The kept value has another type.
        """
        kept: Any = self.get(name, default)
        kind: type = type(default)
        if kind is float and type(kept) is int:
            kept = float(kept)
        if type(kept) is not kind:
            raise KeepError(f"{name!r} is stored as {kept!r}, not as {kind.__name__}")
        return cast("T", kept)

    def __getitem__(self, name: str) -> Any:
        value = self.changes[name] if name in self.changes else self._kept.get(name)
        if value is None:
            raise KeyError(name)
        return copy.deepcopy(value)

    def __setitem__(self, name: str, value: Json) -> None:
        """Keep a value; None removes it.

        Raises
        ------
        KeepError
            The value is not JSON.
        """
        if not isinstance(name, str):
            raise KeepError(f"the name of a stored value must be a string, not {name!r}")
        try:
            text = json.dumps(value, allow_nan=False)
        except (TypeError, ValueError, RecursionError) as error:
            raise KeepError(f"{name!r} cannot be stored: {error}", hint="keep JSON values") from None
        self.changes[name] = decode_json(text)

    def __delitem__(self, name: str) -> None:
        self[name]
        self.changes[name] = None

    def __iter__(self) -> Iterator[str]:
        return (name for name, value in {**self._kept, **self.changes}.items() if value is not None)

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __repr__(self) -> str:
        return f"Memory({dict(self)})"
