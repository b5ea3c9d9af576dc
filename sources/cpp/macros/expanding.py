"""Expands the macros of a folder in its files, so that what they stand for is read at the place of use.

The rules are those of the C++ standard (section 15.6, "Macro replacement"). Of several definitions under
conditions of the preprocessor, all are used if they are texts. Else one is used: a macro after ``#ifdef``
counts as not defined; of other conditions, the first branch is used.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

from dineros.sources.cpp.macros.directives import DIRECTIVE, LITERAL, Directive, Macro, directives
from dineros.sources.cpp.tables.headers import Headers

MOST_CHARACTERS = 50_000
"""Limit of the text that one use of a macro makes, with all steps between."""
_MOST_WORK = 5_000_000
"""Limit of the text that all uses in a folder make."""
_MOST_NESTED = 40
"""Limit of macros in the text of macros."""
_LIBRARIES = ("RCLCPP_", "RCUTILS_", "RCL_", "PLUGINLIB_", "CLASS_LOADER_", "BT_REGISTER_")
"""Beginnings of macros with a meaning of their own for this reader."""
_PORTS = re.compile(
    r"\b(?:create_\w+|publish|async_\w+|spin\w*|wait\w*|sleep\w*|\w*lock\w*|get|join|notify_\w+)\s*[<(]|->"
)
_CALL = re.compile(r"\w\s*\(")
_WORD = re.compile(r"[A-Za-z_]\w*")
_TOKEN = re.compile(
    f"(?P<literal>{LITERAL})|(?P<directive>{DIRECTIVE})|(?P<word>[A-Za-z_]\\w*)", re.DOTALL | re.MULTILINE
)
_ARGUMENT = re.compile(
    f"(?P<literal>{LITERAL})|(?P<directive>{DIRECTIVE})|(?P<sign>[(),])", re.DOTALL | re.MULTILINE
)
_BODY = re.compile(
    rf"(?P<literal>{LITERAL})|(?P<word>[A-Za-z_]\w*)|\s*(?P<paste>\#\#)\s*|(?P<text>\#)\s*(?=\w)|\s+|.",
    re.DOTALL,
)
_TEXT = re.compile(r'"(?:[^"\\\n]|\\.)*"')
"""One text."""
_MOST_BLANKS = 200
"""Limit of the characters after a macro in which the next token is searched."""
_OPTION = re.compile(r"__VA_OPT__\s*\(([^()]*)\)")

Table = dict[str, Macro | None]
"""Macros by name; None after ``#undef``."""


class NotExpandedError(Exception):
    """A use of a macro cannot be expanded; the text is the reason."""


class Macros:
    """The macros of a folder.

    `texts`: the texts of all files in C++, by path.
    """

    def __init__(self, texts: Mapping[str, str]) -> None:
        self._headers = Headers()
        self._directives: dict[str, list[Directive]] = {}
        self._tables: dict[str, Table] = {}
        self._capitals: dict[str, Macro | None] = {}
        self._work = 0
        self.unread: list[str] = []
        """Uses that are not expanded, or whose meaning is assumed, a line each."""
        for path, text in texts.items():
            self._headers.add(path)
            self._directives[path] = list(directives(path, text)) if "#" in text else []
            for macro in (each.macro for each in self._directives[path] if each.macro is not None):
                if macro.parameters is not None and macro.name.isupper():
                    other = self._capitals.setdefault(macro.name, macro)
                    if other is None or (other.parameters, other.body) != (macro.parameters, macro.body):
                        self._capitals[macro.name] = None  # its meaning depends on the included headers

    def expanded(self, path: str, text: str) -> str:
        """Return the text of a file with its macros expanded; each line keeps its number."""
        final = self._table(path)
        names = {name for name, macro in self._capitals.items() if macro is not None} | set(final)
        if not names.intersection(_WORD.findall(text)):
            return text
        own = {each.name for each in self._directives[path] if each.macro is not None}
        others: Table = {name: each for name, each in self._capitals.items() if each and name not in own}
        table: Table = dict(others)
        waiting = iter(self._directives[path])
        step = next(waiting, None)
        parts: list[str] = []
        failed, said = set[str](), set[str]()
        done = 0
        for found in _TOKEN.finditer(text):
            if found["directive"] is not None:
                while step is not None and step.start <= found.start():
                    self._apply(table, step, path)
                    step = next(waiting, None)
            word = found["word"]
            if word is None or found.start() < done or word in failed:
                continue
            macro = _usable(table, word)
            if macro is None:
                continue
            try:
                end, result = self._use(macro, text, found.end(), table)
            except NotExpandedError as error:
                failed.add(word)
                if _CALL.search(macro.body):
                    self._say(path, text, found.start(), f"the macro {word} is not expanded ({error})")
                continue
            if end == found.start():
                continue
            texts = _alternatives(macro, text[done : found.start()], text[end : end + _MOST_BLANKS])
            result = texts or result
            is_assumed = macro.is_one_of_several and not texts and word not in said
            if is_assumed and (result.startswith('"') or self._uses_ports(macro, table)):
                said.add(word)
                what = f"the macro {word} has several meanings under conditions of the preprocessor"
                at = f"{path}:{_line(text, found.start())}"
                self.unread.append(f"{at}: {what}; that of {macro.path}:{macro.line} is assumed")
            lines = text.count("\n", found.start(), end)
            if result.count("\n") > lines:
                result = result.replace("\n", " ")
            parts += [text[done : found.start()], result, "\n" * (lines - result.count("\n"))]
            done = end
        return "".join([*parts, text[done:]])

    def are_lost(self, path: str, text: str) -> None:
        """Report that the macros of a file are not expanded, as the result cannot be parsed."""
        table = self._table(path)
        for found in _TOKEN.finditer(text):
            macro = _usable(table, found["word"])
            if macro is not None and self._uses_ports(macro, table):
                why = f"the macro {macro.name} is not expanded (the result cannot be parsed)"
                self._say(path, text, found.start(), why)
                table = table | {macro.name: None}

    def _say(self, path: str, text: str, at: int, what: str) -> None:
        self.unread.append(f"{path}:{_line(text, at)}: {what}, so what it does is unknown")

    # ----------------------------------------------------------------------------------------- definitions

    def _table(self, path: str) -> Table:
        """Return the macros after a file, with those of the headers that it includes."""
        if path not in self._tables:
            self._tables[path] = {}  # a header that includes itself adds nothing
            table: Table = {}
            for each in self._directives[path]:
                self._apply(table, each, path)
            self._tables[path] = table
        return self._tables[path]

    def _apply(self, table: Table, step: Directive, path: str) -> None:
        if step.kind == "include":
            header = self._headers.named(step.name, path)
            if header is not None:
                inner = self._table(header)
                self._work += len(inner)
                if self._work < _MOST_WORK:
                    table.update(inner)
        elif step.macro is None:
            table[step.name] = None
        else:
            before = table.get(step.name)
            if before is None or not _are_alternatives(before, step.macro):
                table[step.name] = step.macro
            elif (before.parameters, before.body) != (step.macro.parameters, step.macro.body):
                kept = step.macro if step.is_later_kept else before
                bodies = dict.fromkeys([*(before.bodies or (before.body,)), step.macro.body])
                table[step.name] = replace(kept, is_one_of_several=True, bodies=tuple(bodies))

    def _uses_ports(self, macro: Macro, table: Table) -> bool:
        """Return whether a definition of a macro, or of one that it uses, has calls of ports."""
        todo, seen = [macro.name], {macro.name}
        while todo:
            name = todo.pop()
            bodies = {
                each.macro.body for each in self._directives[macro.path] if each.macro and each.name == name
            }
            known = table.get(name)
            for body in bodies | ({known.body} if known is not None else set()):
                if _PORTS.search(body):
                    return True
                more = {each for each in _WORD.findall(body) if each in table} - seen
                seen |= more
                todo += more
        return False

    # ------------------------------------------------------------------------------------------- expansion

    def _use(self, macro: Macro, text: str, at: int, table: Table) -> tuple[int, str]:
        """Return where a use of a macro ends, and what it stands for."""
        self._left = MOST_CHARACTERS
        args: list[str] | None = None
        if macro.parameters is not None:
            end, args = _arguments(text, at)
            if args is None:
                return at - len(macro.name), ""  # only its name
            return end, self._replaced(macro, args, table, frozenset(), 0)
        result = self._replaced(macro, [], table, frozenset(), 0)
        inner = _usable(table, result.strip())
        if inner is not None and inner.parameters is not None:  # it stands for another macro with arguments
            end, args = _arguments(text, at)
            if args is not None:
                return end, self._replaced(inner, args, table, frozenset((macro.name,)), 0)
        return at, result

    def _replaced(
        self, macro: Macro, args: list[str], table: Table, hidden: frozenset[str], depth: int
    ) -> str:
        """Return the text of a macro with arguments, and the macros in it expanded."""
        names = macro.parameters
        given: dict[str, str] = {}
        if names is not None:
            variadic = bool(names) and (names[-1] == "__VA_ARGS__" or names[-1].endswith("..."))
            if variadic:
                count = len(names) - 1
                args = [*args[:count], ",".join(args[count:])] if len(args) >= count else args
            elif not names and len(args) == 1 and not args[0].strip():
                args = []
            if len(args) != len(names):
                raise NotExpandedError("the number of arguments is another one")
            given = {name.removesuffix("..."): each for name, each in zip(names, args, strict=True)}
        body = self._substituted(macro, given, table, hidden, depth)
        return self._rescanned(body, table, hidden | {macro.name}, depth + 1)

    def _substituted(
        self, macro: Macro, given: dict[str, str], table: Table, hidden: frozenset[str], depth: int
    ) -> str:
        rest = given.get("__VA_ARGS__", "").strip()
        body = _OPTION.sub(lambda found: found[1] if rest else "", macro.body)
        tokens = list(_BODY.finditer(body))
        expanded: dict[str, str] = {}
        parts: list[str] = []
        for number, token in enumerate(tokens):
            name = token["word"]
            is_pasted = (number > 0 and tokens[number - 1]["paste"]) or (
                number + 1 < len(tokens) and tokens[number + 1]["paste"]
            )
            if token["paste"]:
                following = tokens[number + 1]["word"] if number + 1 < len(tokens) else None
                if parts and parts[-1] == "," and following in given and not given[following].strip():
                    parts[-1] = ""
            elif token["text"] and macro.parameters is not None:
                pass
            elif name in given:
                if number > 0 and tokens[number - 1]["text"]:
                    words = " ".join(given[name].split()).replace("\\", "\\\\").replace('"', '\\"')
                    parts.append(f'"{words}"')
                elif is_pasted:
                    parts.append(given[name].strip())
                else:
                    if name not in expanded:
                        expanded[name] = self._rescanned(given[name], table, hidden, depth + 1)
                    parts.append(expanded[name])
            else:
                parts.append(token[0])
            self._spend(len(parts[-1]) if parts else 0)
        return "".join(parts)

    def _rescanned(self, text: str, table: Table, hidden: frozenset[str], depth: int) -> str:
        if depth > _MOST_NESTED:
            raise NotExpandedError("it is nested too deeply")
        parts: list[str] = []
        done = 0
        for found in _TOKEN.finditer(text):
            macro = _usable(table, found["word"])
            if macro is None or macro.name in hidden or found.start() < done:
                continue
            end, args = found.end(), list[str]()
            if macro.parameters is not None:
                end, asked = _arguments(text, found.end())
                if asked is None:
                    continue
                args = asked
            parts += [text[done : found.start()], self._replaced(macro, args, table, hidden, depth + 1)]
            done = end
        self._spend(len(text))
        return "".join([*parts, text[done:]])

    def _spend(self, characters: int) -> None:
        self._left -= characters
        self._work += characters
        if self._left < 0 or self._work > _MOST_WORK:
            raise NotExpandedError("its text is too large")


def _alternatives(macro: Macro, before: str, after: str) -> str:
    """Return an expression for a text that branches define differently; empty: it cannot stand there.

    A choice between them can follow no text, and no text can follow it.

    Examples
    --------
    >>> macro = Macro("NAME", None, '"a"', "robot.cpp", 1, bodies=('"a"', '"b"'))
    >>> _alternatives(macro, "f(", ")"), _alternatives(macro, 'f("/" ', ")")
    ('(DEFINED_NAME ? "a" : "b")', '')
    """
    is_text = macro.parameters is None and all(_TEXT.fullmatch(each) for each in macro.bodies)
    is_alone = not before.rstrip().endswith('"') and not after.lstrip().startswith('"') and after.strip()
    if len(macro.bodies) < 2 or not is_text or not is_alone or "#" in before.rpartition("\n")[2]:
        return ""
    *firsts, last = macro.bodies
    return "".join(f"(DEFINED_{macro.name} ? {each} : " for each in firsts) + last + ")" * len(firsts)


def _usable(table: Table, word: str | None) -> Macro | None:
    """Return the macro that a word means, if its text is to be read in its place."""
    macro = table.get(word) if word else None
    if macro is None or macro.name.startswith(_LIBRARIES):
        return None
    if macro.parameters is None and macro.body:
        plain = re.sub(LITERAL, " ", macro.body, flags=re.DOTALL)
        is_text = macro.is_one_of_several and macro.body.startswith('"')
        if not _WORD.search(plain) and not is_text:  # the value of a constant
            return None
    return macro


def _arguments(text: str, at: int) -> tuple[int, list[str] | None]:
    """Return where the arguments after a name end, and their texts; None: there are none."""
    while at < len(text) and text[at].isspace():
        at += 1
    if text[at : at + 1] != "(":
        return at, None
    depth, start, args = 0, at + 1, list[str]()
    for found in _ARGUMENT.finditer(text, at, at + MOST_CHARACTERS):
        if found["directive"] is not None:
            raise NotExpandedError("its arguments have directives")
        if found["sign"] == "(":
            depth += 1
        elif found["sign"] == ")":
            depth -= 1
            if depth == 0:
                args.append(_without_comments(text[start : found.start()]))
                return found.end(), args
        elif found["sign"] == "," and depth == 1:
            args.append(_without_comments(text[start : found.start()]))
            start = found.end()
    raise NotExpandedError("its arguments have no end")


def _without_comments(text: str) -> str:
    """Return an argument; one that spans lines keeps the ends of lines before it."""
    text = re.sub(LITERAL, _blank, text, flags=re.DOTALL)
    return text.strip(" \t") if "\n" in text.strip() else text.strip()


def _blank(found: re.Match[str]) -> str:
    return " " + "\n" * found[0].count("\n") if found[0].startswith(("//", "/*")) else found[0]


def _are_alternatives(one: Macro, other: Macro) -> bool:
    """Return whether two definitions are in different branches of a condition."""
    branches = dict(one.branches) if one.path == other.path else {}
    return any(branches.get(number, branch) != branch for number, branch in other.branches)


def _line(text: str, at: int) -> int:
    return text.count("\n", 0, at) + 1
