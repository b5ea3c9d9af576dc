"""A door that opens, jams and closes, with two signals: a small model to ask properties of."""

from __future__ import annotations

from typing import Any

from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.clauses import set_clause


def door() -> sym.SystemModel:
    """Return the door: `Open` needs Button, `Close` needs Calm; neither clause matters without signals."""
    closed, opened, jammed = sym.Place(id="Closed", tokens=1), sym.Place(id="Opened"), sym.Place(id="Jammed")
    moves = [sym.Transition(id=name) for name in ("Open", "Close", "Jam", "Free")]
    node = sym.NodeNet(id="door", objects=[closed, opened, jammed, *moves])
    node.signals.extend([sym.InputSignal(id=name, name=name) for name in ("Button", "Calm")])
    open_, close, jam, free = moves
    flow(closed, open_, opened, close, closed)
    flow(opened, jam, jammed, free, opened)
    model = sym.SystemModel(id="entrance", tokenType=sym.TokenType(id="Nothing"), pages=[node])
    set_clause(open_, "Button")
    set_clause(close, "Calm")
    return model


def ask(model: sym.SystemModel, text: str, **features: Any) -> sym.Property:
    """Store a property in a model, and return it."""
    property = sym.Property(id=f"property{len(model.properties)}", text=text, **features)
    model.properties.append(property)
    return property
