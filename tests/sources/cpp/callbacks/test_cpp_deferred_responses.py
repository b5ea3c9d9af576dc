"""Services in C++ whose callback sends the response later."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.findings.code import code_findings
from dineros.observation.importing.coded import coded
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

CODE = """
#include <rclcpp/rclcpp.hpp>
using namespace std::chrono_literals;
using std_srvs::srv::Trigger;
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    service_ = create_service<Trigger>("ask", [this](PARAMETERS) { BODY });
    timer_ = create_wall_timer(1s, [this]() { TICK });
  }
  std::vector<std::shared_ptr<rmw_request_id_t>> waiting_;
  rclcpp::Service<Trigger>::SharedPtr service_;
  rclcpp::TimerBase::SharedPtr timer_;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<Robot>());
}
"""
ID = "const std::shared_ptr<rmw_request_id_t> id, "
REQUEST = "const std::shared_ptr<Trigger::Request> request"
SELF = "std::shared_ptr<rclcpp::Service<Trigger>> self, "
SENDS = "Trigger::Response r; service_->send_response(*id, r);"
FROM_LIST = "for (auto & id : waiting_) { Trigger::Response r; service_->send_response(*id, r); }"


def read(folder: Path, parameters: str, body: str, tick: str) -> tuple[list[str], bool]:
    """Return the findings, and whether proofs assume that the response comes at the end of the callback."""
    text = CODE.replace("PARAMETERS", parameters).replace("BODY", body).replace("TICK", tick)
    (folder / "robot.cpp").write_text(text)
    facts = read_source(folder)
    found = [each.rule for each in code_findings([(".", facts)])]
    model = coded([(".", facts)], "robot")
    return found, any("without a response" in each for each in model.lacks)


@pytest.mark.parametrize("parameters", [ID + REQUEST, SELF + ID + REQUEST])
@pytest.mark.parametrize("body", ["", "waiting_.push_back(id);"])
def test_a_response_that_no_code_sends_is_an_error(tmp_path: Path, parameters: str, body: str) -> None:
    """The model responds when the callback ends, so that waiting clients were proved to continue."""
    assert read(tmp_path, parameters, body, "") == (["code-gives-none"], False)


@pytest.mark.parametrize(
    ("body", "tick", "is_assumed"),
    [
        (SENDS, "", False),
        ("waiting_.push_back(id);", FROM_LIST, True),
        ("send_response(service_, id);", "", True),
    ],
)
def test_a_response_that_is_sent_later_is_assumed(
    tmp_path: Path, body: str, tick: str, is_assumed: bool
) -> None:
    """What other code sends is not at the end of the callback."""
    assert read(tmp_path, ID + REQUEST, body, tick) == ([], is_assumed)


@pytest.mark.parametrize(
    "parameters",
    [
        f"{REQUEST}, std::shared_ptr<Trigger::Response> r",
        f"{ID}{REQUEST}, Trigger::Response::SharedPtr r",
        "auto a, auto b",
    ],
)
def test_usual_services_respond_when_they_end(tmp_path: Path, parameters: str) -> None:
    """The callback has a response to fill."""
    assert read(tmp_path, parameters, "", "") == ([], False)
