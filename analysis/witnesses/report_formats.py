"""Reports in the formats that continuous integration shows: SARIF 2.1.0 and JUnit XML."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any
from urllib.parse import quote

from lxml import etree

from dineros.analysis.model.times import left_out_times
from dineros.analysis.witnesses.code_lines import CodeLines
from dineros.analysis.witnesses.findings import Fault, Finding, Report, Suppressed
from dineros.analysis.witnesses.witness import Step, Witness
from dineros.metamodel import pn
from dineros.metamodel.elements import elements
from dineros.metamodel.errors import Location, printable
from dineros.metamodel.positions import code_of, location_of

SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"

_NOT_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")


def to_sarif(report: Report, model: pn.Net, path: Path, faults: Mapping[str, Fault]) -> dict[str, Any]:
    """Return a report as a SARIF log with one run (OASIS SARIF 2.1.0).

    Findings are results with the lines of the elements concerned, and with the steps of the witness as a code
    flow. A suppressed finding has `suppressions`; if there is a baseline, each result has a `baselineState`.
    An unknown answer is a notification of the run; proved answers are not in the log.

    Parameters
    ----------
    model : pn.Net
        The model, as it was read: its elements know their lines.
    faults : mapping of str to Fault
        The kinds of what can be found, by name.
    """
    places = _ElementLocations(model, path)
    accepted = [suppressed.finding for suppressed in report.suppressed]
    shown = [*report.findings, *report.known, *accepted]
    rules = list(dict.fromkeys(finding.rule for finding in shown))
    severities = {finding.rule: finding.severity for finding in reversed(shown)}
    return {
        "$schema": SCHEMA,
        "version": "2.1.0",
        "runs": [
            {
                "tool": {
                    "driver": {
                        "name": "DiNeROS",
                        "version": _version(),
                        "rules": [_rule(rule, severities[rule], faults) for rule in rules],
                    }
                },
                "invocations": [
                    {
                        "executionSuccessful": True,
                        "toolExecutionNotifications": [
                            {
                                "level": "warning" if unknown.may_be_fault else "note",
                                "message": {"text": printable(f"unknown: {unknown}")},
                            }
                            for unknown in report.unknown
                        ]
                        + _notes(report, model),
                    }
                ],
                "artifacts": [{"location": {"uri": _uri(path)}}],
                "columnKind": "unicodeCodePoints",
                "results": _results(report, rules, places),
            }
        ],
    }


def _notes(report: Report, model: pn.Net) -> list[dict[str, Any]]:
    """Return the notifications of what the proofs assume, and of the note of a report about times."""
    texts = [f"assumes: {each}" for each in report.assumes]
    if (times := report.text_of_times(left_out_times(model))) is not None:
        texts.append(times)
    return [{"level": "note", "message": {"text": text}} for text in texts]


def _rule(rule: str, severity: str, faults: Mapping[str, Fault]) -> dict[str, Any]:
    words = rule.replace("-", " ")
    return {
        "id": rule,
        "name": words.title().replace(" ", ""),
        "shortDescription": {"text": faults[rule].meaning if rule in faults else f"{words.capitalize()}."},
        "defaultConfiguration": {"level": severity},
    }


def _results(report: Report, rules: list[str], places: _ElementLocations) -> list[dict[str, Any]]:
    """Return what counts, what the baseline has, and what is suppressed."""
    new, known = ({"baselineState": each} if report.has_baseline else {} for each in ("new", "unchanged"))
    return [
        *({**_result(finding, rules, places), **new} for finding in report.findings),
        *({**_result(finding, rules, places), **known} for finding in report.known),
        *(
            {**_result(each.finding, rules, places), **known, "suppressions": [_suppression(each, places)]}
            for each in report.suppressed
        ),
    ]


def _suppression(suppressed: Suppressed, places: _ElementLocations) -> dict[str, Any]:
    return {
        "kind": "inSource",
        "status": "accepted",
        "justification": suppressed.why,
        "location": places.of(suppressed.element),
    }


def _result(finding: Finding, rules: list[str], places: _ElementLocations) -> dict[str, Any]:
    result: dict[str, Any] = {
        "ruleId": finding.rule,
        "ruleIndex": rules.index(finding.rule),
        "level": finding.severity,
        "message": {"text": printable(finding.message)},
        "locations": [places.of_finding(finding)],
        "partialFingerprints": {"dinerosFinding/v1": _fingerprint(finding)},
    }
    related = [places.of(id) for id in finding.elements[1:] if places.knows(id)]
    related += places.others(finding)
    related += [
        {
            **places.of_all(each.elements),
            "message": {"text": printable(f"consequence: {message} [{rule}]")},
        }
        for each, (message, rule) in zip(finding.consequences, finding.shown_consequences, strict=True)
    ]
    if related:
        result["relatedLocations"] = related
    properties: dict[str, Any] = {"question": finding.question} if finding.question else {}
    if finding.consequences:
        properties["consequences"] = [
            {
                "ruleId": each.rule,
                "level": each.severity,
                "elements": list(each.elements),
                **({"question": each.question} if each.question else {}),
                **({"together": _named(each.together)} if each.together else {}),
            }
            for each in finding.consequences
        ]
    if properties:  # a baseline that is read from SARIF knows them, too
        result["properties"] = properties
    if finding.witness is not None and finding.witness.steps:
        result["codeFlows"] = [{"threadFlows": [{"locations": _flow(finding.witness, places)}]}]
    return result


def _named(causes: Sequence[Finding]) -> list[dict[str, Any]]:
    return [{"ruleId": each.rule, "elements": list(each.elements)} for each in causes]


def _flow(witness: Witness, places: _ElementLocations) -> list[dict[str, Any]]:
    return [
        {
            "location": {
                **places.of(step.transition),
                "message": {"text": printable(_step_text(witness, number))},
            },
            "executionOrder": number + 1,
            "nestingLevel": int(_repeats(witness, number)),
            "importance": "essential" if number == len(witness.steps) - 1 else "important",
            "state": {place: {"text": f"{tokens:+}"} for place, tokens in step.change.items()},
        }
        for number, step in enumerate(witness.steps)
    ]


def _fingerprint(finding: Finding) -> str:
    """Return what identifies a finding, also after lines move or its message is reworded."""
    parts = [finding.rule, *finding.elements, *([finding.question] if finding.question else [])]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


class _ElementLocations:
    """Where the elements of a model stand, as SARIF locations."""

    def __init__(self, model: pn.Net, path: Path) -> None:
        self._path = path
        self._by_id = {element.id: element for element in elements(model) if element.id}
        self._code = CodeLines(model)

    def knows(self, id: str) -> bool:
        return id in self._by_id

    def of_all(self, ids: tuple[str, ...]) -> dict[str, Any]:
        """Return the line of the first element that has one, and the names of all."""
        location = self.of(next((id for id in ids if self.knows(id)), ""))
        location["logicalLocations"] = [self._name(id) for id in ids]
        if not ids:
            del location["logicalLocations"]
        return location

    def of_finding(self, finding: Finding) -> dict[str, Any]:
        """Return the line of a finding: in source code, if its elements stand for lines of it."""
        location = self.of_all(finding.elements)
        return (
            location | self._physical(line)
            if (line := next(iter(self._code.of(finding)), None))
            else location
        )

    def others(self, finding: Finding) -> list[dict[str, Any]]:
        """Return further lines of source code that a finding is about."""
        return [self._physical(line) for line in self._code.of(finding)[1:]]

    def of(self, id: str) -> dict[str, Any]:
        """Return the line of an element; just the file for what the model does not hold."""
        element = self._by_id.get(id)
        location = self._physical(code_of(element) or location_of(element) or Location())
        if id:
            location["logicalLocations"] = [self._name(id)]
        return location

    def _physical(self, known: Location) -> dict[str, Any]:
        physical: dict[str, Any] = {"artifactLocation": {"uri": _uri(Path(known.file or self._path))}}
        if known.line is not None:
            region = {"startLine": known.line}
            physical["region"] = region if known.column is None else {**region, "startColumn": known.column}
        return {"physicalLocation": physical}

    def _name(self, id: str) -> dict[str, str]:
        element = self._by_id.get(id)
        if element is None:
            return {"name": id}
        return {"name": element.name or id, "fullyQualifiedName": id, "kind": type(element).__name__}


def to_junit(report: Report, model: pn.Net, path: Path, name: str = "dineros check") -> bytes:
    """Return a report as JUnit XML: what is found fails, what is proved passes, what is unknown is skipped.

    A note passes, with its message as output: as for the exit status of `dineros check`. Findings that are
    suppressed or in the baseline are skipped, too, with the reason. The property ``times`` of the suite says
    that firing intervals are taken into account, or left out, and which answers hold all the same. Each
    property ``assumes`` is an assumption of all proofs.
    """
    failing = [finding for finding in report.findings if finding.severity != "note"]
    accepted = [(each.finding, f"suppressed: {each.why}") for each in report.suppressed]
    accepted += [(finding, "known: it is in the baseline") for finding in report.known]
    answers = [*report.proved, *report.assumed, *report.unknown]
    cases = len(report.findings) + len(answers) + len(accepted)
    counts = {
        "tests": str(cases),
        "failures": str(len(failing)),
        "errors": "0",
        "skipped": str(len(report.unknown) + len(accepted)),
    }
    root = etree.Element("testsuites", {"name": name, **counts})
    suite = etree.SubElement(root, "testsuite", {"name": _clean(str(path)), **counts})

    stated = [("assumes", each) for each in report.assumes]
    if (times := report.text_of_times(left_out_times(model))) is not None:
        stated.append(("times", times))
    if stated:
        properties = etree.SubElement(suite, "properties")
        for key, text in stated:
            etree.SubElement(properties, "property", {"name": key, "value": _clean(text)})

    code = CodeLines(model)

    def case(name: str, kind: str, line: Location | None = None) -> etree._Element:
        file = path.as_posix() if line is None else str(line.file)
        attributes = {"classname": f"dineros.{kind}", "name": _shown(name), "file": _clean(file)}
        if line is not None and line.line is not None:
            attributes["line"] = str(line.line)
        return etree.SubElement(suite, "testcase", attributes)

    for finding in report.findings:
        lines = code.of(finding)
        made = case(finding.message, finding.rule, next(iter(lines), None))
        if finding.severity == "note":
            etree.SubElement(made, "system-out").text = _shown(finding.message)
            continue
        failure = etree.SubElement(
            made, "failure", {"type": finding.severity, "message": _shown(finding.message)}
        )
        failure.text = _clean(_details(finding, lines))
    for finding, why in accepted:
        made = case(finding.message, finding.rule)
        etree.SubElement(made, "skipped", {"message": _shown(why)})
    for proved in report.proved:
        case(proved, "proved")
    for assumed in report.assumed:
        case(assumed, "assumed")
    for unknown in report.unknown:
        made = case(unknown.question, "unknown")
        etree.SubElement(made, "skipped", {"message": _shown(str(unknown))})
    written: bytes = etree.tostring(root, xml_declaration=True, encoding="utf-8", pretty_print=True)
    return written


def _details(finding: Finding, code: list[Location]) -> str:
    lines = [finding.message, f"elements: {', '.join(finding.elements)}"]
    lines += [f"at {', '.join(map(str, code))}"] if code else []
    lines += [f"consequence: {message} [{rule}]" for message, rule in finding.shown_consequences]
    if finding.witness is not None:
        steps = finding.witness.steps
        lines += [f"{n + 1}. {_step_text(finding.witness, n)}{_change(step)}" for n, step in enumerate(steps)]
    return "\n".join(map(printable, lines))


def _change(step: Step) -> str:
    change = ", ".join(f"{place} {tokens:+}" for place, tokens in step.change.items())
    return f" ({change})" if change else ""


def _step_text(witness: Witness, number: int) -> str:
    text = witness.steps[number].shown
    return f"forever: {text}" if _repeats(witness, number) else text


def _repeats(witness: Witness, number: int) -> bool:
    return witness.loop is not None and number >= witness.loop


def _shown(text: str) -> str:
    """Return a text as one line: what it quotes of a file begins no line of its own."""
    return _clean(printable(text))


def _clean(text: str) -> str:
    """Return a text without the characters that XML cannot carry."""
    return _NOT_XML.sub("\ufffd", text)


def _uri(path: Path) -> str:
    """Return a relative reference for a relative path, so that CI finds the file in its checkout."""
    return path.as_uri() if path.is_absolute() else quote(path.as_posix())


def _version() -> str:
    try:
        return version("dineros")
    except PackageNotFoundError:
        return "0"
