"""Symmetric nets by their meaning: random nets, their PNML, and an interpreter that tries every binding.

Colours are Python values: labels, numbers, and tuples of colours. Nothing is unfolded, and no code of the
product is used.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import product
from typing import Any, TypeAlias

Term: TypeAlias = tuple[Any, ...]
"""``(kind, ...)``, see `value`, `multiset` and `holds`."""
Marking: TypeAlias = frozenset[tuple[str, Any, int]]
"""Place, colour, number of tokens."""

_RELATIONS: dict[str, Callable[[int, int], bool]] = {
    "equality": lambda a, b: a == b,
    "inequality": lambda a, b: a != b,
    "lessthan": lambda a, b: a < b,
    "lessthanorequal": lambda a, b: a <= b,
    "greaterthan": lambda a, b: a > b,
    "greaterthanorequal": lambda a, b: a >= b,
    "lt": lambda a, b: a < b,
    "leq": lambda a, b: a <= b,
    "gt": lambda a, b: a > b,
    "geq": lambda a, b: a >= b,
}
_ELEMENT_RELATIONS = {
    "ltp": "lessthan",
    "gtp": "greaterthan",
    "equality": "equality",
    "inequality": "inequality",
}
"""Relations of elements of a partition, and what they are for colours."""


@dataclass
class Coloured:
    """A symmetric net."""

    sorts: dict[str, tuple[Any, ...]]
    """By name: ``("listed", labels)`` or ``("cyclic", labels)``, ``("range", first, last)``,
    ``("product", names)``, ``("partition", sort, [(label, colours)])``, ``("bool",)`` or ``("dot",)``."""
    variables: dict[str, str]
    """Sort of each variable."""
    places: dict[str, tuple[str, Term | None]]
    """Sort and initial marking."""
    conditions: dict[str, Term | None]
    """By transition."""
    takes: list[tuple[str, str, Term]] = field(default_factory=list)
    """Place, transition, multiset."""
    puts: list[tuple[str, str, Term]] = field(default_factory=list)

    def colours(self, sort: str) -> list[Any]:
        """Return all colours of a sort, in order."""
        kind, *rest = self.sorts[sort]
        if kind == "dot":
            return ["dot"]
        if kind == "bool":
            return ["false", "true"]
        if kind == "partition":
            return [label for label, _ in rest[1]]
        if kind == "range":
            return list(range(rest[0], rest[1] + 1))
        if kind == "product":
            return list(product(*(self.colours(part) for part in rest[0])))
        return list(rest[0])

    def value(self, term: Term, binding: dict[str, Any]) -> Any:
        """Return a colour."""
        kind, *rest = term
        if kind == "variable":
            return binding[rest[0]]
        if kind == "constant":
            return rest[1]
        if kind == "single":
            return self.value(rest[0], binding)
        if kind == "tuple":
            return tuple(self.value(part, binding) for part in rest[0])
        if kind == "element":
            inner = self.value(rest[1], binding)
            return next(label for label, colours in self.sorts[rest[0]][2] if inner in colours)
        colours = self.colours(self.sort_of(rest[0]))
        step = 1 if kind == "successor" else -1
        return colours[(colours.index(self.value(rest[0], binding)) + step) % len(colours)]

    def sort_of(self, term: Term) -> str:
        """Return the sort of a colour that is not a tuple."""
        kind, *rest = term
        if kind == "variable":
            return self.variables[rest[0]]
        return rest[0] if kind in ("constant", "element") else self.sort_of(rest[0])

    def multiset(self, term: Term, binding: dict[str, Any]) -> Counter[Any]:
        """Return the tokens of a multiset."""
        kind, *rest = term
        if kind == "all":
            return Counter(self.colours(rest[0]))
        if kind == "empty":
            return Counter()
        if kind == "numberof":
            found = sum((self.multiset(part, binding) for part in rest[1:]), Counter())
            return Counter({c: rest[0] * n for c, n in found.items()})
        if kind == "single":
            return self.multiset(rest[0], binding)
        if kind == "group":
            return Counter(dict(self.sorts[rest[0]][2])[rest[1]])
        if kind == "add":
            return sum((self.multiset(part, binding) for part in rest[0]), Counter())
        if kind == "subtract":
            found = self.multiset(rest[0], binding)
            for part in rest[1:]:
                found.subtract(self.multiset(part, binding))
            return +found
        if kind == "tuples":
            found = Counter()
            for parts in product(*(self.multiset(part, binding).items() for part in rest[0])):
                number = 1
                for _, count in parts:
                    number *= count
                found[tuple(colour for colour, _ in parts)] += number
            return found
        return Counter([self.value(term, binding)])

    def holds(self, condition: Term | None, binding: dict[str, Any]) -> bool:
        """Tell whether a condition is true."""
        if condition is None:
            return True
        kind, *rest = condition
        if kind == "not":
            return not self.holds(rest[0], binding)
        if kind in ("and", "or"):
            return (all if kind == "and" else any)([self.holds(part, binding) for part in rest[0]])
        colours = self.colours(self.sort_of(rest[0]))
        return _RELATIONS[_ELEMENT_RELATIONS.get(str(kind), str(kind))](
            *(colours.index(self.value(part, binding)) for part in rest)
        )

    def initial(self) -> Marking:
        """Return the initial marking."""
        return _frozen(
            {
                name: Counter() if term is None else self.multiset(term, {})
                for name, (_, term) in self.places.items()
            }
        )

    def steps(self, marking: Marking) -> Iterator[tuple[str, Marking]]:
        """Yield transition and marking for each binding that can fire."""
        for transition, condition in self.conditions.items():
            arcs = [[arc for arc in arcs if arc[1] == transition] for arcs in (self.takes, self.puts)]
            names = sorted(
                {name for side in (*arcs[0], *arcs[1]) for name in _names(side[2])} | set(_names(condition))
            )
            for colours in product(*(self.colours(self.variables[name]) for name in names)):
                binding = dict(zip(names, colours, strict=True))
                if not self.holds(condition, binding):
                    continue
                tokens: dict[str, Counter[Any]] = {name: Counter() for name in self.places}
                for place, colour, number in marking:
                    tokens[place][colour] = number
                for place, _, term in arcs[0]:
                    tokens[place].subtract(self.multiset(term, binding))
                if any(number < 0 for each in tokens.values() for number in each.values()):
                    continue
                for place, _, term in arcs[1]:
                    tokens[place].update(self.multiset(term, binding))
                yield transition, _frozen(tokens)

    def graph(self, most: int) -> dict[Marking, list[tuple[str, Marking]]] | None:
        """Return all reachable markings with their steps; None if there are more than `most`."""
        found: dict[Marking, list[tuple[str, Marking]]] = {}
        todo = [self.initial()]
        while todo:
            marking = todo.pop()
            if marking in found:
                continue
            if len(found) == most or sum(number for *_, number in marking) > 60:
                return None
            found[marking] = list(self.steps(marking))
            todo.extend(after for _, after in found[marking])
        return found

    # -------------------------------------------------------------------------------------------- PNML

    def pnml(self) -> str:
        """Return the net as PNML."""
        sorts = "".join(
            self._sort_xml(name)
            if self.sorts[name][0] == "partition"
            else f'<namedsort id="{name}" name="{name}">{self._sort_xml(name)}</namedsort>'
            for name in self.sorts
        )
        variables = "".join(
            f'<variabledecl id="{name}" name="{name}"><usersort declaration="{sort}"/></variabledecl>'
            for name, sort in self.variables.items()
        )
        nodes = "".join(
            f'<place id="{name}"><type><structure><usersort declaration="{sort}"/></structure></type>'
            + (
                f"<hlinitialMarking><structure>{self._xml(term)}</structure></hlinitialMarking>"
                if term
                else ""
            )
            + "</place>"
            for name, (sort, term) in self.places.items()
        )
        nodes += "".join(
            f'<transition id="{name}">'
            + (f"<condition><structure>{self._xml(term)}</structure></condition>" if term else "")
            + "</transition>"
            for name, term in self.conditions.items()
        )
        arcs = [(place, transition, term) for place, transition, term in self.takes]
        arcs += [(transition, place, term) for place, transition, term in self.puts]
        joined = "".join(
            f'<arc id="a{number}" source="{source}" target="{target}"><hlinscription><structure>'
            f"{self._xml(term)}</structure></hlinscription></arc>"
            for number, (source, target, term) in enumerate(arcs)
        )
        return (
            '<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml"><net id="n" '
            'type="http://www.pnml.org/version-2009/grammar/symmetricnet"><declaration><structure>'
            f"<declarations>{sorts}{variables}</declarations></structure></declaration>"
            f'<page id="p">{nodes}{joined}</page></net></pnml>'
        )

    def _sort_xml(self, name: str) -> str:
        kind, *rest = self.sorts[name]
        if kind == "dot":
            return "<dot/>"
        if kind == "bool":
            return "<bool/>"
        if kind == "partition":
            elements = "".join(
                f'<partitionelement id="{name}-{label}" name="{label}">'
                + "".join(self._constant_xml(rest[0], colour) for colour in colours)
                + "</partitionelement>"
                for label, colours in rest[1]
            )
            divided = f'<usersort declaration="{rest[0]}"/>'
            return f'<partition id="{name}" name="{name}">{divided}{elements}</partition>'
        if kind == "range":
            return f'<finiteintrange start="{rest[0]}" end="{rest[1]}"/>'
        if kind == "product":
            parts = "".join(f'<usersort declaration="{part}"/>' for part in rest[0])
            return f"<productsort>{parts}</productsort>"
        labels = "".join(f'<feconstant id="{name}-{label}" name="{label}"/>' for label in rest[0])
        tag = "cyclicenumeration" if kind == "cyclic" else "finiteenumeration"
        return f"<{tag}>{labels}</{tag}>"

    def _xml(self, term: Term) -> str:
        kind, *rest = term
        if kind == "variable":
            return f'<variable refvariable="{rest[0]}"/>'
        if kind == "constant":
            return self._constant_xml(*rest)
        if kind in ("all", "empty"):
            return f'<{kind}><usersort declaration="{rest[0]}"/></{kind}>'
        if kind == "element":
            inner = f"<subterm>{self._xml(rest[1])}</subterm>"
            return f'<partitionelementof refpartition="{rest[0]}">{inner}</partitionelementof>'
        if kind == "numberof":
            number = f'<subterm><numberconstant value="{rest[0]}"><positive/></numberconstant></subterm>'
            inner = "".join(f"<subterm>{self._xml(part)}</subterm>" for part in rest[1:])
            return f"<numberof>{number}{inner}</numberof>"
        if kind == "group":
            return f'<useroperator declaration="{rest[0]}-{rest[1]}"/>'
        parts = rest[0] if kind in ("tuple", "tuples", "add", "and", "or") else rest
        inner = "".join(f"<subterm>{self._xml(part)}</subterm>" for part in parts)
        name = "tuple" if kind in ("tuples", "single") else kind
        return f"<{name}>{inner}</{name}>"

    def _constant_xml(self, sort: str, colour: Any) -> str:
        kind = self.sorts[sort][0]
        if kind == "dot":
            return "<dotconstant/>"
        if kind == "bool":
            return f'<booleanconstant value="{colour}"/>'
        if kind == "range":
            return f'<finiteintrangeconstant value="{colour}">{self._sort_xml(sort)}</finiteintrangeconstant>'
        return f'<useroperator declaration="{sort}-{colour}"/>'


def _names(term: Term | None) -> Iterator[str]:
    if not isinstance(term, (tuple, list)):
        return
    if len(term) == 2 and term[0] == "variable":
        yield term[1]
        return
    for part in term:
        if isinstance(part, (tuple, list)):
            yield from _names(tuple(part))


def _frozen(tokens: dict[str, Counter[Any]]) -> Marking:
    return frozenset(
        (place, colour, number) for place, each in tokens.items() for colour, number in each.items() if number
    )


def random_net(seed: int) -> Coloured:
    """Return a small random net with enumerations, ranges, tuples, differences and conditions."""
    return _Dice(random.Random(seed)).net()


class _Dice:
    def __init__(self, dice: random.Random) -> None:
        self._dice = dice

    def net(self) -> Coloured:
        dice = self._dice
        sorts: dict[str, tuple[Any, ...]] = {
            "C": ("cyclic", [f"c{number}" for number in range(dice.randint(2, 3))]),
            "N": ("range", first := dice.randint(-1, 2), last := first + dice.randint(0, 2)),
            "D": ("dot",),
            "B": ("bool",),
            "P": ("product", dice.choice([["C", "N"], ["C", "C"], ["N", "C"], ["D", "C"], ["B", "N"]])),
        }
        sorts["G"] = ("partition", "C", self._groups(sorts["C"][1]))
        sorts["H"] = ("partition", "N", self._groups(list(range(first, last + 1))))
        variables = {"x": "C", "y": "C", "m": "N", "n": "N", "p": "P", "b": "B", "g": "G"}
        self._net = net = Coloured(sorts, variables, {}, {})
        for number in range(dice.randint(2, 4)):
            sort = dice.choice(["C", "C", "N", "D", "P", "P", "B", "G"])
            term = None if dice.random() < 0.35 else self._marking(sort)
            net.places[f"place{number}"] = (sort, term)
        for number in range(dice.randint(1, 3)):
            name = f"transition{number}"
            net.conditions[name] = None if dice.random() < 0.4 else self._condition(2)
            for arcs, most in ((net.takes, 2), (net.puts, 2)):
                for place in dice.sample(
                    sorted(net.places), min(len(net.places), dice.randint(0 if arcs is net.puts else 1, most))
                ):
                    arcs.append((place, name, self._multiset(net.places[place][0])))
        return net

    def _groups(self, colours: list[Any]) -> list[tuple[str, list[Any]]]:
        """Return colours in one to three groups, in any order."""
        held: dict[str, list[Any]] = {}
        for colour in self._dice.sample(colours, len(colours)):
            held.setdefault(f"g{self._dice.randint(1, 3)}", []).append(colour)
        return list(held.items())

    def _marking(self, sort: str) -> Term:
        colours = self._dice.sample(self._net.colours(sort), 1)
        constant = ("numberof", self._dice.randint(1, 2), self._constant(sort, colours[0]))
        return self._dice.choice([constant, ("all", sort), ("add", [constant, ("all", sort)])])

    def _constant(self, sort: str, colour: Any) -> Term:
        kind, *rest = self._net.sorts[sort]
        if kind != "product":
            return ("constant", sort, colour)
        return ("tuple", [self._constant(part, each) for part, each in zip(rest[0], colour, strict=True)])

    def _value(self, sort: str) -> Term:
        kind, *rest = self._net.sorts[sort]
        names = [name for name, own in self._net.variables.items() if own == sort]
        chance = self._dice.random()
        if chance > 0.95:
            return ("single", self._value(sort))
        if kind == "product" and chance < 0.75:
            return ("tuple", [self._value(part) for part in rest[0]])
        if kind == "dot" or chance < 0.1:
            return self._constant(sort, self._dice.choice(self._net.colours(sort)))
        if kind == "partition" and chance < 0.8:
            return ("element", sort, self._value(rest[0]))
        if not names:
            return self._constant(sort, self._dice.choice(self._net.colours(sort)))
        term: Term = ("variable", self._dice.choice(names))
        while kind != "product" and self._dice.random() < 0.25:
            term = (self._dice.choice(["successor", "predecessor"]), term)
        return term

    def _multiset(self, sort: str) -> Term:
        chance = self._dice.random()
        kind, *rest = self._net.sorts[sort]
        if chance < 0.08:
            return ("all", sort)
        if chance < 0.1:
            return ("empty", sort)
        if chance < 0.16:
            return ("subtract", ("numberof", 2, ("all", sort)), self._value(sort), self._value(sort))
        if chance < 0.22:
            return ("numberof", self._dice.randint(1, 2), self._value(sort), self._value(sort))
        divided = {own[1]: name for name, own in self._net.sorts.items() if own[0] == "partition"}
        if chance < 0.36 and kind == "product":
            parts = [
                self._group(divided[part])
                if part in divided and self._dice.random() < 0.3
                else ("all", part)
                if self._dice.random() < 0.4
                else self._value(part)
                for part in rest[0]
            ]
            if any(part[0] in ("all", "group") for part in parts):
                return ("tuples", parts)
        if chance < 0.36 and sort in divided:
            return self._group(divided[sort])
        if chance < 0.42:
            return ("add", [self._value(sort), ("numberof", self._dice.randint(1, 2), self._value(sort))])
        return self._value(sort) if chance < 0.7 else ("numberof", 1, self._value(sort))

    def _group(self, partition: str) -> Term:
        """Return the colours in an element of a partition, named by the element."""
        return ("group", partition, self._dice.choice([label for label, _ in self._net.sorts[partition][2]]))

    def _condition(self, depth: int) -> Term:
        chance = self._dice.random()
        if depth and chance < 0.3:
            return (self._dice.choice(["and", "or"]), [self._condition(depth - 1) for _ in range(2)])
        if depth and chance < 0.4:
            return ("not", self._condition(depth - 1))
        sort = self._dice.choice(["C", "C", "N", "G", "H", "B"])
        relations = _ELEMENT_RELATIONS if self._net.sorts[sort][0] == "partition" else _RELATIONS
        relation = self._dice.choice(sorted(relations))
        return (relation, self._value(sort), self._value(sort))
