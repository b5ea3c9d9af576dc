"""The findings of an earlier check, so that a later one reports only what is new."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from dineros.analysis.witnesses.findings import SEVERITIES, Finding, Report
from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.files.reading import SIZE_LIMIT, read_bytes
from dineros.metamodel.json_text import decode_json

KIND = "dineros-baseline"
_HINT = "write one with 'dineros check MODEL --write-baseline FILE'"

Key = tuple[str, tuple[str, ...], str]


class BaselineError(DinerosError):
    """A file is not a baseline."""


class Baseline:
    """Findings that are known.

    A finding is known if the baseline has one with the same rule and the same elements that was at least as
    severe; one about a property, only if the property had the same text. Names of files, messages, witnesses
    and the order of findings and elements do not matter. If the baseline has a finding once, only one of
    several equal ones is known.

    `findings`: rule, severity, ids of the elements, and text of the property, of each finding.
    """

    def __init__(self, findings: Iterable[tuple[str, str, Iterable[str], str]]) -> None:
        self._severities: dict[Key, list[int]] = {}
        for rule, severity, elements, question in findings:
            self._severities.setdefault(_key(rule, elements, question), []).append(_rank(severity))

    @classmethod
    def read(cls, path: Path) -> Baseline:
        """Read a baseline, or the output of ``check --json`` or ``check --format sarif``.

        Suppressed findings are not part of a baseline: when the suppression ends, they are new.

        Raises
        ------
        DinerosError
            The file cannot be read, is not JSON, or has none of these forms.
        """
        content = decode_json(read_bytes(path, SIZE_LIMIT), location=Location(path), keys_once=True)
        try:
            return cls.of(content)
        except (KeyError, TypeError, AttributeError, IndexError) as error:
            raise BaselineError("is not a baseline", location=Location(path), hint=_HINT) from error

    @classmethod
    def of(cls, content: Any) -> Baseline:
        """Return the baseline with this content, as `read` takes it from a file."""
        return cls(list(_findings(content)))

    def apply(self, report: Report) -> Report:
        """Return a report in which known findings are set apart; the report given is not changed."""
        left = {key: sorted(ranks) for key, ranks in self._severities.items()}

        def is_known(finding: Finding) -> bool:
            for question in dict.fromkeys((finding.question, "")):  # older files have no texts
                ranks = left.get(_key(finding.rule, finding.elements, question), [])
                if ranks and ranks[-1] >= _rank(finding.severity):
                    ranks.pop()
                    return True
            return False

        new: dict[int, list[Finding]] = {}
        known = list(report.known)
        numbered = sorted(enumerate(report.findings), key=lambda each: -_rank(each[1].severity))
        for number, finding in numbered:
            if not is_known(finding):
                new[number] = [finding]
        for number, finding in numbered:
            those_new = [each for each in finding.consequences if not is_known(each)]
            if number not in new:
                those_known = tuple(each for each in finding.consequences if each not in those_new)
                known.append(replace(finding, consequences=those_known) if those_new else finding)
                new[number] = those_new
        counting = [finding for number in sorted(new) for finding in new[number]]
        made = report.with_accepted(counting, report.suppressed, known)
        made.gone = sum(rank > 0 for ranks in left.values() for rank in ranks)  # notes never counted
        made.has_baseline = True
        return made


def to_baseline(report: Report) -> dict[str, Any]:
    """Return the findings of a report, new and known, as the content of a baseline file."""
    told = [*report.findings, *report.known]
    told += [consequence for finding in told for consequence in finding.consequences]
    findings = sorted(told, key=lambda each: (each.rule, sorted(each.elements)))
    return {
        "kind": KIND,
        "version": 1,
        "findings": [
            {
                "rule": finding.rule,
                "severity": finding.severity,
                "elements": list(finding.elements),
                "message": finding.message,
                **({"question": finding.question} if finding.question else {}),
            }
            for finding in findings
        ],
    }


def _findings(content: Any) -> Iterator[tuple[str, str, list[str], str]]:
    if "runs" in content:
        for run in content["runs"]:
            for result in run["results"]:
                if result.get("baselineState") != "absent" and not result.get("suppressions"):
                    yield _of_sarif(result)
                    for each in result.get("properties", {}).get("consequences", ()):
                        names = [_text(name) for name in each["elements"]]
                        question = _text(each.get("question", ""))
                        yield _text(each["ruleId"]), _text(each["level"]), names, question
        return
    told = [*content["findings"], *content.get("known", ())]
    for entry in [*told, *(each for cause in told for each in cause.get("consequences", ()))]:
        names = [_text(each) for each in entry["elements"]]
        yield _text(entry["rule"]), _text(entry["severity"]), names, _text(entry.get("question", ""))


def _of_sarif(result: dict[str, Any]) -> tuple[str, str, list[str], str]:
    names = [
        _text(logical.get("fullyQualifiedName", logical["name"]))
        for location in result["locations"][:1]
        for logical in location.get("logicalLocations", ())
    ]
    question = _text(result.get("properties", {}).get("question", ""))
    return _text(result["ruleId"]), _text(result["level"]), names, question


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(value)
    return value


def _key(rule: str, elements: Iterable[str], question: str) -> Key:
    return rule, tuple(sorted(elements)), " ".join(question.split())


def _rank(severity: str) -> int:
    """Return how severe a finding is; raise `KeyError` for a severity that does not exist."""
    return SEVERITIES[severity]
