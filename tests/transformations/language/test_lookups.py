"""Looking up what earlier rules made, element by element or as groups, on a metamodel without nets."""

from __future__ import annotations

import pytest

from dineros.transformations.language.creation import ForAll, Fragment
from dineros.transformations.language.engine import Engine, require_makers
from dineros.transformations.language.errors import RuleError
from dineros.transformations.language.patterns import Absent, Index, Made, Node
from dineros.transformations.language.rule import Rule
from tests.support.systems.office import (
    Badge,
    BadgeForEach,
    Counted,
    Department,
    Person,
    badge,
    names,
    office,
)


def test_a_lookup_of_several_results_gives_matches_in_the_order_they_were_made() -> None:
    class Copied(Rule):
        person = Node(Person)
        original = Made(Counted.made, of=person)
        made = badge("copy of {original.name}")
        lhs = [person, original]
        rhs = [*lhs, made]

    company = office()
    Engine(company).run([Counted, Copied])

    assert names(company.badges)[3:] == ["copy of Bo[1]", "copy of Cy[1]", "copy of Cy[2]"]


def test_a_lookup_by_element_and_number() -> None:
    class Second(Rule):
        person = Node(Person)
        step = Index(upto=2)
        original = Made(Counted.made, of=[person, step])
        made = badge("{step} is {original.number}")
        lhs = [person, step, original]
        rhs = [*lhs, made]

    company = office()
    Engine(company).run([Counted, Second])

    assert names(company.badges)[3:] == ["1 is 1", "1 is 1", "2 is 2"]


def test_a_lookup_of_everything_a_rule_made() -> None:
    class All(Rule):
        original = Made(Counted.made)
        made = badge("again {original.name}")
        lhs = [original]
        rhs = [*lhs, made]

    company = office()
    Engine(company).run([Counted, All])

    assert names(company.badges)[3:] == ["again Bo[1]", "again Cy[1]", "again Cy[2]"]


def test_a_lookup_of_what_a_for_all_made() -> None:
    class Each(Rule):
        person = Node(Person)
        friend = Node(Person, of=person.friends)
        made = badge("{friend.name}")
        every = ForAll([friend], make=[made])
        lhs = [person]
        rhs = [*lhs, every]

    class Found(Rule):
        person = Node(Person, name="Cy")
        original = Made(Each.made, of=person)
        made = badge("{original.name} for Cy")
        lhs = [person, original]
        rhs = [*lhs, made]

    company = office()
    Engine(company).run([Each, Found])

    assert names(company.badges)[3:] == ["Bo for Cy", "Ada for Cy"]


def test_a_lookup_that_finds_nothing_is_no_match() -> None:
    class Cold(Rule):
        person = Node(Person)
        original = Made(Counted.made, of=person)
        made = badge("late {original.name}")
        lhs = [person, original]
        rhs = [*lhs, made]

    company = office()
    Engine(company).run([Cold])

    assert list(company.badges) == []


class Pair(Fragment):
    """Two badges that belong together."""

    roles = {"front": Badge, "back": Badge}

    def __init__(self, name: str, **features: object) -> None:
        super().__init__()
        self.front = badge(f"{name}.front", **features)
        self.back = badge(f"{name}.back", **features)


class PersonPair(Rule):
    person = Node(Person)
    pair = Pair("{person.name}", owner=person)
    lhs = [person]
    rhs = [*lhs, *pair]


class PlacePair(Rule):
    place = Node(Department)
    pair = Pair("{place.name}")
    lhs = [place]
    rhs = [*lhs, *pair]


def test_groups_are_looked_up_by_kind_whichever_rule_made_them() -> None:
    class Glue(Rule):
        pair = Made(Pair)
        front = Node(Badge, of=pair.front)
        made = badge("{front.name}+")
        lhs = [pair, front]
        rhs = [*lhs, made]

    company = office()
    engine = Engine(company)
    engine.run([PlacePair, PersonPair, Glue])

    assert names(company.badges)[8:] == ["laboratory.front+", "Ada.front+", "Bo.front+", "Cy.front+"]
    assert names(made["back"] for _, made in engine.groups(Pair))[:2] == ["laboratory.back", "Ada.back"]


def test_groups_are_looked_up_by_rule_and_source() -> None:
    class Glue(Rule):
        person = Node(Person, name="Bo")
        one = Made(PersonPair.pair, of=person)
        any_of_it = Made(Pair, of=person)
        made = badge("Bo", owner=one.front.owner)
        lhs = [person, one, any_of_it]
        rhs = [*lhs, made]

    company = office()
    Engine(company).run([PlacePair, PersonPair, Glue])

    assert company.badges[8].owner.name == "Bo"
    assert len(company.badges) == 9


def test_a_rule_that_runs_before_the_one_it_looks_up_is_refused() -> None:
    class Again(Rule):
        person = Node(Person)
        original = Made(BadgeForEach.made, of=person)
        made = badge("{original.name}")
        lhs = [person, original]
        rhs = [*lhs, made]

    require_makers([BadgeForEach, Again])
    for rules in ([Again], [Again, BadgeForEach]):
        with pytest.raises(RuleError) as caught:
            require_makers(rules)

        assert caught.value.message == "dangling lookup: Again needs BadgeForEach to run before it"
        assert caught.value.location is not None
        assert caught.value.location.file == __file__


def test_lookups_in_forbidden_patterns_and_for_alls_need_their_makers_too() -> None:
    class Forbidding(Rule):
        person = Node(Person)
        made = badge("{person.name}")
        lhs = [person]
        rhs = [*lhs, made]
        absent = [Absent(Made(BadgeForEach.made, of=person))]

    class Repeating(Rule):
        person = Node(Person)
        every = ForAll(
            [Node(Person, boss=person)],
            make=[ForAll([Made(BadgeForEach.made, of=person)], make=[badge("{person.name}")])],
        )
        lhs = [person]
        rhs = [*lhs, every]

    for rule in (Forbidding, Repeating):
        with pytest.raises(RuleError, match="needs BadgeForEach to run before it"):
            require_makers([rule])


def test_a_forbidden_lookup() -> None:
    class Missing(Rule):
        person = Node(Person)
        made = badge("{person.name} has none")
        lhs = [person]
        rhs = [*lhs, made]
        absent = [Absent(Made(Counted.made, of=person))]

    company = office()
    Engine(company).run([Counted, Missing])

    assert names(company.badges)[3:] == ["Ada has none"]
