"""Quality of service that code changes after it is made, and constants that look like marks of a compiler."""

from __future__ import annotations

from pathlib import Path
from textwrap import indent

import pytest

from dineros.sources.reading import read_source

PROGRAM = """
#include <rclcpp/rclcpp.hpp>
using Text = std_msgs::msg::String;
namespace specs {
struct News {
  using Message = Text;
  static constexpr char name[] = "news";
  static constexpr size_t depth = 3;
  static constexpr auto reliability = RMW_QOS_POLICY_RELIABILITY_BEST_EFFORT;
  static constexpr auto durability = RMW_QOS_POLICY_DURABILITY_TRANSIENT_LOCAL;
};
}
template <class Spec>
rclcpp::QoS quality() {
  rclcpp::QoS qos(Spec::depth);
  qos.reliability(Spec::reliability);
  qos.durability(Spec::durability);
  return qos;
}
void weaken(rclcpp::QoS & qos) { qos.best_effort(); }
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
BODY
    out_ = create_publisher<Text>("out", QOS);
  }
  bool is_lossy();
  rclcpp::QoS own_{10};
  rclcpp::Publisher<Text>::SharedPtr out_;
};
int main() { rclcpp::init(0, nullptr); rclcpp::spin(std::make_shared<Robot>()); }
"""
QOS = "rclcpp::QoS qos(7);"


BEST, LATCHED, LOSSY = "best_effort", "transient_local", "open: reliable or best_effort"
RMW = "RMW_QOS_POLICY_"
FROM = "rclcpp::QoS(rclcpp::QoSInitialization"


@pytest.mark.parametrize(
    ("body", "qos", "found"),
    [
        (f"{QOS} qos.best_effort();", "qos", (7, BEST, "volatile")),
        (f"{QOS} qos.keep_last(4).transient_local();", "qos", (4, "reliable", LATCHED)),
        (f"{QOS} auto other = qos; other.best_effort();", "qos", (7, "reliable", "volatile")),
        (f"{QOS} auto other = qos; other.best_effort();", "other", (7, BEST, "volatile")),
        (f"{QOS} weaken(qos);", "qos", (7, BEST, "volatile")),
        ("own_.keep_last(8).best_effort();", "own_", (8, BEST, "volatile")),
        ("auto qos = std::make_shared<rclcpp::QoS>(5); qos->best_effort();", "*qos", (5, BEST, "volatile")),
        (f"{QOS} if (is_lossy()) {{ qos.best_effort(); }}", "qos", (7, LOSSY, "volatile")),
        (f"{QOS} while (is_lossy()) {{ qos.best_effort(); }}", "qos", (7, LOSSY, "volatile")),
        (
            f"{QOS} qos.get_rmw_qos_profile().durability = {RMW}DURABILITY_TRANSIENT_LOCAL;",
            "qos",
            (7, "reliable", LATCHED),
        ),
        (
            "rmw_qos_profile_t own = rmw_qos_profile_default; own.depth = 6; auto copy = own;"
            f" copy.depth = 2; own.reliability = {RMW}RELIABILITY_BEST_EFFORT;",
            f"{FROM}::from_rmw(own), own)",
            (6, BEST, "volatile"),
        ),
        ("", f"{FROM}({RMW}HISTORY_KEEP_LAST, 2), rmw_qos_profile_sensor_data)", (2, BEST, "volatile")),
        ("", f"{FROM}({RMW}HISTORY_KEEP_ALL, 2))", (0, "reliable", "volatile")),
        ("", f"{FROM}::from_rmw(rmw_qos_profile_sensor_data))", (5, "reliable", "volatile")),
        ("", "rclcpp::SensorDataQoS(rclcpp::KeepLast(2))", (2, BEST, "volatile")),
        ("", "rclcpp::SensorDataQoS(rclcpp::KeepAll())", (0, BEST, "volatile")),
        ("", "rclcpp::QoS(9).history(rclcpp::HistoryPolicy::KeepAll)", (0, "reliable", "volatile")),
        ("", f"rclcpp::QoS(1).durability({RMW}DURABILITY_TRANSIENT_LOCAL)", (1, "reliable", LATCHED)),
        ("", "quality<specs::News>()", (3, BEST, LATCHED)),
    ],
)
def test_a_quality_is_that_of_the_last_change(
    tmp_path: Path, body: str, qos: str, found: tuple[object, str, str]
) -> None:
    (tmp_path / "robot.cpp").write_text(
        PROGRAM.replace("BODY", indent(body, "    ")).replace("QOS);", f"{qos});")
    )
    (node,) = read_source(tmp_path).nodes
    (entity,) = node.of("publishers")
    assert tuple(entity.details[key] for key in ("depth", "reliability", "durability")) == found


def test_what_a_branch_makes_is_certain_in_it(tmp_path: Path) -> None:
    """Both the profile and the publisher exist only there."""
    made = 'other_ = create_publisher<Text>("a", qos);'
    body = f"if (is_lossy()) {{ rclcpp::QoS qos(2); qos.best_effort(); {made} }}"
    (tmp_path / "robot.cpp").write_text(PROGRAM.replace("BODY", body).replace("QOS);", "5);"))
    (node,) = read_source(tmp_path).nodes
    assert [(each.name, each.details["reliability"]) for each in node.of("publishers")] == [
        ("a", "best_effort"),
        ("out", "reliable"),
    ]


HELPERS = """
#include <rclcpp/rclcpp.hpp>
namespace specs {
struct Level { using Service = std_srvs::srv::Trigger; static constexpr char name[] = "level"; };
struct Reset { using Service = std_srvs::srv::Empty; static constexpr char name[] = "reset"; };
}
namespace parts {
template <class Spec, class NodeT = rclcpp::Node>
class Client {
 public:
  RCLCPP_SMART_PTR_DEFINITIONS(Client)
  explicit Client(NodeT * node) {
    client_ = node->template create_client<typename Spec::Service>(Spec::name);
  }
  typename rclcpp::Client<typename Spec::Service>::SharedPtr client_;
};
template <class Spec, class NodeT>
auto make_client(NodeT * node) { return Client<Spec, NodeT>::make_shared(node); }
}
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    level_ = parts::make_client<specs::Level>(this);
    reset_ = parts::Client<specs::Reset>::make_shared(this);
  }
  parts::Client<specs::Level>::SharedPtr level_;
  parts::Client<specs::Reset>::SharedPtr reset_;
};
int main() { rclcpp::init(0, nullptr); rclcpp::spin(std::make_shared<Robot>()); }
"""


def test_make_shared_of_a_class_template_has_its_arguments(tmp_path: Path) -> None:
    (tmp_path / "robot.cpp").write_text(HELPERS)
    (node,) = read_source(tmp_path).nodes
    found = [(each.name, each.type) for each in node.of("clients")]
    assert found == [("level", "std_srvs/srv/Trigger"), ("reset", "std_srvs/srv/Empty")]


BRANCHES = """
#include <rclcpp/rclcpp.hpp>
using Text = std_msgs::msg::String;
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    std::string name, other = "start";
BODY
    last_ = create_publisher<Text>("last_" + other, 1);
  }
  bool is_lossy();
  std::string own_ = "own";
  rclcpp::Publisher<Text>::SharedPtr first_, second_, last_;
};
int main() { rclcpp::init(0, nullptr); rclcpp::spin(std::make_shared<Robot>()); }
"""


@pytest.mark.parametrize(
    ("body", "found"),
    [
        # Each port has the name that was set last before it, in its branch.
        (
            'if (is_lossy()) { name = "a"; first_ = create_publisher<Text>(name, 1);'
            ' name = "b"; second_ = create_publisher<Text>(name, 1); }',
            ["a", "b", "last_start"],
        ),
        (
            'if (is_lossy()) { own_ = "a"; first_ = create_publisher<Text>(own_, 1); }'
            ' else { own_ = "b"; second_ = create_publisher<Text>(own_, 1); }',
            ["a", "b", "last_start"],
        ),
        # One branch does not see what the other one sets; afterwards both are possible.
        (
            'if (is_lossy()) { other = "a"; } else { first_ = create_publisher<Text>(other, 1); }',
            ["start", "last_start", "last_a"],
        ),
        ('if (is_lossy()) { other = "a"; } else { other = "b"; }', ["last_a", "last_b"]),
        ('if (is_lossy()) { if (is_lossy()) { other = "a"; } }', ["last_start", "last_a"]),
        ('while (is_lossy()) { other = "a"; }', ["open: last_{other} or last_a"]),
        ('if (true) { other = "a"; } else { other = "b"; }', ["last_a"]),
        (
            'if (declare_parameter("more", false)) { other = "a";'
            " first_ = create_publisher<Text>(other, 1); }",
            ["a", "last_start"],
        ),
        ('if (is_lossy()) { other = "a"; return; } other = "b";', ["last_b"]),
    ],
)
def test_what_a_branch_sets_is_known_in_it(tmp_path: Path, body: str, found: list[str]) -> None:
    (tmp_path / "robot.cpp").write_text(BRANCHES.replace("BODY", body))
    (node,) = read_source(tmp_path).nodes
    assert [each.name for each in node.of("publishers")] == found


OF_C = """
rmw_qos_profile_t listed{RMW_QOS_POLICY_HISTORY_KEEP_LAST, 7, RMW_QOS_POLICY_RELIABILITY_BEST_EFFORT,
  RMW_QOS_POLICY_DURABILITY_TRANSIENT_LOCAL, RMW_QOS_DEADLINE_DEFAULT, RMW_QOS_LIFESPAN_DEFAULT, false};
auto qos = rclcpp::QoS(rclcpp::QoSInitialization(listed.history, listed.depth), listed);
static const rmw_qos_profile_t named = {.history = RMW_QOS_POLICY_HISTORY_KEEP_LAST, .depth = 3,
  .reliability = RMW_QOS_POLICY_RELIABILITY_BEST_EFFORT, .durability = RMW_QOS_POLICY_DURABILITY_VOLATILE};
using Text = std_msgs::msg::String;
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    rmw_qos_profile_t own{RMW_QOS_POLICY_HISTORY_KEEP_ALL, 9, RMW_QOS_POLICY_RELIABILITY_RELIABLE};
    outs_.push_back(create_publisher<Text>("listed", qos));
    auto other = rclcpp::QoS(rclcpp::QoSInitialization::from_rmw(named), named);
    outs_.push_back(create_publisher<Text>("named", other));
    auto last = rclcpp::QoS(rclcpp::QoSInitialization(own.history, own.depth), own);
    outs_.push_back(create_publisher<Text>("own", last));
  }
  std::vector<rclcpp::Publisher<Text>::SharedPtr> outs_;
};
int main() { rclcpp::init(0, nullptr); rclcpp::spin(std::make_shared<Robot>()); }
"""


def test_profiles_of_c_have_members_in_braces(tmp_path: Path) -> None:
    (tmp_path / "robot.cpp").write_text(OF_C)
    found = {each.name: each.details for each in read_source(tmp_path).nodes[0].of("publishers")}
    listed, named, own = found["listed"], found["named"], found["own"]
    assert (listed["depth"], listed["reliability"], listed["durability"]) == (7, BEST, LATCHED)
    assert (named["depth"], named["reliability"], named["durability"]) == (3, BEST, "volatile")
    assert (own["history"], own["depth"], own["reliability"]) == ("keep_all", 0, "reliable")
    assert own["durability"].startswith("open")


@pytest.mark.parametrize(
    ("qos", "found"),
    [
        ("rclcpp::QoS(5).deadline(500ms)", (0.5, None, None)),
        ("rclcpp::QoS(5).deadline(rclcpp::Duration::from_seconds(2.0)).reliable()", (2.0, None, None)),
        ("rclcpp::QoS(5).deadline(std::chrono::hours::max())", (None, None, None)),
        (
            "rclcpp::QoS(5).liveliness(RMW_QOS_POLICY_LIVELINESS_MANUAL_BY_TOPIC)",
            (None, "manual_by_topic", None),
        ),
        (
            "rclcpp::QoS(5).liveliness(rclcpp::LivelinessPolicy::ManualByTopic)",
            (None, "manual_by_topic", None),
        ),
        ("rclcpp::QoS(5).liveliness(RMW_QOS_POLICY_LIVELINESS_AUTOMATIC)", (None, None, None)),
        ("rclcpp::QoS(5).liveliness_lease_duration(1s)", (None, None, 1.0)),
        ("rclcpp::QoS(5).deadline(period)", ("open: period", None, None)),
        ("rclcpp::QoS(5)", (None, None, None)),
    ],
)
def test_deadlines_and_liveliness_are_read(tmp_path: Path, qos: str, found: tuple[object, ...]) -> None:
    """They were ignored, so that ports that do not match were proved to match."""
    text = PROGRAM.replace("BODY", "").replace("QOS", qos)
    (tmp_path / "robot.cpp").write_text(text)
    (port,) = read_source(tmp_path).nodes[0].of("publishers")
    details = port.details
    assert (details.get("deadline"), details.get("liveliness"), details.get("lease_duration")) == found


def test_a_generic_subscription_has_its_quality_and_its_callback(tmp_path: Path) -> None:
    """The type is its second argument."""
    more = """
    sub_ = create_generic_subscription("in", "std_msgs/msg/String", rclcpp::QoS(3).best_effort(),
      [this](std::shared_ptr<rclcpp::SerializedMessage> message) { other_->publish(*message); });
    other_ = create_generic_publisher("other", "std_msgs/msg/String", 4);"""
    (tmp_path / "robot.cpp").write_text(PROGRAM.replace("BODY", more).replace("QOS", "10"))
    (node,) = read_source(tmp_path).nodes
    (port,) = node.of("subscriptions")
    assert (port.type, port.details["depth"], port.details["reliability"]) == ("std_msgs/msg/String", 3, BEST)
    assert [each.do for each in port.callbacks["callback"].effects] == ["publish"]
    assert [each.details["depth"] for each in node.of("publishers")] == [4, 10]
