"""Storage of values in model objects: smaller than pyecore's own, with the same behaviour.

pyecore wraps each value of each object and prepares a notification for each change. In large models this is
mostly useless: most objects are new and have no listeners. Here

* an attribute is stored directly in the `__dict__` of its object, so that Python reads it itself;
* what pyecore gives each object and most never need (listeners, inverse relations) is made when first read;
* a reference is connected to its opposite and its container in few steps if the objects are not connected
  yet and have no listeners. In all other cases pyecore does it.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Collection, Iterable, Iterator
from functools import cache, partial
from typing import TYPE_CHECKING, Any, NamedTuple, dataclass_transform

from pyecore.ecore import EAttribute, EReference
from pyecore.innerutils import InternalSet
from pyecore.notification import Kind, Notification
from pyecore.valuecontainer import BadValueError, EcoreUtils, EOrderedSet, EValue

if TYPE_CHECKING:

    @dataclass_transform(eq_default=False, kw_only_default=True)
    class MetaEClass(type):
        """Static view of pyecore's metaclass of model classes."""

        eClass: Any  # noqa: N815 (pyecore's name)

else:
    from pyecore.ecore import MetaEClass as _MetaEClass

    class MetaEClass(_MetaEClass):
        """Metaclass of model classes; replaces pyecore's access to features by a shorter one."""

        def __init__(self, name: str, bases: tuple[type, ...], namespace: dict[str, Any]) -> None:
            super().__init__(name, bases, namespace)
            self.__new__ = staticmethod(new_object)
            self._staticEClass = _Static()
            self.dyn_inst = _Dynamic()
            self.allInstances = staticmethod(partial(_instances_of, self))
            for key in ("_internal_id", "_container", "_containment_feature", "_eresource"):
                setattr(self, key, None)
            for key, make in (("listeners", list), ("_eternal_listener", list), ("_inverse_rels", set)):
                setattr(self, key, _Lazy(key, make))
            for key, feature in namespace.items():
                if isinstance(feature, EAttribute):
                    setattr(self, key, _Attribute(feature))
                elif isinstance(feature, EReference):
                    feature.derived_class = ObjectSet
                    setattr(self, key, (_References if feature.many else _Reference)(key, feature))

        def __call__(self, *values: object, **features: object) -> Any:
            """Make an object, unless the class is abstract."""
            if _is_abstract(self):
                return super().__call__(*values, **features)  # an error
            return type.__call__(self, *values, **features)


@cache
def _is_abstract(cls: MetaEClass) -> bool:
    return bool(cls.eClass.abstract)


class _Attribute:
    """Returns the default of an attribute; a value in the `__dict__` of the object takes precedence."""

    __slots__ = ("_default", "_feature")

    def __init__(self, feature: Any) -> None:
        self._feature = feature
        self._default = feature.get_default_value()

    def __get__(self, instance: object, owner: type | None = None) -> object:
        return self._feature if instance is None else self._default


class _Reference:
    """Gets and sets the object of a single-valued reference."""

    __slots__ = ("_feature", "_name")

    def __init__(self, name: str, feature: Any) -> None:
        self._name = name
        self._feature = feature

    def __get__(self, instance: Any, owner: type | None = None) -> object:
        if instance is None:
            return self._feature
        try:
            return instance.__dict__[self._name]._value
        except KeyError:
            return self._feature.__get__(instance, owner)

    def __set__(self, instance: Any, value: object) -> None:
        set_reference(instance, self._feature, value)

    def __delete__(self, instance: Any) -> None:
        self._feature.__delete__(instance)


class _References(_Reference):
    """Gets the set of objects of a many-valued reference, and replaces its content."""

    __slots__ = ()

    def __get__(self, instance: Any, owner: type | None = None) -> object:
        if instance is None:
            return self._feature
        try:
            return instance.__dict__[self._name]
        except KeyError:
            return self._feature.__get__(instance, owner)

    def __set__(self, instance: Any, value: object) -> None:
        self._feature.__set__(instance, value)


class _Facts(NamedTuple):
    """Properties of a reference, without pyecore's computed attributes."""

    name: str
    containment: bool
    container: bool
    opposite: Any
    opposite_many: bool
    fitting: set[type]
    """Classes whose objects are known to have the right type."""


@cache
def _facts(feature: Any) -> _Facts:
    opposite = feature.eOpposite
    return _Facts(
        feature.name,
        bool(feature.containment),
        opposite is not None and bool(opposite.containment),
        opposite,
        opposite is not None and bool(opposite.many),
        set(),
    )


class _Held(EValue):
    """The object that pyecore expects in the `__dict__` of an object for a single-valued reference."""

    is_ref = True
    generic_type = None

    def __init__(self, owner: Any, feature: Any, containment: bool, value: object) -> None:
        self.owner = owner
        self.feature = feature
        self.is_cont = containment
        self._value = value


class _Lazy:
    """Makes the value of an attribute of pyecore when it is first read; the `__dict__` takes precedence."""

    __slots__ = ("_make", "_name")

    def __init__(self, name: str, make: Callable[[], object]) -> None:
        self._name = name
        self._make = make

    def __get__(self, instance: Any, owner: type) -> object:
        if instance is None:
            raise AttributeError(f"type object {owner.__name__!r} has no attribute {self._name!r}")
        made = instance.__dict__[self._name] = self._make()
        return made


class _Static:
    """Tells pyecore that a class is one of a metamodel, and that an object of it is not."""

    def __get__(self, instance: object, owner: type) -> bool:
        return instance is None


class _Dynamic:
    """Gives the object of pyecore that stands for a class, or an object itself."""

    def __get__(self, instance: object, owner: Any) -> object:
        return owner.eClass if instance is None else instance


def _instances_of(cls: type, resources: Collection[object] | None = None) -> Iterator[Any]:
    """Yield the living objects of a class, in some resources if they are given: pyecore's `allInstances`.

    pyecore keeps a weak reference to each object for it, which here would be a tenth of the reading time.
    """
    found: list[Any] = gc.get_objects()
    for each in found:
        is_one = isinstance(type(each), MetaEClass) and isinstance(each, cls)
        if is_one and (not resources or each.eResource in resources):
            yield each


def new_object(cls: type, *_: object, **__: object) -> Any:
    """Make an object with what pyecore needs of it at once; the `__new__` of every model class."""
    made: Any = object.__new__(cls)
    made.__dict__["_isset"] = InternalSet()
    return made


def is_heard(element: Any) -> bool:
    """Return whether an object, or the resource that contains it, has listeners to changes."""
    held = element.__dict__
    if held.get("listeners") or held.get("_eternal_listener"):
        return True
    while (container := held.get("_container")) is not None:
        element = container
        held = element.__dict__
    return element._eresource is not None


def set_attribute(element: Any, feature: Any, value: object) -> None:
    """Set an attribute.

    Raises
    ------
    BadValueError
        The value does not fit the type of the attribute.
    """
    if not EcoreUtils.isinstance(value, feature._eType):
        raise BadValueError(value, feature._eType, feature)
    held, name = element.__dict__, feature._name
    if is_heard(element):
        previous = getattr(element, name)
        held[name] = value
        kind = Kind.UNSET if value is None else Kind.SET
        element.notify(Notification(old=previous, new=value, feature=feature, kind=kind))
    else:
        held[name] = value
    element._isset[feature] = None


def set_reference(element: Any, feature: Any, value: Any) -> None:
    """Set a reference, its opposite and the container.

    Raises
    ------
    BadValueError
        The value does not fit the type of the reference.
    """
    facts = _facts(feature)
    own = element.__dict__
    held = own.get(facts.name)
    is_simple = not facts.container and (held is None or held._value is None)
    if value is None or not is_simple or is_heard(element) or not _link(element, feature, facts, value):
        feature.__set__(element, value)
        return
    if held is None:
        own[facts.name] = _Held(element, feature, facts.containment, value)
    else:
        held._value = value
    own["_isset"][feature] = None


def _link(element: Any, feature: Any, facts: _Facts, value: Any) -> bool:
    """Set the container and the opposite of a new value of a reference.

    Returns
    -------
    bool
        False, without any change, if pyecore must do it: for proxies and wrong classes, if the value has
        listeners, or if it has a container or an opposite already.
    """
    kind = type(value)
    if kind not in facts.fitting:
        if not isinstance(kind, MetaEClass) or not EcoreUtils.isinstance(value, feature._eType):
            return False
        facts.fitting.add(kind)
    if is_heard(value):
        return False
    own = value.__dict__
    if facts.containment and own.get("_container") is not None:
        return False
    opposite = facts.opposite
    if opposite is None:
        value._inverse_rels.add((element, feature))
    elif facts.opposite_many:
        members = own.get(opposite._name)
        if members is None:
            members = own[opposite._name] = ObjectSet(value, opposite)
        if element not in members.map:
            members.map[element] = len(members.items)
            members.items.append(element)
        own["_isset"][opposite] = None
    else:
        held = own.get(opposite._name)
        if held is None:
            own[opposite._name] = _Held(value, opposite, facts.container, element)
        elif held._value is None:
            held._value = element
        else:
            return False
        own["_isset"][opposite] = None
    if facts.containment:
        own["_container"] = element
        own["_containment_feature"] = feature
    return True


class ObjectSet(EOrderedSet):
    """The value of a many-valued reference: an ordered set of objects."""

    is_ref = True
    generic_type = None
    _orderedset_update = False

    def __init__(self, owner: Any, feature: Any) -> None:
        self.owner = owner
        self.feature = feature
        self.is_cont = _facts(feature).containment
        self.items: list[Any] = []
        self.map: dict[Any, int] = {}

    @staticmethod
    def create(owner: Any, feature: Any) -> ObjectSet:
        """Make the empty set of an object; called by pyecore."""
        return ObjectSet(owner, feature)

    def insert_quietly(self, value: Any) -> None:
        """Add an object that is already connected."""
        if value not in self.map:
            self.map[value] = len(self.items)
            self.items.append(value)
        self.owner._isset[self.feature] = None

    def add(self, value: Any, update_opposite: bool = True) -> None:
        """Add an object."""
        feature = self.feature
        if (
            update_opposite
            and not is_heard(self.owner)
            and _link(self.owner, feature, _facts(feature), value)
        ):
            self.insert_quietly(value)
        else:
            super().add(value, update_opposite)

    append = add

    def update(self, values: Iterable[Any]) -> None:
        """Add objects."""
        if is_heard(self.owner):
            super().update(values)
            return
        facts, owner, known = _facts(self.feature), self.owner, self.map
        for value in values:
            if facts.containment and value not in known and _link(owner, self.feature, facts, value):
                known[value] = len(self.items)
                self.items.append(value)
            else:
                self.add(value)
        owner._isset[self.feature] = None

    extend = update
