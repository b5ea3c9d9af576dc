"""Decides from the text of a function in C++ where it has a response from, and how a service makes one.

A response is certain only if it has one name in one function, which does nothing with it but ask and assign
its fields. Everything else is left open.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from dineros.sources.cpp.declarators import function_of, name_of, parameters_of
from dineros.sources.cpp.parsing import line_of, nodes_in, path_of, text_of

if TYPE_CHECKING:
    from tree_sitter import Node

_OF_FUTURE = ("get", "valid", "wait", "wait_for")
"""Methods that leave a shared future as it is."""
_READS = {
    *("parenthesized_expression", "condition_clause", "unary_expression", "binary_expression"),
    *("if_statement", "while_statement", "conditional_expression", "case_statement", "switch_statement"),
}
"""Around a field, in which it keeps its value."""
_ASKS = "async_send_request"


class FunctionText:
    """The text of a function.

    `function`: the definition of a function, or a lambda.
    """

    def __init__(self, function: Node) -> None:
        self.function = function
        self.body = function.child_by_field_name("body")
        self._all = list(nodes_in(function))
        self._has_response = ".get()" in text_of(function)
        self.is_plain = self.body is not None and not function.has_error
        self.is_plain &= not any(each.type in ("goto_statement", "ERROR") for each in self._all)

    def parameters(self) -> list[tuple[str, str]]:
        """Return the parameters, with the texts of their types."""
        declarator = self.function.child_by_field_name("declarator")
        found = function_of(declarator) or declarator
        return [] if found is None else [(each.name, text_of(each.type)) for each in parameters_of(found)]

    def asked_future(self, asked: Node) -> str | None:
        """Return the variable that is the future whose response has a field that an expression asks.

        `asked`: ``future.get()->success``, or ``response->success`` of a variable that has the response.
        """
        if not self._has_response:
            return None
        field, holder = _field(asked), asked.child_by_field_name("argument")
        if not self.is_plain or field is None or holder is None or not self._is_kept(field):
            return None
        if holder.type == "identifier":
            if self._is_inner(holder):
                return None
            holder = self._made(text_of(holder))
        future = None if holder is None else _got(holder)
        if future is None or not self._is_future(future):
            return None
        return future

    def asked_message(self, asked: Node) -> bool:
        """Return whether an expression reads a field of the message that a subscription's callback gets.

        The function only reads fields of it: ``msg->data``, or ``msg.data`` of a reference.
        """
        parameters = self.parameters()
        holder, field = asked.child_by_field_name("argument"), _field(asked)
        is_alone = len(parameters) == 1 or (len(parameters) == 2 and "MessageInfo" in parameters[1][1])
        if not self.is_plain or not is_alone or holder is None or field is None:
            return False
        name = parameters[0][0]
        if not name or text_of(holder) != name or self._declared(name) != 1 or not self._is_kept(field):
            return False
        return all(
            not self._is_inner(each) and each.parent is not None and _field(each.parent) is not None
            for each in self._uses(name)
        )

    def sent(self, call: Node) -> dict[str, Node]:
        """Return the fields of a published message that statements of one block declare, assign and publish.

        `call`: ``publish(msg)``, ``publish(*msg)`` or ``publish(std::move(msg))``.
        """
        statement, given = call.parent, call.child_by_field_name("arguments")
        name = None if given is None else _published(given)
        if not self.is_plain or name is None or statement is None or self._declared(name) != 1:
            return {}
        block = statement.parent
        found: dict[str, Node] = {}
        changed: set[str] = set()
        is_declared = False
        for each in self._uses(name):
            parent = each.parent
            around = None if parent is None else parent.parent
            if given is not None and given.start_byte <= each.start_byte < given.end_byte:
                continue
            if parent is None or around is None or self._is_inner(each) is not self._is_inner(call):
                return {}
            if parent.type in ("init_declarator", "declaration") and _is_declared_by(each, parent):
                declaration = around if parent.type == "init_declarator" else parent
                is_declared = declaration.parent == block and declaration.start_byte < call.start_byte
                continue
            field = _field(parent)
            if field is None or parent.child_by_field_name("argument") != each:
                return {}
            if _is_left(parent, around):
                is_before = around.parent is not None and around.parent.parent == block
                if not is_before or around.start_byte > call.start_byte or field in found:
                    changed.add(field)
                value = around.child_by_field_name("right")
                if value is not None:
                    found[field] = value
            elif not _is_read(parent):
                changed.add(field)
        return {field: value for field, value in found.items() if is_declared and field not in changed}

    def asks(self, line: int) -> bool:
        """Return whether a line has one request only."""
        found = [each for each in self._all if each.type == "call_expression" and line_of(each) == line]
        names = [path_of(each.child_by_field_name("function")).rpartition(".")[2] for each in found]
        return sum(name.rpartition("->")[2].startswith(_ASKS) for name in names) == 1

    def response(self) -> str | None:
        """Return the parameter that is the response of a service's callback, if it only uses fields of it."""
        parameters = self.parameters()
        if not self.is_plain or len(parameters) < 2:
            return None
        name, kind = parameters[-1]
        if "Response" not in kind or not ("shared_ptr" in kind or kind.endswith("SharedPtr")):
            return None
        uses = self._uses(name)
        if not name or any(self._is_inner(each) or not _is_base(each) for each in uses):
            return None
        return name if self._declared(name) == 1 else None

    def assigned(self, name: str) -> dict[str, list[int]]:
        """Return the fields of a response that the function assigns by plain statements, with the lines.

        Fields that something else may change are omitted.
        """
        found: dict[str, list[int]] = {}
        for each in self._uses(name):
            parent = each.parent
            field = None if parent is None else _field(parent)
            if parent is None or field is None:
                continue
            around = parent.parent
            if around is not None and _is_left(parent, around):
                found.setdefault(field, []).append(line_of(parent))
        return {
            field: lines
            for field, lines in found.items()
            if all(
                _is_read(each) or (each.parent is not None and _is_left(each, each.parent))
                for each in self._all
                if _field(each) == field
            )
        }

    # ------------------------------------------------------------------------------------------- variables

    def _uses(self, name: str) -> list[Node]:
        return [
            each
            for each in self._all
            if each.type == "identifier" and text_of(each) == name and self._in_body(each)
        ]

    def _in_body(self, node: Node) -> bool:
        return self.body is not None and self.body.start_byte <= node.start_byte < self.body.end_byte

    def _declared(self, name: str) -> int:
        """Return how many variables and parameters have a name."""
        kinds = (
            "init_declarator",
            "parameter_declaration",
            "optional_parameter_declaration",
            "for_range_loop",
        )
        count = 0
        for each in self._all:
            if each.type in kinds:
                count += name_of(each.child_by_field_name("declarator")) == name
            elif each.type == "declaration":
                found = each.children_by_field_name("declarator")
                count += sum(name_of(one) == name for one in found if one.type != "init_declarator")
            elif each.type in ("structured_binding_declarator", "lambda_capture_initializer"):
                count += 2 * (name in text_of(each))
        return count

    def _made(self, name: str) -> Node | None:
        """Return what a variable gets, if it gets a value once and only its fields are used."""
        found = [
            each
            for each in self._all
            if each.type == "init_declarator" and name_of(each.child_by_field_name("declarator")) == name
        ]
        if len(found) != 1 or self._declared(name) != 1:
            return None
        declarator = found[0].child_by_field_name("declarator")
        if declarator is None or declarator.type != "identifier":
            return None
        for each in self._uses(name):
            is_own = each == declarator
            if self._is_inner(each) or not (is_own or _is_base(each) or _is_read(each)):
                return None
        return found[0].child_by_field_name("value")

    def _is_future(self, name: str) -> bool:
        """Return whether a variable is a future that the function only asks, once for its response."""
        if self._declared(name) != 1:
            return False
        gets = 0
        for each in self._uses(name):
            parent = each.parent
            if self._is_inner(each):
                return False
            if parent is not None and parent.type == "init_declarator":
                continue
            if parent is not None and parent.type == "argument_list":
                call = parent.parent
                called = "" if call is None else path_of(call.child_by_field_name("function"))
                if called.endswith("spin_until_future_complete"):
                    continue
                return False
            method = None if parent is None else _field(parent)
            call = None if parent is None else parent.parent
            if method not in _OF_FUTURE or call is None or call.type != "call_expression":
                return False
            gets += method == "get"
        return gets == 1

    def _is_kept(self, field: str) -> bool:
        """Return whether the function only reads the fields of a name."""
        return all(_is_read(each) for each in self._all if _field(each) == field)

    def _is_inner(self, node: Node) -> bool:
        """Return whether a node is in a lambda within the function."""
        around = node.parent
        while around is not None and around != self.function:
            if around.type == "lambda_expression":
                return True
            around = around.parent
        return False


def _field(node: Node) -> str | None:
    """Return the name of the member that an expression takes; None: another expression."""
    if node.type != "field_expression":
        return None
    return text_of(node.child_by_field_name("field"))


def _is_base(node: Node) -> bool:
    """Return whether a variable is only used for a member of what it points to."""
    parent = node.parent
    if parent is None or parent.type != "field_expression" or parent.child_by_field_name("argument") != node:
        return False
    return text_of(parent.child_by_field_name("operator")) == "->"


def _is_declared_by(name: Node, declaration: Node) -> bool:
    return name in declaration.children_by_field_name("declarator")


def _published(arguments: Node) -> str | None:
    """Return the variable that ``publish`` gets as its only argument."""
    given = [each for each in arguments.named_children if each.type != "comment"]
    if len(given) != 1:
        return None
    (value,) = given
    if value.type == "call_expression" and path_of(value.child_by_field_name("function")) == "std::move":
        inner = value.child_by_field_name("arguments")
        return None if inner is None else _published(inner)
    if value.type == "pointer_expression":
        value = value.child_by_field_name("argument") or value
    return text_of(value) if value.type == "identifier" else None


def _is_left(node: Node, parent: Node) -> bool:
    """Return whether a statement assigns just this member."""
    return (
        parent.type == "assignment_expression"
        and parent.child_by_field_name("left") == node
        and text_of(parent.child_by_field_name("operator")) == "="
        and parent.parent is not None
        and parent.parent.type == "expression_statement"
    )


def _is_read(node: Node) -> bool:
    """Return whether an expression keeps its value: a test, or a message of the log."""
    around = node.parent
    while around is not None and around.type in _READS:
        if around.type == "binary_expression" and text_of(around.child_by_field_name("operator")) in (
            "<<",
            ">>",
        ):
            return False
        if around.type.endswith("_statement"):
            return True
        around = around.parent
    if around is None or node.type != "field_expression":
        return False
    if around.type == "argument_list":
        call = around.parent
        return call is not None and text_of(call.child_by_field_name("function")).startswith("RCLCPP_")
    if around.type == "init_declarator":
        declarator = around.child_by_field_name("declarator")
        return declarator is not None and declarator.type == "identifier"  # a copy of it
    if around.type == "assignment_expression":
        right = around.child_by_field_name("right")
        return right is not None and right.start_byte <= node.start_byte < right.end_byte
    return around.type == "return_statement"


def _got(node: Node) -> str | None:
    """Return the variable of ``future.get()`` or ``future.future.get()``."""
    if node.type != "call_expression":
        return None
    function = node.child_by_field_name("function")
    if (
        function is None
        or _field(function) != "get"
        or text_of(node.child_by_field_name("arguments")) != "()"
    ):
        return None
    holder = function.child_by_field_name("argument")
    if (
        holder is None
        or holder.type != "identifier"
        or text_of(function.child_by_field_name("operator")) != "."
    ):
        return None
    return text_of(holder)
