"""The properties that a model stores, on the command line: one answered, all written, others taken in."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.analysing import HOLDS, UNKNOWN, VIOLATED, load_valid, reading_formula, write_witness
from dineros.cli.asking import Backing, answered
from dineros.cli.console import say_json, summarise, warn
from dineros.cli.models import rules_of
from dineros.cli.presentation.answers import say_verdict
from dineros.cli.searching import search
from dineros.metamodel.errors import DinerosError, Location

if TYPE_CHECKING:
    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.symbolic.order_cache import OrderCache
    from dineros.metamodel import pn


def verify_stored(
    model: Path,
    name: str,
    settings: Sequence[str],
    overflow: str,
    orders: OrderCache | None,
    backing: Backing,
    *,
    engine: str = "auto",
    scheduler: str | None = None,
    output: Path | None = None,
    as_json: bool = False,
) -> int:
    """Decide a property that a model stores; the exit status tells whether that is as expected."""
    from dineros.analysis.evidence.proving import Asked
    from dineros.analysis.requirements.stored import VARIANTS, asked, property_named
    from dineros.analysis.witnesses.findings import witness_of

    run = search()
    net = load_valid(model, settings)
    with reading_formula(str(model)):
        property = property_named(net, name)
    with reading_formula(f"property {property.id}"):
        stored = asked(property, overflow=overflow)  # type: ignore[arg-type]
    is_expected = bool(property.expected)

    def say(verdict: Outcome) -> int:
        witness = None
        if verdict.stem or verdict.loop:
            loop = len(verdict.stem) if verdict.loop else None
            witness = witness_of(stored.subject, [*verdict.stem, *verdict.loop], loop)
        if output is not None and witness is not None:
            write_witness(witness, output, model, settings, str(property.text), verdict.status)
        if as_json:
            say_json(
                {
                    "model": str(model),
                    **rules_of(net),
                    "property": str(property.id),
                    "text": str(property.text),
                    "formula": str(stored.reading.formula),
                    "expected": is_expected,
                    "status": verdict.status,
                    "reason": verdict.reason,
                    "by": verdict.by,
                    "states": verdict.states,
                    "seconds": verdict.seconds,
                    "witness": witness.to_dict() if witness else None,
                    **backing.to_dict(),
                }
            )
        else:
            expected = "" if is_expected else "; expected not to hold"
            shown = f"{property.id}: {property.text}{expected}"
            is_linear = stored.reading.logic == "ltl" and not stored.reading.is_negated
            say_verdict(verdict, shown, witness, model, output, is_linear=is_linear)
        backing.say(verdict, as_json)
        if verdict.status == "unknown":
            return UNKNOWN
        return HOLDS if (verdict.status == "holds") == is_expected else VIOLATED

    run.draft(lambda ending: say(run.unknown(ending)))
    variant = VARIANTS[str(property.signals)]
    reading = stored.reading
    question = Asked(stored.subject, reading.logic, str(reading.formula), variant, overflow, settings)
    more = {"weak": stored.weak, "strong": stored.strong}
    verdict = answered(question, stored.question(orders), run, backing, engine, scheduler, **more)
    with run.answer():
        return say(stored.verdict(verdict))


def write_stored(model: Path, settings: Sequence[str], overflow: str, output: Path) -> int:
    """Write the properties that a model stores as a property file of the contest.

    Raises
    ------
    DinerosError
        The model stores none that such a file can say.
    """
    from lxml import etree

    from dineros.analysis.model.subject import base_subject
    from dineros.analysis.properties import writing
    from dineros.analysis.properties.property import Property
    from dineros.analysis.requirements.stored import properties_of, read

    net = load_valid(model, settings)
    subject = base_subject(net, overflow)  # type: ignore[arg-type]
    said: list[Property] = []
    for property in properties_of(net):
        with reading_formula(f"property {property.id}"):
            reading = read(property)
        one = Property(str(property.id), *reading.as_formula())
        try:
            if str(property.signals) != "none":
                raise DinerosError("the contest's nets have no signals")
            with reading_formula(f"property {property.id}"):
                writing.add_property(etree.Element("attempt"), one, subject.net, subject.names)
        except DinerosError as error:
            warn(f"{model}: property {property.id} is left out: {error.message}")
        else:
            said.append(one)
    if not said:
        raise DinerosError(
            "the model stores no property that can be written",
            location=Location(model),
            hint="see --ltl, --ctl",
        )
    writing.write_properties(output, said, subject.net, subject.names)
    summarise(f"{output}: {len(said)} {'property' if len(said) == 1 else 'properties'}")
    return HOLDS


def take_in(net: pn.Net, file: str, model: Path) -> int:
    """Store the formulas of a property file of the contest in a system model; return how many.

    Raises
    ------
    DinerosError
        The net is no system model, the file cannot be read, or an id is used already.
    """
    from dineros.analysis.model.subject import base_subject
    from dineros.analysis.properties.property import GroupedNames
    from dineros.analysis.properties.reading import read_properties
    from dineros.metamodel import sym

    if not isinstance(net, sym.SystemModel):
        raise DinerosError("only a system model stores properties", location=Location(model))
    names = GroupedNames(base_subject(net).names)
    taken = {element.id for element in net.eAllContents() if hasattr(element, "id")}
    count = 0
    for one in read_properties(file, names):
        if one.formula is None:
            warn(f"{file}: {one.id} is left out: a model stores formulas only")
            continue
        if one.id in taken:
            raise DinerosError(f"the model has an element {one.id!r} already", location=Location(Path(file)))
        text = str(names.ungrouped(one.formula))
        net.properties.append(sym.Property(id=one.id, text=text, language=one.kind))
        taken.add(one.id)
        count += 1
    return count
