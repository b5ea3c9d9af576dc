"""Input signals and clauses in three variants (rules I1 to I6; paper, Fig. 11 and 12).

The variants differ in when a signal may change: at any time (fully-enabled), while the inputs of a transition
that uses it are marked (input-enabled), or while its inputs or its outputs are (io-enabled).

A signal with values has a place for each value, and a transition from each value to each other one.
"""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.clauses import start_value
from dineros.transformations.language import TRUTH, ForAll, Made, Meaning, Node, Pattern
from dineros.transformations.language.functions import Query, count, number, position
from dineros.transformations.rules.notation import SignalChange, ValueChange, arc, place, read
from dineros.transformations.rules.phases import Phase, SignalVariant, StandardRule

ENABLED: tuple[SignalVariant, ...] = ("fully-enabled", "input-enabled", "io-enabled")
"""All variants with signals."""


class HoldsAtStart(Query):
    """Whether a literal is true, or a signal has a value, at the start."""

    datatype = TRUTH
    _words = "{} at the start"

    @staticmethod
    def _answer(asked: sym.Literal | sym.SignalValue) -> bool:
        signal = asked.signal
        assert signal is not None, "values belong to signals"
        start = start_value(signal)
        if isinstance(asked, sym.SignalValue):
            return start == asked.name
        return (start == (True if asked.value is None else asked.value)) is not asked.negated


holds_at_start = HoldsAtStart


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

    where = [count(signal.literals) > 0, count(signal.values) == 0]


class I4Values(StandardRule, phase=Phase.signals, signals=ENABLED):
    """The value of a signal that is used and has several."""

    signal = Node(sym.InputSignal)
    value = Node(sym.SignalValue, of=signal.values)

    holds = place(
        "{signal.id}.{value.name}",
        tokens=number(holds_at_start(value)),
        means=Meaning("signal {signal} is {value}", value=True),
    )

    where = [count(signal.literals) > 0]


class I5FullyEnabled(StandardRule, phase=Phase.signals, signals=("fully-enabled",)):
    """A signal may change at any time."""

    signal = Node(sym.InputSignal)
    true = Made(I4.true, of=signal)
    false = Made(I4.false, of=signal)

    change = SignalChange("{signal.id}.toTrue", "{signal.id}.toFalse", true=true, false=false)


class I5ValuesFullyEnabled(StandardRule, phase=Phase.signals, signals=("fully-enabled",)):
    """A signal may change from each value to each other one at any time."""

    signal = Node(sym.InputSignal)
    old = Node(sym.SignalValue, of=signal.values)
    new = Node(sym.SignalValue, of=signal.values)
    before = Made(I4Values.holds, of=old)
    after = Made(I4Values.holds, of=new)

    change = ValueChange("{signal.id}.{old.name}.to.{new.name}", before=before, after=after)

    where = [old != new]


class I5InputEnabled(StandardRule, phase=Phase.signals, signals=("input-enabled", "io-enabled")):
    """A signal changes by transitions of its own for each transition that uses it."""

    transition = Node(sym.Transition)
    signal = Node(sym.InputSignal, of=transition.clause.disjunctions.literals.signal)
    true = Made(I4.true, of=signal)
    false = Made(I4.false, of=signal)

    change = SignalChange(
        "{signal.id}.toTrue.{transition.id}", "{signal.id}.toFalse.{transition.id}", true=true, false=false
    )


class I5ValuesInputEnabled(StandardRule, phase=Phase.signals, signals=("input-enabled", "io-enabled")):
    """A signal with values changes by transitions of its own for each transition that uses it."""

    transition = Node(sym.Transition)
    signal = Node(sym.InputSignal, of=transition.clause.disjunctions.literals.signal)
    old = Node(sym.SignalValue, of=signal.values)
    new = Node(sym.SignalValue, of=signal.values)
    before = Made(I4Values.holds, of=old)
    after = Made(I4Values.holds, of=new)

    change = ValueChange("{signal.id}.{old.name}.to.{new.name}.{transition.id}", before=before, after=after)

    where = [old != new]


class I6InputEnabled(StandardRule, phase=Phase.signals, signals=("input-enabled", "io-enabled")):
    """The changes of a signal may fire while all inputs of the transition are marked."""

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


class I6ValuesInputEnabled(StandardRule, phase=Phase.signals, signals=("input-enabled", "io-enabled")):
    """The changes of a signal with values may fire while all inputs of the transition are marked."""

    transition = Node(sym.Transition)
    signal = Node(sym.InputSignal, of=transition.clause.disjunctions.literals.signal)
    change = Made(I5ValuesInputEnabled.change, of=[transition, signal])
    incoming = Node(pn.Arc, target=transition)

    inputs = ForAll(
        [incoming],
        where=[incoming.kind != pn.ArcKind.inhibitor],
        make=[read(incoming.source, change.change, incoming.weight)],
    )


class I5IoEnabled(StandardRule, phase=Phase.signals, signals=("io-enabled",)):
    """A signal also changes by a second pair of transitions, for the outputs."""

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


class I5ValuesIoEnabled(StandardRule, phase=Phase.signals, signals=("io-enabled",)):
    """A signal with values also changes by second transitions, for the outputs."""

    transition = Node(sym.Transition)
    signal = Node(sym.InputSignal, of=transition.clause.disjunctions.literals.signal)
    old = Node(sym.SignalValue, of=signal.values)
    new = Node(sym.SignalValue, of=signal.values)
    before = Made(I4Values.holds, of=old)
    after = Made(I4Values.holds, of=new)

    change = ValueChange(
        "{signal.id}.{old.name}.to.{new.name}.Out.{transition.id}", before=before, after=after
    )

    where = [old != new]


class I6ValuesIoEnabled(StandardRule, phase=Phase.signals, signals=("io-enabled",)):
    """The second transitions may fire while all outputs of the transition are marked."""

    transition = Node(sym.Transition)
    signal = Node(sym.InputSignal, of=transition.clause.disjunctions.literals.signal)
    change = Made(I5ValuesIoEnabled.change, of=[transition, signal])
    outgoing = Node(pn.Arc, source=transition)
    tested = Node(pn.Arc, target=transition)

    outputs = ForAll([outgoing], make=[read(outgoing.target, change.change, outgoing.weight)])
    read_outputs = ForAll(
        [tested],
        where=[tested.kind == pn.ArcKind.read],
        make=[read(tested.source, change.change, tested.weight)],
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
        tokens=count(disjunction.literals, holds_at_start),
    )
    arcs = [read(true_literals, transition)]


class LiteralOfValue(Pattern):
    """A literal about a value of a signal, the place of this value, and a change of the signal."""

    def __init__(self, *, negated: bool) -> None:
        self.literal = Node(sym.Literal, negated=negated)
        self.disjunction = Node(sym.Disjunction, of=self.literal.disjunction)
        self.value = Node(sym.SignalValue, of=self.literal.signal.values, name=self.literal.value)
        self.true_literals = Made(I1.true_literals, of=self.disjunction)
        self.holds = Made(I4Values.holds, of=self.value)
        self.change = Made(ValueChange, of=self.value)


class I2(StandardRule, phase=Phase.signals, signals=ENABLED):
    """A plain literal counts while its signal is true; any transition may change the signal."""

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


class I2ValueGained(StandardRule, phase=Phase.signals, signals=ENABLED):
    """A plain literal about a value counts from when its signal gets the value."""

    of = LiteralOfValue(negated=False)

    arcs = [arc(of.change.change, of.true_literals)]

    where = [of.change.after == of.holds]


class I2ValueLost(StandardRule, phase=Phase.signals, signals=ENABLED):
    """A plain literal about a value counts until its signal loses the value."""

    of = LiteralOfValue(negated=False)

    arcs = [arc(of.true_literals, of.change.change)]

    where = [of.change.before == of.holds]


class I3ValueGained(StandardRule, phase=Phase.signals, signals=ENABLED):
    """A negated literal about a value counts until its signal gets the value."""

    of = LiteralOfValue(negated=True)

    arcs = [arc(of.true_literals, of.change.change)]

    where = [of.change.after == of.holds]


class I3ValueLost(StandardRule, phase=Phase.signals, signals=ENABLED):
    """A negated literal about a value counts from when its signal loses the value."""

    of = LiteralOfValue(negated=True)

    arcs = [arc(of.change.change, of.true_literals)]

    where = [of.change.before == of.holds]
