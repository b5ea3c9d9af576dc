"""Model objects hold their values as pyecore does: the same operations on both have the same effects."""

from __future__ import annotations

import cProfile
import tracemalloc
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pyecore.ecore import EClass
from pyecore.notification import EObserver
from pyecore.resources import URI, ResourceSet

from dineros.metamodel import generate, pn
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import elements
from dineros.metamodel.errors import FeatureValueError
from dineros.metamodel.files import load

KINDS = ("Net", "Page", "Page", "Place", "Place", "Transition", "Transition", "Arc", "Arc", "ReferencePlace")
SINGLE = ("page", "net", "source", "target", "interval", "graphics")
MANY = ("pages", "objects", "arcs", "outgoing", "incoming", "overrides", "suppressions")
ATTRIBUTES = {"name": ("n", None, 3), "tokens": (0, 2, "x"), "capacity": (1, None), "weight": (1, 4)}
"""Values that fit and values that do not."""


@pytest.fixture(scope="module")
def plain() -> dict[str, EClass]:
    """The same metamodel as pyecore makes it of the file: its classes without anything of ours."""
    file = Path(generate.__file__).parent / "pn.ecore"
    package = ResourceSet().get_resource(URI(str(file))).contents[0]
    return {each.name: each for each in package.eClassifiers}


class World:
    """Some objects, what was heard of them, and what they hold."""

    def __init__(self, classes: Any, heard: set[int]) -> None:
        self.objects = [classes(kind)() for kind in KINDS]
        self.numbers = {each: number for number, each in enumerate(self.objects)}
        self.heard: list[object] = []
        for number in heard:
            EObserver(self.objects[number], notifyChanged=self._hear)

    def _hear(self, notification: Any) -> None:
        self.heard.append(
            (
                self.numbers[notification.notifier],
                notification.kind.name,
                notification.feature.name,
                self._shown(notification.old),
                self._shown(notification.new),
            )
        )

    def _shown(self, value: Any) -> object:
        if isinstance(value, (list, tuple)) or hasattr(value, "items"):
            return [self._shown(each) for each in value]
        number = self.numbers.get(value) if getattr(value, "__hash__", None) else None
        return ("object", number) if number is not None else str(value)

    def do(self, operation: str, number: int, name: str, value: Any) -> bool:
        """Do something with a feature of one of the objects that have it; False where that is refused."""
        having = [each for each in self.objects if each.eClass.findEStructuralFeature(name)]
        element = having[number % len(having)]
        self.heard.clear()
        if name in ("page", "objects") and self._is_circle(element, name, value):
            return False
        try:
            if operation == "attribute":
                setattr(element, name, value)
            elif operation == "set":
                setattr(element, name, None if value is None else self.objects[value])
            elif operation == "extend":
                getattr(element, name).extend([self.objects[each] for each in value])
            elif operation == "insert":
                getattr(element, name).insert(0, self.objects[value])
            elif operation == "append":
                getattr(element, name).append(self.objects[value])
            elif operation == "remove":
                getattr(element, name).remove(self.objects[value])
            else:
                element.delete(recursive=False)
        except (TypeError, FeatureValueError, KeyError, ValueError, AttributeError):
            return False
        return True

    def _is_circle(self, element: Any, name: str, value: Any) -> bool:
        """Tell whether a page might come to contain itself; only the second one may stand on the first."""
        pages = [number for number, kind in enumerate(KINDS) if kind == "Page"]
        values = value if isinstance(value, list) else [value]
        pairs = [(each, self.numbers[element]) for each in values if each in pages]
        return self.numbers[element] in pages and any(
            (inner, outer) != (pages[1], pages[0])
            for inner, outer in (pairs if name == "objects" else [pair[::-1] for pair in pairs])
        )

    def state(self) -> list[object]:
        """What all objects hold: features, containers, what is set, and inverse relations."""
        return [
            (
                {
                    feature.name: self._shown(getattr(element, feature.name))
                    for feature in element.eClass.eAllStructuralFeatures()
                },
                self._shown(element.eContainer()),
                element.eContainmentFeature() and element.eContainmentFeature().name,
                sorted(feature.name for feature in element._isset),
                sorted((self.numbers[owner], feature.name) for owner, feature in element._inverse_rels),
            )
            for element in self.objects
        ]


NUMBERS = st.integers(0, len(KINDS) - 1)
OPERATIONS = st.one_of(
    st.tuples(st.just("set"), NUMBERS, st.sampled_from(SINGLE), st.none() | NUMBERS),
    st.tuples(st.sampled_from(("append", "insert", "remove")), NUMBERS, st.sampled_from(MANY), NUMBERS),
    st.tuples(st.just("extend"), NUMBERS, st.sampled_from(MANY), st.lists(NUMBERS, max_size=4)),
    st.tuples(st.just("delete"), NUMBERS, st.just("id"), st.none()),
    st.sampled_from(sorted(ATTRIBUTES)).flatmap(
        lambda name: st.tuples(
            st.just("attribute"), NUMBERS, st.just(name), st.sampled_from(ATTRIBUTES[name])
        )
    ),
)


@pytest.mark.long
@settings(max_examples=400, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(operations=st.lists(OPERATIONS, max_size=12), heard=st.sets(NUMBERS, max_size=3))
def test_operations_have_the_same_effects_as_with_pyecore(
    plain: dict[str, EClass], operations: list[tuple[str, int, str, Any]], heard: set[int]
) -> None:
    ours, theirs = World(lambda kind: getattr(pn, kind), heard), World(plain.__getitem__, heard)
    for operation in operations:
        is_done = ours.do(*operation)
        assert is_done == theirs.do(*operation)
        if not is_done and operation[0] == "extend":
            break  # pyecore forgets that what it added before the wrong object is set
        assert ours.state() == theirs.state()
        # pyecore deletes in the order of a set.
        assert sorted(map(str, ours.heard)) == sorted(map(str, theirs.heard))


def test_a_large_net_takes_few_steps_to_read_and_validate(tmp_path: Path) -> None:
    """Counted in calls, which no other load on the machine changes: 356 an element with pyecore alone."""
    count = 300
    lines = [f"tr t{each} p{each} p{each * 7 % count} -> p{each + 1}" for each in range(count)]
    path = tmp_path / "large.net"
    path.write_text("\n".join(lines), encoding="utf-8")
    validate(load(path))  # what is looked up once for each class
    profile = cProfile.Profile()
    net = profile.runcall(load, path)
    assert profile.runcall(validate, net) == []
    assert sum(entry.callcount for entry in profile.getstats()) < 200 * len(list(elements(net)))


def test_a_large_net_takes_little_memory(tmp_path: Path) -> None:
    """What most objects never need is not made: 2100 bytes an element with all that pyecore makes."""
    count = 300
    path = tmp_path / "large.net"
    lines = [f"tr t{each} p{each} -> p{each + 1}" for each in range(count)]
    path.write_text("\n".join(lines), encoding="utf-8")
    load(path)
    tracemalloc.start()
    net = load(path)
    size, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert size < 1700 * len(list(elements(net)))


def test_what_pyecore_expects_of_objects_is_there_when_it_asks() -> None:
    place = pn.Place(id="p")
    assert (place.listeners, place._eternal_listener, place._inverse_rels) == ([], [], set())  # type: ignore[attr-defined]
    assert place.listeners is place.listeners  # type: ignore[attr-defined]
    assert place.dyn_inst is place  # type: ignore[attr-defined]
    assert pn.Place.dyn_inst is pn.Place.eClass  # type: ignore[attr-defined]
    assert (place._staticEClass, pn.Place._staticEClass) == (False, True)  # type: ignore[attr-defined]
    assert not hasattr(pn.Place, "listeners")
    assert place in list(pn.Place.allInstances())  # type: ignore[attr-defined]
    assert place not in list(pn.Transition.allInstances())  # type: ignore[attr-defined]
