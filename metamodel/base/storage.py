"""Storage of values in model objects: smaller than pyecore's own, with the same behaviour.

pyecore wraps each value of each object and prepares a notification for each change. In large models this is
mostly useless: most objects are new and have no listeners. Here

* an attribute is stored directly in the `__dict__` of its object, so that Python reads it itself;
* a reference is connected to its opposite and its container in few steps if the objects are not connected
  yet and have no listeners. In all other cases pyecore does it.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
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

    def __init__(self, owner: Any, feature: Any, containment: bool, value: object) -> None:
        self.owner = owner
        self.feature = feature
        self.is_ref = True
        self.is_cont = containment
        self.generic_type = None
        self._value = value


def new_object(cls: type, *_: object, **__: object) -> Any:
    """Make an object with the attributes that pyecore gives it; the `__new__` of every model class."""
    made: Any = object.__new__(cls)
    made.__dict__.update(
        _internal_id=None,
        _isset=InternalSet(),
        _container=None,
        _containment_feature=None,
        _eresource=None,
        listeners=[],
        _eternal_listener=[],
        _inverse_rels=set(),
        _staticEClass=False,
        dyn_inst=made,
    )
    cls._instances.add(made)  # type: ignore[attr-defined]
    return made


def is_heard(element: Any) -> bool:
    """Return whether an object, or the resource that contains it, has listeners to changes."""
    if element.listeners or element._eternal_listener:
        return True
    while element._container is not None:
        element = element._container
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
    held = element.__dict__.get(facts.name)
    is_simple = not facts.container and (held is None or held._value is None)
    if value is None or not is_simple or is_heard(element) or not _link(element, feature, facts, value):
        feature.__set__(element, value)
    elif held is None:
        element.__dict__[facts.name] = _Held(element, feature, facts.containment, value)
        element._isset[feature] = None
    else:
        held._value = value
        element._isset[feature] = None


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
    if facts.containment and own["_container"] is not None:
        return False
    opposite = facts.opposite
    if opposite is None:
        own["_inverse_rels"].add((element, feature))
    elif facts.opposite_many:
        members = own.get(opposite._name)
        if members is None:
            members = own[opposite._name] = ObjectSet(value, opposite)
        members.insert_quietly(element)
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

    def __init__(self, owner: Any, feature: Any) -> None:
        self.owner = owner
        self.feature = feature
        self.is_ref = True
        self.is_cont = _facts(feature).containment
        self.generic_type = None
        self._orderedset_update = False
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
        for value in values:
            self.add(value)
        self.owner._isset[self.feature] = None

    extend = update
