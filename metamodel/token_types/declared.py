"""Which token types a model has, what each carries, and which of them the tokens of a place have."""

from __future__ import annotations

from dataclasses import replace

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.elements import label
from dineros.metamodel.limits import exceeds
from dineros.metamodel.positions import location_of
from dineros.metamodel.token_data import (
    EMPTY,
    FieldType,
    TokenType,
    field_type,
    field_value,
    range_of,
    read_json,
)
from dineros.metamodel.token_types.installed import UnknownInterfaceError, installed_fields


def type_of_place(place: pn.Node, net: pn.Net) -> sym.TokenType | None:
    """Return what the tokens of a place carry: the type it names, else the model's first; None: nothing."""
    named = place.tokenType if isinstance(place, sym.Place) else None
    if named is None and isinstance(net, (sym.SystemModel, rtm.RuntimeModel)):
        return net.tokenType
    return named


def token_type_of(declared: sym.TokenType | None) -> TokenType:
    """Return what a token type carries, with the default of every field.

    Raises
    ------
    SizeLimitError
        A list is longer than the limits of sizes allow; see `dineros.metamodel.limits`.
    UnknownInterfaceError
        It is a ROS message that is not installed.
    FeatureValueError
        A default does not fit its field.
    """
    if declared is None:
        return TokenType("Token", ())
    if declared.ros:
        try:
            return TokenType(label(declared), installed_fields(declared.ros), declared.ros)
        except UnknownInterfaceError as error:
            error.element, error.location = declared.id, location_of(declared)
            raise
    return TokenType(label(declared), tuple(_field_type(field) for field in declared.fields))


def _field_type(field: sym.TokenField) -> FieldType:
    too_long = exceeds("length", field.length or 0, f"the token field {field.name!r} has")
    if too_long is not None:
        raise too_long
    made = replace(field_type(field), range=range_of(field))
    if field.default is not None:
        return replace(made, default=field_value(made, read_json(field.default)))
    if made.kind == "list" and made.length:
        return replace(made, default=[EMPTY.get(made.element_kind, "")] * made.length)
    return made
