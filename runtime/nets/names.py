"""Names of the places, transitions and signals of a node."""

from __future__ import annotations

from dineros.metamodel.errors import UnknownElementError, near_matches
from dineros.runtime.nets.structure import Structure


class Names:
    """Numbers of elements by their ids and names."""

    def __init__(self, structure: Structure) -> None:
        self._structure = structure
        self._node = structure.ports.node
        by_id: dict[str, tuple[int, ...]] = {}
        by_label: dict[str, set[str]] = {}
        for number, (id, label) in enumerate(
            zip(structure.transition_names, structure.transition_labels, strict=True)
        ):
            by_id[id] = (*by_id.get(id, ()), number)
            by_label.setdefault(label, set()).add(id)
        self._labels = by_label
        self._transitions = {id: (number,) for number, id in enumerate(structure.transitions)} | by_id
        self._places = {id: number for number, id in enumerate(structure.places)}
        self._signals = {signal.name: number for number, signal in enumerate(structure.ports.signals)}
        self._signals |= {id: number for number, id in enumerate(structure.signals)}

    def transitions(self, name: str) -> tuple[int, ...]:
        """Return the transitions with an id in the running net, or with an id or name in the model.

        Raises
        ------
        UnknownElementError
            No transition has this name, or it is ambiguous.
        """
        numbers = self._transitions.get(name)
        if numbers is not None:
            return numbers
        ids = self._labels.get(name, set())
        if len(ids) == 1:
            return self._transitions[next(iter(ids))]
        if ids:
            raise UnknownElementError(
                f"{len(ids)} transitions have the name {name!r}", hint=f"use an id: {', '.join(sorted(ids))}"
            )
        known = [*self._transitions, *self._labels]
        hint = (
            near_matches(name, known)
            or f"it has {', '.join(dict.fromkeys(self._structure.transition_names))}"
        )
        raise UnknownElementError(f"the node {self._node} has no transition {name!r}", hint=hint)

    def place(self, id: str) -> int:
        """Return the place with an id in the running net.

        Raises
        ------
        UnknownElementError
            No place has this id.
        """
        if id not in self._places:
            raise UnknownElementError(
                f"the node {self._node} has no place {id!r}", hint=near_matches(id, self._places)
            )
        return self._places[id]

    def signal(self, name: str) -> int:
        """Return the signal with an id or name.

        Raises
        ------
        UnknownElementError
            No signal has this id or name.
        """
        if name not in self._signals:
            known = ", ".join(self._structure.signals) or "none"
            raise UnknownElementError(
                f"the node {self._node} has no signal {name!r}",
                hint=near_matches(name, self._signals) or f"it has {known}",
            )
        return self._signals[name]
