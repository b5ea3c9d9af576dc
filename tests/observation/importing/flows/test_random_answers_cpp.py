"""Random callbacks in C++: what the same program does in Python is what their flows allow."""

from __future__ import annotations

import ast
from collections.abc import Iterable
from pathlib import Path

import pytest

from dineros.observation.importing.coded import Coded, coded
from dineros.sources.reading import read_source
from tests.observation.importing.flows.test_random_enumerations import (
    DEFINED,
    VALUES,
    Asker,
    Giver,
    fitting,
    other,
    runs_of,
)
from tests.support.flow_runs import accepts

HEAD = """
#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/empty.hpp>
#include <mode_msgs/srv/ask.hpp>
using mode_msgs::srv::Ask;
using std_msgs::msg::Empty;
class Made : public rclcpp::Node {
public:
  Made() : Node("%NAME%") {
    b_ = create_publisher<Empty>("%B%", 1);
    a_ = create_publisher<Empty>("%A%", 1);
%MAKES%
  }
private:
%METHODS%
  rclcpp::Publisher<Empty>::SharedPtr a_, b_;
  rclcpp::Client<Ask>::SharedPtr dock_;
  rclcpp::Service<Ask>::SharedPtr service_;
  rclcpp::TimerBase::SharedPtr timer_;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::executors::MultiThreadedExecutor executor(rclcpp::ExecutorOptions(), 3);
  auto node = std::make_shared<Made>();
  executor.add_node(node);
  executor.spin();
}
"""
SERVER = (
    '    service_ = create_service<Ask>("ask",'
    " std::bind(&Made::tick, this, std::placeholders::_1, std::placeholders::_2));",
    "  void tick(const std::shared_ptr<Ask::Request> request,"
    " std::shared_ptr<Ask::Response> response) {{\n{}\n  }}",
)
CALLS = (
    '    dock_ = create_client<Ask>("ask");\n'
    "    timer_ = create_wall_timer(std::chrono::seconds(1), std::bind(&Made::tick, this));",
    "  void tick() {{\n{}\n  }}",
)
STARTED = (
    CALLS[0].replace("Made::tick", "Made::start"),
    "  void start() {{ dock_->async_send_request(std::make_shared<Ask::Request>(),"
    " std::bind(&Made::tick, this, std::placeholders::_1)); }}\n"
    "  void tick(rclcpp::Client<Ask>::SharedFuture future) {{\n    auto response = future.get();\n{}\n  }}",
)
LAMBDA = (
    STARTED[0],
    "  void start() {{ dock_->async_send_request(std::make_shared<Ask::Request>(),"
    " [this](rclcpp::Client<Ask>::SharedFuture future) {{\n    auto response = future.get();\n{}\n  }}); }}",
)
GIVES = "    response->state = Ask::Response::STATE_BUSY;"
ASKS = "    if (response->state == Ask::Response::STATE_BUSY) { a_->publish(Empty()); }"


class NotInCppError(Exception):
    """A program has no counterpart."""


class Printer:
    """Writes a callback in Python as one in C++."""

    def __init__(self, *, switches: bool = False) -> None:
        self._switches = switches
        self._futures = 0

    def block(self, statements: Iterable[ast.stmt], space: str, *, is_top: bool = False) -> list[str]:
        return [line for each in statements for line in self.statement(each, space, is_top)]

    def statement(self, each: ast.stmt, space: str, is_top: bool) -> list[str]:
        inner = f"{space}  "
        if isinstance(each, ast.If):
            found = self.choice(each, space) if self._switches else None
            if found is not None:
                return found
            lines = [f"{space}if ({self.test(each.test)}) {{", *self.block(each.body, inner)]
            if each.orelse:
                lines += [f"{space}}} else {{", *self.block(each.orelse, inner)]
            return [*lines, f"{space}}}"]
        if isinstance(each, ast.For):
            head = f"{space}for (int turn = 0; turn < 2; ++turn) {{"
            return [head, *self.block(each.body, inner), f"{space}}}"]
        if isinstance(each, ast.Try) and not each.finalbody:
            caught = self.block(each.handlers[0].body, inner)
            head = f"{space}}} catch (const std::exception & error) {{"
            return [f"{space}try {{", *self.block(each.body, inner), head, *caught, f"{space}}}"]
        if isinstance(each, ast.Return) and (each.value is None or isinstance(each.value, ast.Name)):
            return [f"{space}return;"]
        if isinstance(each, ast.Expr):
            port = ast.unparse(each).split(".")[1]
            return [f"{space}{port}_->publish(Empty());"]
        if isinstance(each, ast.Assign) and isinstance(each.targets[0], ast.Attribute):
            return [f"{space}response->{each.targets[0].attr} = {self.test(each.value)};"]
        if isinstance(each, ast.Assign) and is_top:
            self._futures += 1
            name, request = ast.unparse(each.targets[0]), "std::make_shared<Ask::Request>()"
            future = f"future_{self._futures}"
            sends = f"{space}auto {future} = dock_->async_send_request({request});"
            return [sends, f"{space}auto {name} = {future}.get();"]
        raise NotInCppError

    def choice(self, each: ast.If, space: str) -> list[str] | None:
        """Write a comparison as a ``switch``."""
        test = each.test
        if not isinstance(test, ast.Compare) or not isinstance(test.ops[0], (ast.Eq, ast.In)):
            return None
        if not isinstance(test.left, ast.Attribute):
            return None
        (right,) = test.comparators
        values = right.elts if isinstance(right, (ast.Tuple, ast.List)) else [right]
        labels = list(dict.fromkeys(self.test(one) for one in values))
        lines = [f"{space}switch ({self.test(test.left)}) {{", *(f"{space}  case {one}:" for one in labels)]
        lines += [*self.block(each.body, f"{space}    "), f"{space}    break;"]
        if each.orelse:
            lines += [f"{space}  default:", *self.block(each.orelse, f"{space}    ")]
        return [*lines, f"{space}}}"]

    def test(self, each: ast.expr) -> str:
        if isinstance(each, ast.BoolOp):
            sign = " && " if isinstance(each.op, ast.And) else " || "
            return f"({sign.join(self.test(one) for one in each.values)})"
        if isinstance(each, ast.UnaryOp):
            return f"!({self.test(each.operand)})"
        if isinstance(each, ast.Call) or "random" in ast.unparse(each):
            return "std::rand() < 5"
        if isinstance(each, ast.Compare):
            left, (right,) = self.test(each.left), each.comparators
            values = right.elts if isinstance(right, (ast.Tuple, ast.List)) else [right]
            sign, join = ("==", " || ") if isinstance(each.ops[0], (ast.Eq, ast.In)) else ("!=", " && ")
            return f"({join.join(f'{left} {sign} {self.test(one)}' for one in values)})"
        if isinstance(each, ast.Attribute):
            path = ast.unparse(each).split(".")
            return "::".join(path) if path[0] == "Ask" else "->".join(path)
        return {"True": "true", "False": "false"}.get(ast.unparse(each), ast.unparse(each))


def in_cpp(body: list[str], *, switches: bool = False) -> str:
    """Return the body of a callback in C++."""
    parsed = ast.parse("\n".join(["def tick(self):", *body])).body[0]
    assert isinstance(parsed, ast.FunctionDef)
    return "\n".join(Printer(switches=switches).block(parsed.body, "    ", is_top=True))


def read(folder: Path, server: str = GIVES, client: str = ASKS, form: tuple[str, str] = STARTED) -> Coded:
    """Return what a server and a client in C++ say."""
    (folder / "mode_msgs" / "srv").mkdir(parents=True)
    (folder / "mode_msgs" / "package.xml").write_text("<package><name>mode_msgs</name></package>")
    (folder / "mode_msgs" / "srv" / "Ask.srv").write_text(DEFINED + "bool success\n")
    (folder / "demo").mkdir()
    (folder / "demo" / "package.xml").write_text("<package><name>demo</name></package>")
    (folder / "demo" / "CMakeLists.txt").write_text(
        "add_executable(server server.cpp)\nadd_executable(client client.cpp)\n"
    )
    for name, (makes, methods), body, a, b in (
        ("server", SERVER, server, "served", "asked"),
        ("client", form, client, "alarm", "docked"),
    ):
        text = HEAD
        for key, value in (("NAME", name), ("A", b), ("B", a), ("MAKES", makes)):
            text = text.replace(f"%{key}%", value)
        text = text.replace("%METHODS%", methods.format(body))
        (folder / "demo" / f"{name}.cpp").write_text(text)
    return coded([("", read_source(folder))], "code")


class AskerInCpp(Asker):
    """Writes programs without ``match``, which C++ does not have."""

    has_matches = False


@pytest.mark.parametrize("switches", [True, False])
def test_random_servers_do_what_their_branches_allow(tmp_path: Path, switches: bool) -> None:
    decided = refused = 0
    for seed in range(120):
        body = [*Giver(seed).block(8, 3), "        return response"]
        folder = tmp_path / str(seed)
        try:
            text = in_cpp(body, switches=switches)
        except NotInCppError:
            continue
        code = read(folder, text)
        flow = code.given.nodes["/server"].callbacks["/ask"].flow
        if flow is None:
            continue
        decided += 1
        fits = fitting(code.given.deciding["service /ask"])
        for value in (0, 9):  # what the response has before is open
            for each in runs_of(body, (value,), is_server=True):
                assert accepts(flow, each, fits), (seed, each, text)
                refused += not accepts(flow, other(each), fits)
    assert decided > 15
    assert refused > 20


@pytest.mark.parametrize("form", ["calls", "started", "lambda", "switch"])
def test_random_clients_do_what_their_branches_allow(tmp_path: Path, form: str) -> None:
    decided = refused = 0
    is_call = form == "calls"
    for seed in range(100):
        body = AskerInCpp(seed, calls=False).block(8, 3)
        if is_call:
            body = ["        response = self.dock.call(Ask.Request())", *body]
        folder = tmp_path / str(seed)
        try:
            text = in_cpp(body, switches=form == "switch")
        except NotInCppError:
            continue
        code = read(folder, client=text, form={"calls": CALLS, "lambda": LAMBDA}.get(form, STARTED))
        callbacks = code.given.nodes["/client"].callbacks
        flow = callbacks["tick" if is_call else "/ask"].flow
        if flow is None:
            continue
        decided += 1
        fits = fitting(code.given.deciding["service /ask"])
        for answers in ((value,) for value in VALUES):
            for each in runs_of(body, answers, is_server=False):
                run = each if is_call else (answers[0], *each)
                assert accepts(flow, run, fits), (seed, run, text)
                refused += not accepts(flow, other(run), fits)
    assert decided > 15
    assert refused > 10


# ------------------------------------------------------------------------------------- what is not certain


UNCERTAIN = {
    "another name": "    auto other = response;\n" + ASKS,
    "given away": "    keep(response);\n" + ASKS,
    "a part given away": "    change(response->state);\n" + ASKS,
    "a reference": "    auto & state = response->state;\n    state = 1;\n" + ASKS,
    "a pointer": "    auto state = &response->state;\n    *state = 1;\n" + ASKS,
    "changed": "    response->state = 1;\n" + ASKS,
    "counted": "    response->state++;\n" + ASKS,
    "all of it": "    *response = Ask::Response();\n" + ASKS,
    "a lambda": "    auto change = [&]() { response->state = 2; };\n    change();\n" + ASKS,
    "the future": "    future.get()->state = 2;\n" + ASKS,
    "a copy of the future": "    auto later = future;\n    later.get()->state = 2;\n" + ASKS,
    "a jump": "again:\n    if (std::rand() < 5) { goto again; }\n" + ASKS,
    "a stream": "    input >> response->state;\n" + ASKS,
    "arithmetic": ASKS.replace("== Ask::Response::STATE_BUSY", "+ 1 == 2"),
    "an unknown constant": ASKS.replace("Ask::Response::STATE_BUSY", "limit_"),
    "a variable of the name": "    { auto response = last_; if (response->state == 1) { return; } }\n" + ASKS,
}


@pytest.mark.parametrize("case", UNCERTAIN)
def test_a_client_that_may_change_a_response_is_open(tmp_path: Path, case: str) -> None:
    code = read(tmp_path / case, client=UNCERTAIN[case])
    assert code.given.nodes["/client"].callbacks["/ask"].flow is None


OPEN = {
    "another name": "    auto other = response;\n    other->state = 2;\n" + GIVES,
    "given away": GIVES + "\n    fill(response);",
    "a part given away": GIVES + "\n    change(response->state);",
    "all of it": GIVES + "\n    *response = last_;",
    "a lambda": GIVES + "\n    auto change = [&]() { response->state = 2; };\n    change();",
    "a sum": GIVES + "\n    response->state |= 2;",
    "in an expression": GIVES + "\n    if ((response->state = count()) > 1) { a_->publish(Empty()); }",
    "a reference": GIVES + "\n    auto & state = response->state;\n    state = 2;",
    "a number that does not fit": "    response->state = 257;",
    "a jump": "again:\n" + GIVES + "\n    if (std::rand() < 5) { goto again; }",
}


@pytest.mark.parametrize("case", OPEN)
def test_a_server_that_may_give_anything_is_open(tmp_path: Path, case: str) -> None:
    code = read(tmp_path / case, server=OPEN[case])
    assert code.given.deciding == {}


def test_a_response_by_a_value_that_is_not_known_may_be_any(tmp_path: Path) -> None:
    server = f"    if (std::rand() < 5) {{ response->state = count(); return; }}\n{GIVES}"
    code = read(tmp_path / "any", server=server)
    assert code.given.nodes["/server"].callbacks["/ask"].flow is None
    flow = code.given.nodes["/client"].callbacks["/ask"].flow
    assert flow is not None
    fits = fitting(code.given.deciding["service /ask"])
    assert all(accepts(flow, (value, *(["a"] if value == 1 else [])), fits) for value in VALUES)
    fixed = read(tmp_path / "fixed").given.nodes["/server"].callbacks["/ask"].flow
    assert fixed is not None
    assert [value for value in VALUES if accepts(fixed, (value,), fits)] == [1]


def test_two_requests_in_one_line_are_not_told_apart(tmp_path: Path) -> None:
    sends = "dock_->async_send_request(std::make_shared<Ask::Request>());"
    text = (
        f"    auto one = {sends} auto two = {sends}\n    auto response = one.get();\n    two.get();\n{ASKS}"
    )
    for name, body in (("together", text), ("apart", text.replace("; auto", ";\n    auto"))):
        code = read(tmp_path / name, client=body, form=CALLS)
        assert (code.given.nodes["/client"].callbacks["tick"].flow is not None) == (name == "apart")
