"""Interprets branches in C++: ``if``, ``switch``, ``try``."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from dineros.sources.branches import Anything, Attempt, Block, Branch, Condition, Leave
from dineros.sources.cpp.following.expressions import named
from dineros.sources.cpp.following.loops import Loops
from dineros.sources.cpp.following.ways import Way
from dineros.sources.cpp.parsing import text_of
from dineros.sources.cpp.values import Const, Frame, Open, Value

if TYPE_CHECKING:
    from tree_sitter import Node

_NAME = re.compile(r"[A-Z][A-Z0-9_]*|[A-Za-z_]\w*(::[A-Za-z_]\w*)+")
"""Of a constant: an enumerator is written so, a variable hardly ever."""
_FIXED = {"0": False, "false": False, "1": True, "true": True}
"""Conditions of the preprocessor with one value."""


class Choices(Loops):
    """Runs branches."""

    def _do_if_statement(self, node: Node, frame: Frame) -> None:
        clause = node.child_by_field_name("condition")
        asked: Value = Open("a condition")
        condition: Condition = Anything()
        for each in named(clause):
            if each.type in ("init_statement", "declaration"):
                self.run_block(each, frame)
                asked, condition = Open("a condition"), Anything()
            else:
                asked = self.tested(self.value(each, frame), each)
                condition = self.condition(each, frame)
        yes, no = node.child_by_field_name("consequence"), node.child_by_field_name("alternative")
        known = bool(asked.value) if isinstance(asked, Const) else None
        if known is not None and any(each.type == "constexpr" for each in node.children):
            self.run_block(yes if known else no, frame)  # the other branch is not compiled
            return
        ways: list[Way] = []
        done: list[Block] = []
        run = self.steps
        for side, (branch, is_taken) in enumerate(((yes, known), (no, None if known is None else not known))):
            self.branching.append((run, side))
            with self.way(ways, is_off=is_taken is False):
                self.run_block(branch, frame)
            self.branching.pop()
            done.append(self.taken)
        self.merge(ways, has_rest=False)
        self.block.append(Branch(condition, *done))

    def directive(self, node: Node, frame: Frame) -> None:
        """Run the branches of a condition of the preprocessor: it may hold or not; it opens no scope."""
        name = node.child_by_field_name("name") or node.child_by_field_name("condition")
        other = node.child_by_field_name("alternative")
        first = [each for each in named(node) if each not in (name, other)]
        rest = [] if other is None else named(other) if other.type == "preproc_else" else [other]
        taken = _FIXED.get(text_of(name).strip())
        ways: list[Way] = []
        done: list[Block] = []
        run, before, held = self.steps, list(self.holding), list(self.holding)
        for side, branch in enumerate((first, rest)):
            self.branching.append((run, side))
            self.holding[:] = before
            with self.way(ways, is_off=taken is not None and taken is not (side == 0)):
                for each in branch:
                    self.run_block(each, frame)
            self.branching.pop()
            done.append(self.taken)
            held += [each for each in self.holding[len(before) :] if each not in held]
        self.holding[:] = held
        self.merge(ways, has_rest=False)
        self.block.append(Branch(Anything(), *done))

    def _do_switch_statement(self, node: Node, frame: Frame) -> None:
        asked = next(reversed(self.values(node.child_by_field_name("condition"), frame)), Open("a condition"))
        cases = named(node.child_by_field_name("body"))
        taken = self._case_of(asked, cases, frame)
        is_sure = taken is not None and isinstance(asked, Open)
        is_taken = False
        outer, blocks = self.block, dict[int, Block]()
        for at, each in enumerate(cases):
            is_taken = is_taken or at == taken
            self.block = blocks[at] = []
            if is_taken:
                self.run_block(each, frame)
                is_taken = not _ends(each)
            elif not is_sure:
                with self.perhaps(is_off=taken is not None):
                    self.run_block(each, frame)
                blocks[at] = self.taken
        self.block = outer
        self.block += self.chosen(node, cases, blocks, frame)

    def _case_of(self, asked: Value, cases: list[Node], frame: Frame) -> int | None:
        """Return which case a node takes when it begins; None: it is not known, or may change."""
        if self.role not in ("main", "constructor") or frame.has_left:
            return None
        return next((at for at, each in enumerate(cases) if self._is_case(each, asked, frame)), None)

    def _is_case(self, case: Node, asked: Value, frame: Frame) -> bool:
        """Return whether a case is surely that of a value; a constant that is not known has its name."""
        label = case.child_by_field_name("value")
        if label is None or case.type != "case_statement":
            return False
        if isinstance(asked, Const):
            return asked.value is not None and self.value(label, frame) == asked
        is_name = isinstance(asked, Open) and not asked.parts and _NAME.fullmatch(asked.text) is not None
        return is_name and self.value(label, frame) == asked

    def _do_try_statement(self, node: Node, frame: Frame) -> None:
        outer, self.block = self.block, []
        self.run_block(node.child_by_field_name("body"), frame)
        tried, handlers = self.block, list[Block]()
        self.block = []
        is_thrown = _throws(tried)
        is_done, frame.is_done = frame.is_done, False  # what throws in it does not leave the function
        for each in named(node):
            if each.type == "catch_clause":
                with self.perhaps():
                    self.run_block(each.child_by_field_name("body"), frame)
                handlers.append(self.taken)
        frame.is_done = is_done and not is_thrown
        self.block = outer
        self.block.append(Attempt(tried, [], handlers))


def _throws(block: Block) -> bool:
    """Return whether a block ends with a statement that throws, at once or in a block within it."""
    return bool(block) and isinstance(block[-1], Leave) and block[-1].way == "raises"


def _ends(case: Node) -> bool:
    """Return whether what follows a case is not run after it."""
    last = next((each for each in reversed(named(case)) if each.type != "comment"), None)
    if last is not None and last.type == "compound_statement":
        return _ends(last)
    leaves = ("break_statement", "return_statement", "throw_statement", "continue_statement")
    return last is not None and last.type in leaves
