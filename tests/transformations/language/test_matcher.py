"""The matcher against trying all combinations: random patterns over random models of a small metamodel."""

from __future__ import annotations

import itertools
from collections import Counter
from dataclasses import dataclass
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.transformations.language.engine import Engine
from dineros.transformations.language.expressions import Comparison, Expression, Path, as_expression
from dineros.transformations.language.matcher import Extents, Matcher
from dineros.transformations.language.patterns import Absent, Index, Node
from tests.support.systems.office import Badge, Company, Department, Manager, Person, companies

CLASSES = {"Company": Company, "Person": Person, "Manager": Manager, "Department": Department, "Badge": Badge}
# Class, feature, class of its values.
REFERENCES = [
    ("Company", "people", "Person"),
    ("Company", "departments", "Department"),
    ("Company", "badges", "Badge"),
    ("Person", "company", "Company"),
    ("Person", "departments", "Department"),
    ("Person", "boss", "Person"),
    ("Person", "reports", "Person"),
    ("Person", "friends", "Person"),
    ("Department", "members", "Person"),
    ("Department", "lead", "Person"),
    ("Badge", "owner", "Person"),
    ("Badge", "location", "Department"),
]
NUMBERS = [("Person", "age"), ("Badge", "number")]


@dataclass(frozen=True)
class Link:
    """Pattern node `owner` has in `feature` the node `value`; `of` says which of the two declares it."""

    owner: int
    feature: str
    value: int
    of: bool


@dataclass(frozen=True)
class Test:
    """A number of one node compared with a constant or a number of another one."""

    __test__ = False
    node: int
    feature: str
    symbol: str
    other: tuple[int, str] | int


@dataclass(frozen=True)
class Pattern:
    """Classes of the nodes (those from `forbidden` on must not match), links, tests."""

    classes: tuple[str, ...]
    forbidden: int
    links: tuple[Link, ...]
    tests: tuple[Test, ...]


def is_a(name: str, wanted: str) -> bool:
    return bool(issubclass(CLASSES[name], CLASSES[wanted]))


@st.composite
def patterns(draw: st.DrawFn) -> Pattern:
    classes = tuple(draw(st.lists(st.sampled_from(sorted(CLASSES)), min_size=1, max_size=4)))
    forbidden = draw(st.integers(max(1, len(classes) - 1), len(classes)))
    links = []
    for later in range(1, len(classes)):
        possible = [
            Link(*ends, of=of)
            for earlier in range(later)
            for ends, of in [
                *(
                    ((later, feature, earlier), False)
                    for owner, feature, value in REFERENCES
                    if is_a(classes[later], owner)
                    and (is_a(classes[earlier], value) or is_a(value, classes[earlier]))
                ),
                *(
                    ((earlier, feature, later), True)
                    for owner, feature, value in REFERENCES
                    if is_a(classes[earlier], owner)
                    and (is_a(classes[later], value) or is_a(value, classes[later]))
                ),
            ]
        ]
        if possible:
            chosen = draw(
                st.lists(
                    st.sampled_from(possible), max_size=2, unique_by=lambda link: (link.of, link.feature)
                )
            )
            links += [link for link in chosen if not link.of] + [link for link in chosen if link.of][:1]
    tests = []
    for node, name in enumerate(classes):
        for owner, feature in NUMBERS:
            if is_a(name, owner) and draw(st.booleans()):
                others: list[tuple[int, str] | int] = [1, 2]
                others += [
                    (other, number)
                    for other in range(node)
                    for kind, number in NUMBERS
                    if is_a(classes[other], kind)
                ]
                symbol = draw(st.sampled_from(["==", "!=", "<", ">"]))
                tests.append(Test(node, feature, symbol, draw(st.sampled_from(others))))
    return Pattern(classes, forbidden, tuple(links), tuple(tests))


COMPARE = {
    "==": lambda one, other: one == other,
    "!=": lambda one, other: one != other,
    "<": lambda one, other: one < other,
    ">": lambda one, other: one > other,
}


def holds(pattern: Pattern, objects: tuple[Any, ...]) -> bool:
    """Judge all links and tests among the objects given."""
    for link in pattern.links:
        if max(link.owner, link.value) < len(objects):
            held = getattr(objects[link.owner], link.feature)
            value = objects[link.value]
            if not (value is held if held is None or hasattr(held, "eClass") else value in held):
                return False
    for test in pattern.tests:
        if test.node < len(objects):
            if isinstance(test.other, int):
                other = test.other
            else:
                other = getattr(objects[test.other[0]], test.other[1])
            if not COMPARE[test.symbol](getattr(objects[test.node], test.feature), other):
                return False
    return True


def all_combinations(pattern: Pattern, company: Any) -> Counter[tuple[int, ...]]:
    """Return the matches by trying all combinations, as ids of objects."""
    everything = [company, *company.eAllContents()]
    extents = [[each for each in everything if isinstance(each, CLASSES[name])] for name in pattern.classes]
    found: Counter[tuple[int, ...]] = Counter()
    for objects in itertools.product(*extents[: pattern.forbidden]):
        if not holds(pattern, objects):
            continue
        rest = extents[pattern.forbidden :]
        if rest and any(holds(pattern, (*objects, *more)) for more in itertools.product(*rest)):
            continue
        found[tuple(map(id, objects))] += 1
    return found


def as_nodes(pattern: Pattern) -> tuple[list[Node], list[Expression], list[Expression]]:
    """Return pattern nodes, the conditions among the wanted ones, and those that speak of forbidden ones."""
    nodes: list[Node] = []
    for number, name in enumerate(pattern.classes):
        of = [link for link in pattern.links if link.of and link.value == number]
        features = {
            link.feature: nodes[link.value] for link in pattern.links if not link.of and link.owner == number
        }
        nodes.append(
            Node(
                CLASSES[name],
                of=Path(nodes[of[0].owner], of[0].feature) if of else None,
                **features,
            )
        )
    conditions: tuple[list[Expression], list[Expression]] = ([], [])
    for test in pattern.tests:
        if isinstance(test.other, int):
            other = as_expression(test.other)
        else:
            other = Path(nodes[test.other[0]], test.other[1])
        condition = Comparison(test.symbol, Path(nodes[test.node], test.feature), other)
        conditions[test.node >= pattern.forbidden].append(condition)
    return nodes, *conditions


def matched(pattern: Pattern, company: Any) -> list[list[Any]]:
    """Return the objects of each match of what a pattern wants, in the matcher's order."""
    nodes, where, forbidden_where = as_nodes(pattern)
    wanted, forbidden = nodes[: pattern.forbidden], nodes[pattern.forbidden :]
    absent = [Absent(*forbidden, where=forbidden_where)] if forbidden else []
    matcher = Matcher(Extents(company), Engine(company))
    return [[match[node] for node in wanted] for match in matcher.matches(wanted, where, absent)]


@given(companies(), patterns())
@settings(max_examples=150)
def test_finds_what_trying_all_combinations_finds(company: Any, pattern: Pattern) -> None:
    found = Counter(tuple(map(id, objects)) for objects in matched(pattern, company))
    assert found == all_combinations(pattern, company)


@given(companies(), patterns())
@settings(max_examples=100)
def test_finds_the_same_in_the_same_order_again(company: Any, pattern: Pattern) -> None:
    assert matched(pattern, company) == matched(pattern, company)


@given(companies())
def test_one_node_matches_in_model_order(company: Any) -> None:
    person = Node(Person)
    matcher = Matcher(Extents(company), Engine(company))

    assert [match[person] for match in matcher.matches([person])] == list(company.people)


@given(companies())
def test_what_is_reached_backwards_comes_in_model_order(company: Any) -> None:
    boss, report = Node(Person), Node(Person)
    report = Node(Person, boss=boss)
    matcher = Matcher(Extents(company), Engine(company))

    for found in company.people:
        reports = [match[report] for match in matcher.matches([report], given={boss: found})]
        assert reports == [person for person in company.people if person.boss is found]


def test_what_was_added_and_discarded_later_is_known() -> None:
    company = Company(name="company")
    one, two = Person(name="one"), Person(name="two")
    company.people.append(one)
    extents = Extents(company)
    badge = Badge(name="badge", owner=one)
    assert extents.with_value(Badge, "owner", one) == []

    company.badges.append(badge)
    extents.add(badge)
    two.boss = one
    company.people.append(two)
    extents.add(two)

    assert extents.with_value(Badge, "owner", one) == [badge]  # no opposite: from the index
    assert extents.with_value(Person, "boss", one) == [two]  # by the opposite
    assert extents.with_value(Company, "badges", badge) == [company]  # by containment
    assert extents.with_value(Badge, "name", "badge") == [badge]
    assert extents.of(Person) == [one, two] and extents.size(Person) == 2

    extents.discard(badge)
    extents.discard(two)

    assert extents.with_value(Badge, "owner", one) == []
    assert extents.with_value(Person, "boss", one) == []
    assert extents.with_value(Badge, "name", "badge") == []
    assert extents.of(Person) == [one]


def test_numbers_count_from_one_and_depend_on_the_match() -> None:
    company = Company(name="company", people=[Person(name="a", age=2), Person(name="b", age=0)])
    person = Node(Person)
    number = Index(upto=person.age)
    matcher = Matcher(Extents(company), Engine(company))

    found = [(match[person].name, match[number]) for match in matcher.matches([number, person])]

    assert found == [("a", 1), ("a", 2)]
