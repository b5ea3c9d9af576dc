"""Faults in how the parts of a rule fit together are found when its module is imported."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.rule_faults import HEADER, RULE, Faults, check, import_rules

FAULTS: Faults = {
    "new element that is on no side": (
        RULE.format("watch = place('watch')  #!"),
        "Watchdog: watch is not on the right-hand side",
        "",
    ),
    "group that is on no side": (
        RULE.format("queue = OverflowQueue('q', source=source, limit=port.limit)  #!"),
        "Watchdog: queue.load is not on the right-hand side",
        "",
    ),
    "pattern node on the right-hand side only": (
        RULE.format("joint = Node(pn.Arc)  #!").replace("[*lhs]", "[*lhs, joint]"),
        "Watchdog: joint is not on the left-hand side",
        "",
    ),
    "new element on the left-hand side": (
        RULE.format("watch = place('watch')  #!").replace("source]", "source, watch]"),
        "Watchdog.lhs cannot hold watch",
        "it holds Node, Made, Index",
    ),
    "pattern node that depends on what is not matched": (
        RULE.format("")
        .replace("channel, port, source]", "port, source]")
        .replace("channel=channel)", "channel=channel)  #!"),
        "Watchdog: port uses channel, which is not matched or created before it",
        "list it in lhs",
    ),
    "lookup by what is not matched": (
        RULE.format("topic = Made(T1.topic, of=channel)  #!").replace("[channel, port, source]", "[topic]"),
        "Watchdog: topic uses channel, which is not matched",
        "",
    ),
    "number up to what is not matched": (
        RULE.format("step = Index(upto=port.limit)  #!").replace("[channel, port, source]", "[step]"),
        "Watchdog: step uses port, which is not matched",
        "",
    ),
    "condition about what is not matched": (
        RULE.format("joint = Node(pn.Arc)\n    where = [joint.weight > 1]  #!"),
        "joint.weight > 1 uses joint, which is not matched",
        "",
    ),
    "new element used before it is made": (
        RULE.format("watch = transition('watch')\n    joint = arc(source, watch)  #!").replace(
            "[*lhs]", "[*lhs, joint, watch]"
        ),
        "Watchdog: joint uses watch, which is not matched or created before it",
        "earlier in rhs",
    ),
    "truth value of a comparison": (
        RULE.format("big = 3 if port.limit == 3 else 4  #!"),
        "an expression has no truth value while the rule is written",
        "use where=[...]",
    ),
    "truth value by and": (
        RULE.format("where = [port.limit > 3 and port.limit < 8]  #!"),
        "an expression has no truth value",
        "use where=[...]",
    ),
    "truth value by not": (RULE.format("where = [not port.limit]  #!"), "has no truth value", "~ for not"),
    "condition of a for-all about what is not matched": (
        RULE.format(
            "joint = Node(pn.Arc, source=source)\n"
            "    other = Node(pn.Arc)\n"
            "    every = ForAll([joint], make=[place('w')], where=[other.weight > 1])  #!"
        ).replace("[*lhs]", "[*lhs, every]"),
        "other.weight > 1 uses other, which is not matched",
        "",
    ),
    "for-all over what depends on something not matched": (
        RULE.format(
            "other = Node(pn.Place)\n"
            "    joint = Node(pn.Arc, source=other)  #!\n"
            "    every = ForAll([joint], make=[place('w')])"
        ).replace("[*lhs]", "[*lhs, every]"),
        "Watchdog: joint uses other, which is not matched",
        "",
    ),
    "element of a for-all used outside of it": (
        RULE.format(
            "joint = Node(pn.Arc, source=source)\n"
            "    watch = transition('w')\n"
            "    every = ForAll([joint], make=[watch])\n"
            "    late = arc(source, watch)  #!"
        ).replace("[*lhs]", "[*lhs, every, late]"),
        "Watchdog: late uses watch, which is not matched",
        "",
    ),
    "inner for-all over what depends on something not matched": (
        RULE.format(
            "joint = Node(pn.Arc, source=source)\n"
            "    other = Node(pn.Place)\n"
            "    inner = Node(pn.Arc, source=other)  #!\n"
            "    every = ForAll([joint], make=[ForAll([inner], make=[place('w')])])"
        ).replace("[*lhs]", "[*lhs, every]"),
        "Watchdog: inner uses other, which is not matched",
        "",
    ),
    "misspelt feature in a for-all": (
        RULE.format(
            "joint = Node(pn.Arc, source=source)\n"
            "    every = ForAll([joint], make=[place('w', joint.wight)])  #!"
        ),
        "Arc has no feature 'wight'",
        "did you mean 'weight'?",
    ),
    "forbidden pattern about what is not matched": (
        RULE.format(
            "other = Node(pn.Place)\n    joint = Node(pn.Arc, source=other)  #!\n    absent = [Absent(joint)]"
        ),
        "Watchdog: joint uses other, which is not matched",
        "",
    ),
    "condition of a forbidden pattern about what is not matched": (
        RULE.format(
            "other = Node(pn.Place)\n"
            "    joint = Node(pn.Arc, source=source)\n"
            "    absent = [Absent(joint, where=[other.tokens > 1])]  #!"
        ),
        "other.tokens > 1 uses other, which is not matched",
        "",
    ),
    "misspelt feature in a forbidden pattern": (
        RULE.format("absent = [Absent(Node(pn.Arc, sorce=source))]  #!"),
        "Arc has no feature 'sorce'",
        "did you mean 'source'?",
    ),
    "group that lacks a role": (
        "class Half(Fragment):\n"
        "    roles = {'one': pn.Place, 'two': pn.Place}\n"
        "    def __init__(self):\n"
        "        super().__init__()  #!\n"
        "        self.one = place('one')\n" + RULE.format("half = Half()").replace("[*lhs]", "[*lhs, *half]"),
        "Half does not create two",
        "",
    ),
    "group without its star": (
        RULE.format("queue = OverflowQueue('q', source=source, limit=port.limit)  #!").replace(
            "[*lhs]", "[*lhs, queue]"
        ),
        "Watchdog.rhs cannot hold queue",
        "write * in front of it",
    ),
    "list without its star": (
        RULE.format("watch = transition('w')\n    arcs = [arc(source, watch)]")
        .replace("(Rule):", "(Rule):  #!")
        .replace("[*lhs]", "[*lhs, watch, arcs]"),
        "Watchdog.rhs cannot hold arcs",
        "write * in front of it",
    ),
    "condition without brackets": (
        RULE.format("where = port.limit > 3").replace("(Rule):", "(Rule):  #!"),
        "Watchdog.where is not a list",
        "put it into a list [ ]",
    ),
    "condition that is decided already": (
        RULE.format("where = [port.place is None]").replace("(Rule):", "(Rule):  #!"),
        "Watchdog.where cannot hold a bool",
        "it holds Expression",
    ),
    "element of another rule used without a lookup": (
        RULE.format("topic = T1.topic").replace("(Rule):", "(Rule):  #!").replace("[*lhs]", "[*lhs, topic]"),
        "Watchdog.topic belongs to T1",
        "look it up: Made(T1.topic, of=...)",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_reported_with_its_line(fault: str, tmp_path: Path) -> None:
    check(FAULTS[fault], tmp_path / "my_rules.py")


def test_the_rule_around_the_faults_is_right(tmp_path: Path) -> None:
    path = tmp_path / "my_rules.py"
    path.write_text(HEADER + RULE.format(""), encoding="utf-8")

    assert import_rules(path).Watchdog.lhs
