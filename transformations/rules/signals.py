"""Input signals and clauses in three variants (rules I1 to I6; paper, Fig. 11 and 12).

The variants differ in when a signal may change: at any time (fully-enabled), while the inputs of a transition
that uses it are marked (input-enabled), or while its inputs or its outputs are (io-enabled).
"""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.transformations.language.creation import ForAll
from dineros.transformations.language.functions import count, number, position
from dineros.transformations.language.meaning import Meaning
from dineros.transformations.language.patterns import Made, Node
from dineros.transformations.rules.notation import SignalChange, arc, place, read
from dineros.transformations.rules.phases import Phase, SignalVariant, StandardRule

ENABLED: tuple[SignalVariant, ...] = ("fully-enabled", "input-enabled", "io-enabled")
"""All variants with signals."""


class I4(StandardRule, phase=Phase.signals, signals=ENABLED):
    """The value of a signal that is used."""

    signal = Node(sym.InputSignal)

    true = place(
        "{signal.id}.true",
        tokens=number(signal.initial),
        means=Meaning("signal {signal} is true", value=True),
    )
    false = place(
        "{signal.id}.false",
        tokens=number(~signal.initial),
        means=Meaning("signal {signal} is false", value=False),
    )

    where = [count(signal.literals) > 0]


class I5FullyEnabled(StandardRule, phase=Phase.signals, signals=("fully-enabled",)):
    """A signal may change at any time."""

    signal = Node(sym.InputSignal)
    true = Made(I4.true, of=signal)
    false = Made(I4.false, of=signal)

    change = SignalChange("{signal.id}.toTrue", "{signal.id}.toFalse", true=true, false=false)


class I5InputEnabled(StandardRule, phase=Phase.signals, signals=("input-enabled", "io-enabled")):
    """A signal changes by transitions of its own for each transition that uses it."""

    transition = Node(sym.Transition)
    signal = Node(sym.InputSignal, of=transition.clause.disjunctions.literals.signal)
    true = Made(I4.true, of=signal)
    false = Made(I4.false, of=signal)

    change = SignalChange(
        "{signal.id}.toTrue.{transition.id}", "{signal.id}.toFalse.{transition.id}", true=true, false=false
    )


class I6InputEnabled(StandardRule, phase=Phase.signals, signals=("input-enabled", "io-enabled")):
    """They may fire while all inputs of the transition are marked."""

    transition = Node(sym.Transition)
    signal = Node(sym.InputSignal, of=transition.clause.disjunctions.literals.signal)
    change = Made(I5InputEnabled.change, of=[transition, signal])
    incoming = Node(pn.Arc, target=transition)

    inputs = ForAll(
        [incoming],
        where=[incoming.kind != pn.ArcKind.inhibitor],
        make=[
            read(incoming.source, change.to_true, incoming.weight),
            read(incoming.source, change.to_false, incoming.weight),
        ],
    )


class I5IoEnabled(StandardRule, phase=Phase.signals, signals=("io-enabled",)):
    """In addition, a second pair of transitions for the outputs."""

    transition = Node(sym.Transition)
    signal = Node(sym.InputSignal, of=transition.clause.disjunctions.literals.signal)
    true = Made(I4.true, of=signal)
    false = Made(I4.false, of=signal)

    change = SignalChange(
        "{signal.id}.toTrueOut.{transition.id}",
        "{signal.id}.toFalseOut.{transition.id}",
        true=true,
        false=false,
    )


class I6IoEnabled(StandardRule, phase=Phase.signals, signals=("io-enabled",)):
    """The second pair may fire while all outputs of the transition are marked."""

    transition = Node(sym.Transition)
    signal = Node(sym.InputSignal, of=transition.clause.disjunctions.literals.signal)
    change = Made(I5IoEnabled.change, of=[transition, signal])
    outgoing = Node(pn.Arc, source=transition)
    tested = Node(pn.Arc, target=transition)

    outputs = ForAll(
        [outgoing],
        make=[
            read(outgoing.target, change.to_true, outgoing.weight),
            read(outgoing.target, change.to_false, outgoing.weight),
        ],
    )
    # A read arc represents a pair of normal arcs: its place is an output as well.
    read_outputs = ForAll(
        [tested],
        where=[tested.kind == pn.ArcKind.read],
        make=[
            read(tested.source, change.to_true, tested.weight),
            read(tested.source, change.to_false, tested.weight),
        ],
    )


class I1(StandardRule, phase=Phase.signals, signals=ENABLED):
    """A disjunction of a clause: as many tokens as it has true literals; the transition needs one."""

    transition = Node(sym.Transition)
    disjunction = Node(sym.Disjunction, of=transition.clause.disjunctions)
    place_number = position(disjunction)

    true_literals = place(
        "{transition.id}.D{place_number}",
        tokens=count(disjunction.literals, lambda literal: literal.signal.initial != literal.negated),
    )
    arcs = [read(true_literals, transition)]


class I2(StandardRule, phase=Phase.signals, signals=ENABLED):
    """A plain literal counts while its signal is true, whichever transitions change the signal."""

    literal = Node(sym.Literal, negated=False)
    disjunction = Node(sym.Disjunction, of=literal.disjunction)
    signal = Node(sym.InputSignal, of=literal.signal)
    true_literals = Made(I1.true_literals, of=disjunction)
    change = Made(SignalChange, of=signal)

    arcs = [arc(change.to_true, true_literals), arc(true_literals, change.to_false)]


class I3(StandardRule, phase=Phase.signals, signals=ENABLED):
    """A negated literal counts while its signal is false."""

    literal = Node(sym.Literal, negated=True)
    disjunction = Node(sym.Disjunction, of=literal.disjunction)
    signal = Node(sym.InputSignal, of=literal.signal)
    true_literals = Made(I1.true_literals, of=disjunction)
    change = Made(SignalChange, of=signal)

    arcs = [arc(change.to_false, true_literals), arc(true_literals, change.to_true)]
