"""A metamodel that has nothing to do with nets, made at run time: companies, people, departments, badges."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from hypothesis import strategies as st
from pyecore.ecore import EAttribute, EClass, EEnum, EInt, EPackage, EReference, EString

from dineros.transformations.language.creation import New
from dineros.transformations.language.functions import count
from dineros.transformations.language.patterns import Context, Index, Node
from dineros.transformations.language.rule import Rule

Rank = EEnum("Rank", literals=["visitor", "staff", "board"])
_package = EPackage("office", nsURI="http://example.org/office", nsPrefix="office")
_company, _person, _manager, _department, _badge = (
    EClass("Company"),
    EClass("Person"),
    EClass("Manager"),
    EClass("Department"),
    EClass("Badge"),
)
_manager.eSuperTypes.append(_person)
for _class in (_company, _person, _manager, _department, _badge):
    _class.eStructuralFeatures.append(EAttribute("name", EString))
    _package.eClassifiers.append(_class)
_manager.eStructuralFeatures.remove(_manager.findEStructuralFeature("name"))
_package.eClassifiers.append(Rank)
_person.eStructuralFeatures.append(EAttribute("age", EInt))
_badge.eStructuralFeatures.append(EAttribute("number", EInt))
_badge.eStructuralFeatures.append(EAttribute("rank", Rank))


def _reference(owner: EClass, name: str, target: EClass, **more: Any) -> EReference:
    made = EReference(name, target, **more)
    owner.eStructuralFeatures.append(made)
    return made


def _opposites(one: EReference, other: EReference) -> None:
    one.eOpposite = other


_opposites(
    _reference(_company, "people", _person, upper=-1, containment=True),
    _reference(_person, "company", _company),
)
_reference(_company, "departments", _department, upper=-1, containment=True)
_reference(_company, "badges", _badge, upper=-1, containment=True)
_opposites(
    _reference(_department, "members", _person, upper=-1),
    _reference(_person, "departments", _department, upper=-1),
)
_opposites(_reference(_person, "boss", _person), _reference(_person, "reports", _person, upper=-1))
_reference(_person, "friends", _person, upper=-1)
_reference(_department, "lead", _person)
_reference(_badge, "owner", _person)
_reference(_badge, "location", _department)  # called like an attribute of expressions

Company: Any = _company.python_class
Person: Any = _person.python_class
Manager: Any = _manager.python_class
Department: Any = _department.python_class
Badge: Any = _badge.python_class


@st.composite
def companies(draw: st.DrawFn, people: int = 5) -> Any:
    """Return a company of up to `people` people and three departments, related at random."""
    company = Company(name="company")
    for number in range(draw(st.integers(0, people))):
        kind = Manager if draw(st.booleans()) else Person
        company.people.append(kind(name=f"person{number}", age=draw(st.integers(1, 3))))
    staff = list(company.people)
    for number in range(draw(st.integers(0, 3))):
        department = Department(name=f"department{number}")
        company.departments.append(department)
        if staff:
            department.members.extend(draw(st.lists(st.sampled_from(staff), max_size=4, unique_by=id)))
            department.lead = draw(st.sampled_from([None, *staff]))
    for person in staff:
        person.boss = draw(st.sampled_from([None, *staff]))
        person.friends.extend(draw(st.lists(st.sampled_from(staff), max_size=3, unique_by=id)))
    for number in range(draw(st.integers(0, 3)) if staff else 0):
        badge = Badge(name=f"badge{number}", number=draw(st.integers(1, 3)))
        badge.rank = Rank.getEEnumLiteral(draw(st.sampled_from(["visitor", "staff"])))
        badge.owner = draw(st.sampled_from([None, *staff]))
        if company.departments:
            badge.location = draw(st.sampled_from([None, *company.departments]))
        company.badges.append(badge)
    return company


COMPANY = Context(Company)


def badge(name: str, **features: object) -> New:
    """Make a badge of the company."""
    return New(Badge, into=COMPANY.badges, name=name, **features)


class BadgeForEach(Rule):
    person = Node(Person)
    made = badge("{person.name}", owner=person, number=person.age)

    lhs = [person]
    rhs = [*lhs, made]


class Counted(Rule):
    person = Node(Person)
    step = Index(upto=count(person.friends))
    made = badge("{person.name}[{step}]", number=step, owner=person)
    lhs = [person, step]
    rhs = [*lhs, made]


def names(elements: Iterable[Any]) -> list[str]:
    return [element.name for element in elements]


def office() -> Any:
    """Return a company: Ada leads Bo and Cy, who are friends; Bo and Cy work in the laboratory."""
    company = Company(name="office")
    ada = Manager(name="Ada", age=50)
    bo, cy = Person(name="Bo", age=30, boss=ada), Person(name="Cy", age=20, boss=ada)
    bo.friends.append(cy)
    cy.friends.extend([bo, ada])
    company.people.extend([ada, bo, cy])
    company.departments.append(Department(name="laboratory", lead=bo, members=[bo, cy]))
    return company
