"""``dineros rules``: the rules of the flattening, listed, described and drawn."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from dineros.cli.console import say, say_json, say_lines, summarise
from dineros.cli.options import ANY_PATH, command, json_option, output_option, rules_option

if TYPE_CHECKING:
    from dineros.transformations.language.rule import Rule
    from dineros.transformations.rules.catalogue import Family


@command("dineros rules", "dineros rules T2", "dineros rules T2 -o t2.svg")
@click.argument("rule", metavar="[RULE]", required=False)
@output_option("Draw the rule: .svg, .png or .dot.", type=ANY_PATH)
@rules_option("List the rules of this Python file as well.")
@json_option
def rules(rule: str | None, output: Path | None, rule_file: Path | None, as_json: bool) -> int:
    """List the rules, describe one, or draw it.

    A rule has a left-hand side (LHS), which it matches, and a right-hand side (RHS), which replaces it.
    `dineros flatten` applies the rules.
    """
    from dineros.transformations.rules.catalogue import FAMILIES, find_rule, name_of

    families = (*FAMILIES, *_own(rule_file))
    if rule is None:
        if output is not None:
            raise click.MissingParameter("name the rule to draw", param_hint="'RULE'", param_type="argument")
        _list(families, as_json)
        return 0
    found = find_rule(rule, families)
    if output is not None:
        from dineros.transformations.pictures.drawing import draw_rule

        draw_rule(found, output)
        summarise(f"{name_of(found)} -> {output}")
    elif as_json:
        say_json(_as_json(found))
    else:
        _describe(found)
    return 0


def _own(path: Path | None) -> list[Family]:
    if path is None:
        return []
    from dineros.cli.rule_files import load_rules
    from dineros.transformations.rules.catalogue import OwnRules

    return [OwnRules("own", f"Rules of {path}", str(path), loaded=tuple(load_rules(path)))]


def _list(families: tuple[Family, ...], as_json: bool) -> None:
    from dineros.transformations.rules.catalogue import name_of, summary_of

    if as_json:
        say_json(
            {
                "rules": [
                    {"family": family.name, **_brief(rule)} for family in families for rule in family.rules
                ]
            }
        )
        return
    width = max(len(name_of(rule)) for family in families for rule in family.rules)
    for number, family in enumerate(families):
        if number:
            say("")
        say(family.title, "bold")
        for rule in family.rules:
            say(f"  {name_of(rule):{width}}  {summary_of(rule)}")


def _brief(rule: type[Rule]) -> dict[str, str]:
    from dineros.transformations.rules.catalogue import name_of, summary_of

    return {"name": name_of(rule), "says": summary_of(rule)}


def _as_json(rule: type[Rule]) -> dict[str, object]:
    from dineros.transformations.pictures.describing import lhs_rows, rhs_rows

    sides = {"lhs": lhs_rows(rule), "rhs": rhs_rows(rule)}
    return {
        **_brief(rule),
        **{side: [{"name": name.strip(), "is": text} for name, text in rows] for side, rows in sides.items()},
    }


def _describe(rule: type[Rule]) -> None:
    from dineros.transformations.pictures.describing import documentation_of, rule_text
    from dineros.transformations.rules.catalogue import name_of

    say_lines(f"{name_of(rule)}: {documentation_of(rule)}\n\n{rule_text(rule)}")
