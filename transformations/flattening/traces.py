"""The trace of a transformation: sources and results, queried in both directions, saved as `trace.ecore`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from dineros.metamodel import pn, trace
from dineros.metamodel.base import EObject
from dineros.metamodel.errors import UnknownElementError, near_matches
from dineros.transformations.language.creation import New
from dineros.transformations.language.meaning import Meaning
from dineros.transformations.language.rule import Rule


@dataclass(frozen=True, eq=False)
class Link:
    """One element that was made."""

    rule: str
    """Name of the rule; ``kept`` for an element that was taken over unchanged."""
    role: str
    """Name of the element in the rule's right-hand side, such as ``queue.load``."""
    application: int
    """Number of the rule application; links with the same number were made together."""
    sources: tuple[EObject, ...]
    """The source elements that the rule matched."""
    index: int | None
    """Number of the server instance, from 1, if there is one."""
    target: pn.Element
    """The element that was made."""
    client_index: int | None = None
    """For a client on a server page, the number of the server instance whose call it is, from 1."""
    maker: type[Rule] | None = None
    """The rule itself; None for elements that were taken over or copied."""
    values: str = ""
    """For a transition split by guards: the fields of its tokens, as text."""

    @property
    def meaning(self) -> Meaning | None:
        """The meaning that the rule gives to the element; None: it gives none."""
        made = None if self.maker is None else self.maker.created.get(self.role)
        return made.meaning if isinstance(made, New) else None


class Trace:
    """The links of one transformation.

    `links`: in the order they were made.
    """

    def __init__(self, links: Iterable[Link]) -> None:
        self.links = list(links)
        self._by_target = {link.target: link for link in self.links}
        self._by_source: dict[EObject, list[Link]] = {}
        self._by_role: dict[tuple[str, str], list[Link]] = {}
        for link in self.links:
            self._by_role.setdefault((link.rule, link.role), []).append(link)
            for source in link.sources:
                self._by_source.setdefault(source, []).append(link)

    def __iter__(self) -> Iterator[Link]:
        return iter(self.links)

    def origin(self, target: pn.Element) -> Link:
        """Return how an element was made."""
        return self._by_target[target]

    def made_from(self, source: EObject) -> list[Link]:
        """Return the elements made from an element of the source model."""
        return self._by_source.get(source, [])

    def role(self, rule: str, role: str) -> list[Link]:
        """Return everything that a rule made in a role."""
        return self._by_role.get((rule, role), [])

    def with_role(self, role: str) -> list[Link]:
        """Return all elements made in a role, by any rule: ``queue.drop``."""
        return [link for link in self.links if link.role == role]

    def find(self, id: str) -> Link:
        """Return the link of the made element with an id.

        Raises
        ------
        UnknownElementError
            No element with this id was made.
        """
        for link in self.links:
            if link.target.id == id:
                return link
        known = [link.target.id for link in self.links]
        raise UnknownElementError(f"no element {id!r} was created", hint=near_matches(id, known))

    def to_model(self, source: str, target: str) -> trace.TraceModel:
        """Return the links as a model that can be saved.

        Parameters
        ----------
        source, target : str
            The files (or ids) of the two models.
        """
        return trace.TraceModel(
            source=source,
            target=target,
            links=[
                trace.TraceLink(
                    rule=link.rule,
                    role=link.role,
                    application=link.application,
                    index=link.index,
                    clientIndex=link.client_index,
                    sources=link.sources,
                    target=link.target,
                )
                for link in self.links
            ],
        )
