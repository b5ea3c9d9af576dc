"""Rules on a metamodel without nets: what is made, repeated, deleted and looked up, and in which order."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import Any

import pytest
from hypothesis import given

from dineros.metamodel import pn
from dineros.transformations.language.creation import IMAGES, Copy, ForAll, New, image
from dineros.transformations.language.engine import Engine
from dineros.transformations.language.errors import RuleError
from dineros.transformations.language.expressions import Expression, Text
from dineros.transformations.language.functions import ancestor, count, either, first, number, position
from dineros.transformations.language.patterns import Absent, Index, Node, Pattern
from dineros.transformations.language.rule import Rule
from tests.support.systems.office import (
    COMPANY,
    Badge,
    BadgeForEach,
    Company,
    Counted,
    Department,
    Manager,
    Person,
    Rank,
    badge,
    companies,
    names,
    office,
)


def test_a_new_element_for_each_match_in_model_order() -> None:
    company = office()
    applications = Engine(company).run([BadgeForEach])

    assert names(company.badges) == ["Ada", "Bo", "Cy"]
    assert [made.number for made in company.badges] == [50, 30, 20]
    assert [made.owner for made in company.badges] == list(company.people)
    assert [application.number for application in applications] == [0, 1, 2]
    assert applications[1].sources == [company.people[1]]
    assert applications[1].made == {"made": company.badges[1]}


def test_subclasses_match_too() -> None:
    class BadgeForManagers(Rule):
        manager = Node(Manager)
        made = badge("{manager.name}")
        lhs = [manager]
        rhs = [*lhs, made]

    company = office()
    Engine(company).run([BadgeForManagers])

    assert names(company.badges) == ["Ada"]


def test_all_matches_are_found_before_the_first_is_applied() -> None:
    class Twin(Rule):
        person = Node(Person)
        twin = New(Person, company=COMPANY, name="{person.name}2")
        lhs = [person]
        rhs = [*lhs, twin]

    company = office()
    Engine(company).run([Twin])

    assert names(company.people) == ["Ada", "Bo", "Cy", "Ada2", "Bo2", "Cy2"]


def test_conditions_and_negation() -> None:
    class Young(Rule):
        person = Node(Person)
        where = [person.age < 40, ~(person.name == "Cy")]
        made = badge("{person.name}")
        lhs = [person]
        rhs = [*lhs, made]

    company = office()
    Engine(company).run([Young])

    assert names(company.badges) == ["Bo"]


def test_nothing_is_less_or_greater_than_what_is_absent() -> None:
    class Led(Rule):
        person = Node(Person)
        where = [person.boss.age > 0]
        made = badge("{person.name}")
        lhs = [person]
        rhs = [*lhs, made]

    class NotLed(Rule):
        person = Node(Person)
        where = [person.boss == None]  # noqa: E711
        made = badge("free {person.name}")
        lhs = [person]
        rhs = [*lhs, made]

    company = office()
    Engine(company).run([Led, NotLed])

    assert names(company.badges) == ["Bo", "Cy", "free Ada"]


def test_a_forbidden_pattern_of_several_nodes() -> None:
    class Unloved(Rule):
        person = Node(Person)
        friend = Node(Person, friends=person)
        place = Node(Department, members=friend)
        made = badge("{person.name}")
        lhs = [person]
        rhs = [*lhs, made]
        absent = [Absent(friend, place, where=[friend.age > 25])]

    company = office()
    Engine(company).run([Unloved])

    # Bo is Cy's friend, but Cy is 20; Ada is Cy's friend; Cy is Bo's, who is 30 and works somewhere.
    assert names(company.badges) == ["Ada", "Bo"]


def test_each_of_several_forbidden_patterns_forbids() -> None:
    class Lonely(Rule):
        person = Node(Person)
        made = badge("{person.name}")
        lhs = [person]
        rhs = [*lhs, made]
        absent = [Absent(Node(Person, boss=person)), Absent(Node(Department, lead=person))]

    company = office()
    Engine(company).run([Lonely])

    assert names(company.badges) == ["Cy"]


def test_what_stands_on_the_left_only_is_deleted() -> None:
    class Close(Rule):
        place = Node(Department)
        lead = Node(Person, of=place.lead)
        made = badge("{place.name} of {lead.name}")
        lhs = [place, lead]
        rhs = [lead, made]

    company = office()
    bo = company.people[1]
    company.departments.append(Department(name="empty"))
    engine = Engine(company)
    engine.run([Close])

    assert names(company.departments) == ["empty"]
    assert list(bo.departments) == []
    assert names(company.badges) == ["laboratory of Bo"]
    assert names(engine.extents.of(Department)) == ["empty"]


def test_what_several_matches_delete_is_deleted_once() -> None:
    class Dissolve(Rule):
        place = Node(Department)
        member = Node(Person, of=place.members)
        made = badge("{member.name}")
        lhs = [place, member]
        rhs = [member, made]

    company = office()
    Engine(company).run([Dissolve])

    assert list(company.departments) == []
    assert names(company.badges) == ["Bo", "Cy"]


def test_nested_for_all_in_order_with_elements_that_refer_to_each_other() -> None:
    class Visit(Rule):
        place = Node(Department)
        member = Node(Person, of=place.members)
        friend = Node(Person, of=member.friends)
        host = New(Person, company=COMPANY, name="host of {member.name}")
        pass_ = badge("{friend.name} visits {member.name}", owner=host)
        every = ForAll([member], make=[host, ForAll([friend], make=[pass_], where=[friend.age > 20])])
        lhs = [place]
        rhs = [*lhs, every]

    company = office()
    (application,) = Engine(company).run([Visit])

    assert names(company.people) == ["Ada", "Bo", "Cy", "host of Bo", "host of Cy"]
    assert names(company.badges) == ["Bo visits Cy", "Ada visits Cy"]
    assert {made.owner.name for made in company.badges} == {"host of Cy"}
    assert [role for role, _ in application.repeated] == ["host", "host", "pass_", "pass_"]


def test_a_for_all_without_matches_makes_nothing_and_the_rule_applies() -> None:
    class Reports(Rule):
        person = Node(Person)
        report = Node(Person, boss=person)
        made = badge("{person.name}")
        every = ForAll([report], make=[badge("{report.name} of {person.name}")])
        lhs = [person]
        rhs = [*lhs, made, every]

    company = office()
    Engine(company).run([Reports])

    assert names(company.badges) == ["Ada", "Bo of Ada", "Cy of Ada", "Bo", "Cy"]


def test_numbers() -> None:
    company = office()
    Engine(company).run([Counted])

    assert names(company.badges) == ["Bo[1]", "Cy[1]", "Cy[2]"]


def test_a_copy_shares_what_lies_outside() -> None:
    class Twin(Rule):
        net = Node(pn.Net)
        page = Node(pn.Page, net=net)
        step = Index(upto=2)
        inside = Node(pn.Place, page=page)
        twin = Copy(page, into=net.pages, named=pn.Element, id="{original.id}.{step}")
        watch = New(pn.Transition, page=twin, id="watch {step}")
        joint = New(pn.Arc, page=twin, id="joint {step}", source=image(inside, twin), target=watch)
        where = [inside.tokens == 7]
        lhs = [net, page, step, inside]
        rhs = [*lhs, twin, watch, joint]

    outside = pn.Place(id="outside")
    original = pn.Place(id="inside", tokens=7)
    references = [pn.ReferencePlace(id="in", target=original), pn.ReferencePlace(id="out", target=outside)]
    page = pn.Page(id="page", objects=[original, *references])
    net = pn.Net(id="net", pages=[pn.Page(id="other", objects=[outside]), page])
    Engine(net).run([Twin])

    assert [each.id for each in net.pages] == ["other", "page", "page.1", "page.2"]
    for step, copied in enumerate(list(net.pages)[2:], 1):
        place, inner, outer, watch = copied.objects
        assert [each.id for each in copied.objects] == [
            f"inside.{step}",
            f"in.{step}",
            f"out.{step}",
            f"watch {step}",
        ]
        assert isinstance(inner, pn.ReferencePlace) and inner.target is place
        assert isinstance(outer, pn.ReferencePlace) and outer.target is outside
        (joint,) = copied.arcs
        assert (joint.source, joint.target) == (place, watch)
    assert references[0].target is original and len(page.arcs) == 0


def _is_older(person: Expression, friend: Expression) -> Expression:
    return friend.age > person.age


def test_functions() -> None:
    class Facts(Rule):
        person = Node(Person)
        house = Node(Company, of=ancestor(person.departments, Company))
        elder = Node(Person, of=first(person.friends, age=50))
        place = position(person)
        older = count(person.friends, partial(_is_older, person))
        made = badge("{house.name} {elder.name} {place} {older}", number=either(person.boss.age, 3))
        lhs = [person, house, elder]
        rhs = [*lhs, made]

    class Rest(Rule):
        person = Node(Person)
        made = badge("{person.name}", number=number(person.boss == None), rank="board")  # noqa: E711
        lhs = [person]
        rhs = [*lhs, made]

    company = office()
    Engine(company).run([Facts, Rest])

    assert names(company.badges) == ["office Ada 3 2", "Ada", "Bo", "Cy"]
    assert [made.number for made in company.badges] == [50, 1, 0, 0]
    assert company.badges[1].rank == Rank.getEEnumLiteral("board")


def test_literals_are_compared_by_name() -> None:
    class Upgrade(Rule):
        card = Node(Badge, rank="staff")
        owner = Node(Person, of=card.owner)
        made = badge("{owner.name} again", rank=card.rank)
        where = [card.rank != "visitor"]
        lhs = [card, owner]
        rhs = [*lhs, made]

    company = office()
    for person, rank in zip(company.people, ("staff", "visitor", "staff"), strict=True):
        company.badges.append(Badge(name="card", owner=person, rank=Rank.getEEnumLiteral(rank)))
    Engine(company).run([Upgrade])

    assert names(company.badges)[3:] == ["Ada again", "Cy again"]


def test_a_feature_called_like_an_attribute_of_expressions_can_be_matched() -> None:
    class Here(Rule):
        place = Node(Department)
        card = Node(Badge, location=place)
        made = badge("{card.name} in {place.name}")
        lhs = [place, card]
        rhs = [*lhs, made]

    company = office()
    (laboratory,) = company.departments
    company.badges.extend([Badge(name="one", location=laboratory), Badge(name="two")])
    Engine(company).run([Here])

    assert names(company.badges)[2:] == ["one in laboratory"]


def test_texts_may_be_given_names_of_their_own() -> None:
    class Titled(Rule):
        person = Node(Person)
        made = New(Badge, into=COMPANY.badges, name=Text("{who.name}!", who=person.boss))
        where = [person.boss.age > 0]
        lhs = [person]
        rhs = [*lhs, made]

    company = office()
    Engine(company).run([Titled])

    assert names(company.badges) == ["Ada!", "Ada!"]


@given(companies())
def test_rules_are_deterministic(company: Any) -> None:
    class Meet(Rule):
        one = Node(Person)
        other = Node(Person, of=one.friends)
        common = Node(Department, members=one)
        step = Index(upto=count(other.reports))
        made = badge("{one.name} {other.name} {common.name} {step}")
        lhs = [one, other, common, step]
        rhs = [*lhs, made]
        where = [other.age > one.age]

    results = []
    for _ in range(2):
        for old in list(company.badges):
            company.badges.remove(old)
        Engine(company).run([Meet])
        results.append(names(company.badges))

    assert results[0] == results[1]
    assert len(results[0]) == sum(
        len(other.reports)
        for one in company.people
        for other in one.friends
        if other.age > one.age
        for _ in one.departments
    )


def test_what_cannot_be_made_when_a_rule_runs_names_the_rule_and_its_line() -> None:
    class Unnumbered(Rule):
        person = Node(Person)
        made = New(Badge, into=COMPANY.badges, name="{person.name}", number=position(person.company))
        lhs = [person]
        rhs = [*lhs, made]

    with pytest.raises(RuleError) as caught:
        Engine(office()).run([Unnumbered])

    assert caught.value.message.startswith("Unnumbered.made cannot be created")
    assert caught.value.location is not None and caught.value.location.file == __file__


def test_a_number_to_count_to_that_is_absent_names_the_rule_line() -> None:
    class Endless(Rule):
        person = Node(Person)
        step = Index(upto=person.boss.age)
        made = badge("{person.name}")
        lhs = [person, step]
        rhs = [*lhs, made]

    with pytest.raises(RuleError) as caught:
        Engine(office()).run([Endless])

    assert caught.value.location is not None and caught.value.location.file == __file__
    assert caught.value.message.startswith("Endless")


def test_an_image_outside_of_the_copy_is_the_original_itself() -> None:
    company = office()
    person, twin = Node(Person), Node(Person)
    part = image(person.boss, twin)
    match = {IMAGES: {company.people[0]: {}}, person: company.people[1], twin: company.people[0]}

    assert part.evaluate(match) is company.people[0]


def test_an_image_in_what_no_rule_copied_names_the_rule_line() -> None:
    class Confused(Rule):
        person = Node(Person)
        twin = Node(Person, of=image(person.boss, person))
        made = badge("{twin.name}")
        lhs = [person, twin]
        rhs = [*lhs, made]

    with pytest.raises(RuleError, match="person is not a copy") as caught:
        Engine(office()).run([Confused])

    assert caught.value.location is not None and caught.value.location.file == __file__


def test_the_sides_follow_from_the_body() -> None:
    """What is forbidden or repeated is on neither side itself; lists say the same, or something else."""

    class Derived(Rule):
        person = Node(Person)
        boss = Node(Person)
        enemy = Node(Person, boss=person)
        absent = [Absent(enemy)]
        made = badge("{person.name}")
        friend = Node(Person, of=person.friends)
        met = badge("{friend.name}")
        each = ForAll([friend], make=[met])
        others = [badge("1"), badge("2")]

    class Shortened(Rule):
        person = Node(Person)
        gone = Node(Badge)
        made = badge("{person.name}")
        rhs = [person, made]

    def ids(items: Iterable[object]) -> list[int]:
        return [id(item) for item in items]  # == between them makes a condition

    assert ids(Derived.lhs) == ids([Derived.person, Derived.boss])
    assert ids(Derived.rhs) == ids([*Derived.lhs, Derived.made, Derived.each, *Derived.others])
    assert ids(Shortened.lhs) == ids([Shortened.person, Shortened.gone])
    assert ids(Shortened.deleted) == ids([Shortened.gone])


class _Employee(Pattern):
    def __init__(self, of: Node) -> None:
        self.employee = Node(Person, of=of.people)


class _Report(_Employee):
    """Extends the other pattern."""

    def __init__(self, of: Node) -> None:
        super().__init__(of)
        self.boss = Node(Person, of=self.employee.boss)


def test_a_pattern_stands_for_its_elements_in_their_order() -> None:
    class Written(Rule):
        first = Node(Person)
        company = Node(Company)
        employee = Node(Person, of=company.people)
        boss = Node(Person, of=employee.boss)
        last = Node(Person, of=employee.friends)
        made = badge("{employee.name} of {boss.name}, {last.name}")

    class Shared(Rule):
        first = Node(Person)
        company = Node(Company)
        report = _Report(company)
        last = Node(Person, of=report.employee.friends)
        made = badge("{employee.name} of {boss.name}, {last.name}")

    class Elsewhere(Rule):
        company = Node(Company)
        report = _Employee(company)
        made = badge("{employee.name}")

    def run(rule: type[Rule]) -> tuple[list[str], list[list[Any]]]:
        company = office()
        applications = Engine(company).run([rule])
        people = {person: person.name for person in company.people}
        return names(company.badges), [
            [people.get(source, "company") for source in application.sources] for application in applications
        ]

    assert [str(node) for node in Shared.lhs] == [str(node) for node in Written.lhs]
    assert run(Shared) == run(Written)
    assert len(run(Shared)[0]) > 1
    assert run(Elsewhere)[0] == names(office().people)
