"""Token types and balloon tokens: fields, defaults, and data that fits them (paper, Sect. 5.2)."""

from __future__ import annotations

import keyword

from dineros.metamodel import sym
from dineros.metamodel.base import EObject
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.errors import FeatureValueError
from dineros.metamodel.token_data import field_type, field_value, range_of, read_data, read_json, ros_scalar


def _field(field: sym.TokenField) -> tuple[EObject | None, str]:
    return (field.eContainer(), field.name)


def _collects(field: sym.TokenField) -> bool:
    return field.kind in (sym.FieldKind.list, sym.FieldKind.map)


def _has_range(field: sym.TokenField) -> bool:
    return any(part is not None for part in (field.minimum, field.maximum, field.values))


def _type_of(balloon: sym.BalloonToken, index: Index) -> sym.TokenType | None:
    place = balloon.eContainer()
    return index.token_type_of(place) if isinstance(place, sym.Place) else None


@constraint("{it} has the name of another field", fix="give it another name")
def field_unique(field: sym.TokenField, index: Index) -> Outcome:
    """The fields of a token type have different names."""
    return index.earliest(field, sym.TokenField, _field) is field


@constraint(
    "{it} has no name that Python and ROS interfaces can use",
    fix="use letters, digits and _, starting with a letter, that is not a keyword",
)
def field_name_valid(field: sym.TokenField, index: Index) -> Outcome:
    """A field has an identifier as its name."""
    name = field.name
    return name.isidentifier() and name.isascii() and name[0] != "_" and not keyword.iskeyword(name)


@constraint(
    "{it} of the kind {element.kind} has the length {element.length}",
    fix="use a length of 1 or more, for lists only",
    guard=lambda field, index: field.length is not None,
)
def field_length(field: sym.TokenField, index: Index) -> Outcome:
    """Only a list has a length, of 1 or more."""
    return field.kind == sym.FieldKind.list and field.length is not None and field.length >= 1


@constraint(
    "{it} is a {element.kind} of elements of the kind {element.elementKind}",
    fix="use text, integer, number or boolean elements",
    guard=lambda field, index: _collects(field),
)
def field_elements_simple(field: sym.TokenField, index: Index) -> Outcome:
    """Lists and maps do not nest."""
    return field.elementKind not in (sym.FieldKind.list, sym.FieldKind.map)


@constraint(
    "{it} has the bound {element.bound}",
    fix="use a bound of 1 or more, for lists without a length only",
    guard=lambda field, index: field.bound is not None,
)
def field_bound(field: sym.TokenField, index: Index) -> Outcome:
    """Only a list without a length has a bound, of 1 or more."""
    is_list = field.kind == sym.FieldKind.list
    return is_list and field.length is None and field.bound is not None and field.bound >= 1


@constraint(
    "{it} of the kind {found} has the ROS type {element.ros!r}",
    fix="use a ROS type of the kind, such as uint8, float32 or string<=20, or none",
    guard=lambda field, index: field.ros is not None,
)
def field_ros_fits(field: sym.TokenField, index: Index) -> Outcome:
    """The ROS type of a field carries values, or elements, of its kind."""
    kind, scalar = field_type(field).scalar, ros_scalar(field.ros or "")
    return (scalar is not None and scalar.kind == kind) or kind


@constraint(
    "{it} has no valid range: {found}",
    fix="give an integer a minimum and a maximum, or named values: IDLE=0, BUSY=1",
    guard=lambda field, index: _has_range(field),
)
def field_range(field: sym.TokenField, index: Index) -> Outcome:
    """Only an integer has a range, which is not empty and fits its ROS type."""
    try:
        range_of(field)
    except FeatureValueError as error:
        return error
    return True


@constraint(
    "{it} has no default, and 0 is not in its range",
    fix="give it a default of its range",
    guard=lambda field, index: _has_range(field) and field.default is None,
)
def field_range_default(field: sym.TokenField, index: Index) -> Outcome:
    """A field without a default has 0 in its range."""
    return field_type(field).range.fault(0) is None


@constraint(
    "{it} names a value {found}, as another field of its token type does",
    fix="give the values different names, such as DOOR_OPEN and GATE_OPEN",
    guard=lambda field, index: field.values is not None,
)
def value_names_unique(field: sym.TokenField, index: Index) -> Outcome:
    """Named values of a token type have different names: they become constants of one message."""
    owner = field.eContainer()
    others = list(owner.fields) if isinstance(owner, sym.TokenType) else []
    earlier: set[str] = set()
    for other in others:
        if other is field:
            break
        earlier.update(name for name, _ in field_type(other).range.names)
    return next((name for name, _ in field_type(field).range.names if name in earlier), True)


@constraint(
    "{it} has a default that does not fit: {found}",
    fix="write the default as JSON of the field's kind",
    guard=lambda field, index: field.default is not None,
)
def field_default_fits(field: sym.TokenField, index: Index) -> Outcome:
    """The default of a field is JSON of its kind."""
    word = (field.default or "").strip('" ')
    number = field_type(field).range.value_of(word)
    if number is not None:
        return f"it is a number, and {word} names {number}"
    try:
        field_value(field_type(field), read_json(field.default or ""))
    except FeatureValueError as error:
        return error
    return True


@constraint(
    "{it} does not fit the token type: {found}",
    fix="write a JSON object with fields of the token type",
    guard=lambda balloon, index: _type_of(balloon, index) is not None,
)
def balloon_fits(balloon: sym.BalloonToken, index: Index) -> Outcome:
    """The data of a balloon token is a JSON object whose values fit the token type of its place."""
    fields = index.fields_of(_type_of(balloon, index))
    if fields is None:
        return True  # its ROS message is not installed here
    try:
        read_data(balloon.data, fields)
    except FeatureValueError as error:
        return error
    return True


@constraint(
    "{it} carries data, but the model has no token type",
    fix="add a token type with a field for each name in the data",
    severity="warning",
    guard=lambda balloon, index: _type_of(balloon, index) is None,
)
def balloon_has_type(balloon: sym.BalloonToken, index: Index) -> Outcome:
    """If tokens carry data, the model specifies which."""
    return balloon.data.strip() in ("", "{}")


@constraint("{it} has {found} balloon tokens but {element.tokens} tokens", fix="remove data or add tokens")
def balloons_are_tokens(place: sym.Place, index: Index) -> Outcome:
    """A place has data for at most as many tokens as it holds."""
    count = len(place.balloons) if place.eIsSet("balloons") else 0
    return count <= max(place.tokens, 0) or str(count)
