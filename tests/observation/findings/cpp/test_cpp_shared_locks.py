"""A lock that several nodes of a program use is one lock, wherever it is declared."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from dineros.cli.main import main
from dineros.observation.findings.code import code_findings
from dineros.sources.reading import read_source

PROGRAM = """
#include <mutex>
#include "rclcpp/rclcpp.hpp"
#include "std_srvs/srv/trigger.hpp"
using Trigger = std_srvs::srv::Trigger;
BEFORE
class Server : public rclcpp::Node {
public:
  SERVER {
    service_ = create_service<Trigger>("ask", [this](
      const std::shared_ptr<Trigger::Request>, std::shared_ptr<Trigger::Response> response) {
        GUARD
        response->success = true; });
  }
  rclcpp::Service<Trigger>::SharedPtr service_;
  MEMBER
};
class Asker : public rclcpp::Node {
public:
  ASKER {
    group_ = create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive);
    client_ = create_client<Trigger>("ask", rmw_qos_profile_services_default, group_);
    timer_ = create_wall_timer(std::chrono::seconds(1), [this]() {
      GUARD
      auto future = client_->async_send_request(std::make_shared<Trigger::Request>());
      future.wait();
    });
  }
  rclcpp::CallbackGroup::SharedPtr group_;
  rclcpp::Client<Trigger>::SharedPtr client_;
  rclcpp::TimerBase::SharedPtr timer_;
  MEMBER
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  NODES
  EXECUTORS
}
"""
PLAIN = {
    "SERVER": 'Server() : Node("server")',
    "ASKER": 'Asker() : Node("asker")',
    "MEMBER": "",
    "BEFORE": "",
    "NODES": "auto a = std::make_shared<Server>(); auto b = std::make_shared<Asker>();",
}
LOCKS = {
    "a global variable": {"BEFORE": "std::mutex shared_lock;", "GUARD": "shared_lock"},
    "a variable of the file": {"BEFORE": "static std::mutex shared_lock;", "GUARD": "shared_lock"},
    "a static member": {
        "BEFORE": "struct Log { static std::mutex lock_; }; std::mutex Log::lock_;",
        "GUARD": "Log::lock_",
    },
    "a static variable": {
        "BEFORE": "std::mutex & shared_lock() { static std::mutex lock; return lock; }",
        "GUARD": "shared_lock()",
    },
    "a member of the only object": {
        "BEFORE": "struct Log { static Log & get() { static Log log; return log; } std::mutex lock_; };",
        "GUARD": "Log::get().lock_",
    },
    "a reference": {
        "SERVER": 'explicit Server(std::mutex & lock) : Node("server"), lock_(lock)',
        "ASKER": 'explicit Asker(std::mutex & lock) : Node("asker"), lock_(lock)',
        "MEMBER": "std::mutex & lock_;",
        "NODES": "std::mutex lock; auto a = std::make_shared<Server>(lock);"
        "auto b = std::make_shared<Asker>(lock);",
        "GUARD": "lock_",
    },
}
OWN = {
    "a member of each node": {"MEMBER": "std::mutex lock_;", "GUARD": "lock_"},
    "an unknown member of each node": {"MEMBER": "Unknown lock_;", "GUARD": "lock_.inner"},
    "a static variable of each template": {
        "BEFORE": "template<class T> std::mutex & of() { static std::mutex lock; return lock; }",
        "GUARD": "of<decltype(*this)>()",
    },
}
MANY = """
rclcpp::executors::MultiThreadedExecutor executor(rclcpp::ExecutorOptions(), 4);
executor.add_node(a); executor.add_node(b); executor.spin();
"""
ONE = """
rclcpp::executors::SingleThreadedExecutor executor;
executor.add_node(a); executor.add_node(b); executor.spin();
"""
TWO = """
rclcpp::executors::SingleThreadedExecutor one; one.add_node(a);
rclcpp::executors::SingleThreadedExecutor two; two.add_node(b);
std::thread apart([&]() { one.spin(); }); two.spin(); apart.join();
"""


def _written(folder: Path, parts: dict[str, str], executors: str) -> Path:
    folder.mkdir(exist_ok=True)
    text = PROGRAM
    for name, part in ({**PLAIN, "EXECUTORS": executors} | parts).items():
        text = text.replace(name, f"std::lock_guard<std::mutex> guard({part});" if name == "GUARD" else part)
    (folder / "robot.cpp").write_text(text)
    return folder


def _rules(folder: Path) -> list[str]:
    found = code_findings([(str(folder), read_source(folder))])
    return [each.rule for each in found if each.rule == "code-holds-lock"]


@pytest.mark.parametrize("executors", [MANY, TWO], ids=["many", "two"])
@pytest.mark.parametrize("kind", LOCKS)
def test_a_wait_under_a_lock_of_two_nodes(tmp_path: Path, kind: str, executors: str) -> None:
    assert _rules(_written(tmp_path / "robot", LOCKS[kind], executors)) == ["code-holds-lock"]


@pytest.mark.parametrize("kind", LOCKS)
def test_one_thread_runs_one_callback_at_a_time(tmp_path: Path, kind: str) -> None:
    assert _rules(_written(tmp_path / "robot", LOCKS[kind], ONE)) == []


@pytest.mark.parametrize("kind", [each for each in OWN if "template" not in each])
def test_each_node_has_its_own_lock(tmp_path: Path, kind: str) -> None:
    assert _rules(_written(tmp_path / "robot", OWN[kind], MANY)) == []


def test_two_lambdas_of_one_node(tmp_path: Path) -> None:
    """Callbacks of one name are different callbacks."""
    parts = {
        "ASKER": 'Asker() : Node("asker")',
        "BEFORE": "",
        "MEMBER": "std::mutex lock_;",
        "GUARD": "lock_",
        "NODES": "auto b = std::make_shared<Asker>();",
    }
    folder = _written(tmp_path / "robot", parts, MANY.replace("executor.add_node(a);", ""))
    text, end = (folder / "robot.cpp").read_text(), "response->success = true; });"
    service = text[text.index("    service_ =") : text.index(end) + len(end)]
    own = service.replace("service_ =", "auto own =") + "\n    client_ ="
    text = text.replace("    client_ =", own, 1)
    (folder / "robot.cpp").write_text(text)
    assert _rules(folder) == ["code-holds-lock"]


def test_proofs_are_under_an_assumption(tmp_path: Path) -> None:
    folder = _written(tmp_path / "robot", LOCKS["a global variable"], MANY)
    model = str(tmp_path / "robot.sym.xmi")
    CliRunner().invoke(main, ["import", "--no-cache", "-q", "--source", str(folder), "-o", model])
    shown = CliRunner().invoke(main, ["check", model]).output
    assert "under an assumption" in shown
    assert "holds shared_lock" in shown
