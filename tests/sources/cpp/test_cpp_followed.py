"""Names, types and callbacks that code in C++ hands on: templates, aliases, lists, filters, wrappers."""

from pathlib import Path

import pytest

from dineros.sources.facts import Entity, is_open
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

HEAD = """
#include <rclcpp/rclcpp.hpp>
using std_msgs::msg::String;
"""
MAIN = """
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<Robot>());
}
"""


def _entities(folder: Path, code: str) -> list[Entity]:
    (folder / "robot.cpp").write_text(HEAD + code + MAIN, encoding="utf-8")
    (node,) = read_source(folder).nodes
    return [each for each in node.entities if each.kind not in ("parameters", "groups")]


def _of(folder: Path, body: str, members: str = "", before: str = "") -> list[Entity]:
    return _entities(
        folder,
        f"{before}\nclass Robot : public rclcpp::Node {{\n public:\n"
        f'  Robot() : Node("robot") {{\n{body}\n  }}\n'
        f"  void onText(const String & text) {{ RCLCPP_INFO(get_logger(), text.data); }}\n{members}\n}};\n",
    )


def test_a_method_of_a_template_argument_has_a_type(tmp_path: Path) -> None:
    helper = """
template<class NodeT>
struct Saver {
  explicit Saver(NodeT node) {
    out_ = node->template create_publisher<std_msgs::msg::String>("saved", 1);
  }
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr out_;
};
"""
    (found,) = _of(tmp_path, "saver_ = std::make_unique<Saver<Robot *>>(this);", before=helper)
    assert (found.name, found.type) == ("saved", "std_msgs/msg/String")


def test_an_alias_of_a_filter_has_its_type(tmp_path: Path) -> None:
    (found,) = _of(
        tmp_path,
        'sub_.reset(new Texts(this, "in"));\nsub_->registerCallback(&Robot::onText, this);',
        "typedef message_filters::Subscriber<std_msgs::msg::String> Texts;\n  std::shared_ptr<Texts> sub_;",
    )
    assert (found.kind, found.name, found.type) == ("subscriptions", "in", "std_msgs/msg/String")
    assert found.callbacks["callback"].name == "onText"


@pytest.mark.parametrize("order", ["callback first", "callback last"])
def test_a_filter_that_subscribes_later_is_a_subscription(tmp_path: Path, order: str) -> None:
    steps = [
        'filter_ = std::make_shared<tf2_ros::MessageFilter<String>>(sub_, buffer_, "map", 10);\n'
        "filter_->registerCallback(std::bind(&Robot::onText, this, std::placeholders::_1));",
        'sub_.subscribe(this, "cloud", rmw_qos_profile_sensor_data);',
    ]
    (found,) = _of(
        tmp_path,
        "\n".join(steps if order == "callback first" else reversed(steps)),
        "message_filters::Subscriber<std_msgs::msg::String> sub_;\n"
        "  std::shared_ptr<tf2_ros::MessageFilter<String>> filter_;",
    )
    assert (found.name, found.type) == ("cloud", "std_msgs/msg/String")
    assert found.callbacks["callback"].name == "onText"


def test_images_have_their_own_publishers_and_a_copy_is_no_second_one(tmp_path: Path) -> None:
    (found,) = _of(
        tmp_path,
        "auto base = get_node_base_interface();\n"
        'std::string topic = base->resolve_topic_or_service_name("image", false);\n'
        "out_ = std::make_shared<image_transport::Publisher>(\n"
        "  image_transport::create_publisher(this, topic));",
    )
    assert (found.name, found.type) == ("image", "sensor_msgs/msg/Image")


@pytest.mark.parametrize(
    ("start", "name"),
    [
        ("std::string topic;", "other"),  # it has no name else
        ("std::string topic; vendor::fill(topic);", None),
        ("std::string topic; std::getline(std::cin, topic);", None),
        ("std::string topic; std::cin >> topic;", None),
        ('vendor::Config config; std::string topic; config.get("topic", topic);', None),
    ],
)
def test_a_variable_without_a_value_has_the_one_that_it_gets(
    tmp_path: Path, start: str, name: str | None
) -> None:
    (found,) = _of(
        tmp_path,
        f'{start}\nif (argc_ > 1) {{ topic = "other"; }}\ncreate_publisher<std_msgs::msg::String>(topic, 1);',
    )
    assert is_open(found.name) if name is None else found.name == name


def test_each_name_that_branches_give_is_an_alternative(tmp_path: Path) -> None:
    found = _of(
        tmp_path,
        'std::string topic = "one";\nif (argc_ > 1) { topic = "other"; }\n'
        "create_publisher<std_msgs::msg::String>(topic, 1);\n"
        'create_publisher<std_msgs::msg::String>(argc_ > 2 ? "three" : "four", 1);',
    )
    assert {each.name for each in found} == {"one", "other", "three", "four"}
    assert {each.details["conditional"] for each in found} == {"one of several names"}


def test_what_is_done_to_one_of_several_ports_is_done_to_any(tmp_path: Path) -> None:
    body = """
    out_ = create_publisher<std_msgs::msg::String>(argc_ > 2 ? "one" : "two", 1);
    create_wall_timer(1s, [this]() { out_->publish(String()); });
"""
    _of(tmp_path, body)
    (node,) = read_source(tmp_path).nodes
    (timer,) = [each for each in node.callbacks if each.kind == "timer"]
    done = {(each.entity.name, each.when) for each in timer.effects if each.entity is not None}
    assert done == {("one", "conditional"), ("two", "conditional")}


def test_each_call_of_a_routine_makes_its_own_ports(tmp_path: Path) -> None:
    body = """
    hear("one"); hear("two");
    add(STATUS, "three");
    add(OTHER, "four");
    for (const Output & each : outputs_) {
      create_publisher<std_msgs::msg::String>(each.name, 1);
      init(each.kind, topic(each.kind));
    }
"""
    members = """
    enum Kind { STATUS, OTHER };
    struct Output { Kind kind; std::string name; };
    std::vector<Output> outputs_;
    void hear(const std::string & name) { create_publisher<std_msgs::msg::String>(name, 1); }
    void add(Kind kind, const std::string & name) {
      Output found;
      found.kind = kind;
      found.name = name;
      outputs_.push_back(found);
    }
    std::string topic(Kind kind) const {
      switch (kind) {
        case STATUS:
          return "status";
        case OTHER:
        default:
          return "rest";
      }
    }
    void init(Kind kind, const std::string & name) {
      switch (kind) {
        case STATUS: create_publisher<std_msgs::msg::String>(name + "/a", 1); break;
        case OTHER: create_publisher<std_msgs::msg::String>(name + "/b", 1);
        default: create_publisher<std_msgs::msg::String>(name + "/c", 1);
      }
    }
"""
    found = _of(tmp_path, body, members)
    assert [each.name for each in found] == ["one", "two", "three", "status/a", "four", "rest/b", "rest/c"]


def test_items_of_an_array_are_alternatives(tmp_path: Path) -> None:
    body = """
    const char * names[] = {"a", "b"};
    for (int i = 0; i < count_; ++i) { create_publisher<std_msgs::msg::String>(names[i], 1); }
    create_publisher<std_msgs::msg::String>(names[1], 1);
"""
    assert [each.name for each in _of(tmp_path, body, "int count_;")] == ["a", "b", "b"]


def test_a_switch_in_a_callback_is_open(tmp_path: Path) -> None:
    """A member that a node sets when it begins may have another value later."""
    body = "mode_ = 1; create_wall_timer(1s, [this]() { run(); });"
    members = """
    int mode_;
    void run() { switch (mode_) { case 1: one(); break; case 2: two(); } }
    void one() { create_publisher<std_msgs::msg::String>("one", 1); }
    void two() { create_publisher<std_msgs::msg::String>("two", 1); }
"""
    found = [each for each in _of(tmp_path, body, members) if each.kind == "publishers"]
    assert {each.name for each in found} == {"one", "two"}


def test_a_loop_by_number_turns_for_each_item_of_a_list_of_copies(tmp_path: Path) -> None:
    body = """
    Map map;
    map.name = "low";
    maps_.push_back(map);
    map.name = "high";
    maps_.push_back(map);
    for (size_t i = 0; i < maps_.size(); ++i) {
      outs_.push_back(create_publisher<std_msgs::msg::String>(maps_.at(i).name, 1));
    }
"""
    members = "struct Map { std::string name; };\n  typedef std::vector<Map> Maps;\n  Maps maps_;"
    assert [each.name for each in _of(tmp_path, body, members)] == ["low", "high"]


@pytest.mark.parametrize(
    "loop",
    [
        "for (size_t i = 0; i < names.size(); ++i) { if (i > 0) { break; } OUT }",
        "for (size_t i = 0; i < names.size(); ++i) { OUT i += names.size(); }",
        "for (size_t i = 0; i < names.size(); i += 2) { OUT }",
        "for (size_t i = 0; i < count; ++i) { OUT }",
    ],
)
def test_other_loops_by_number_are_not_turned_one_by_one(tmp_path: Path, loop: str) -> None:
    out = "create_publisher<std_msgs::msg::String>(names[i], 1);"
    found = _of(tmp_path, f'std::vector<std::string> names{{"a", "b"}};\n{loop.replace("OUT", out)}')
    assert [each.details.get("instances", "one") != "one" for each in found] == [True, True]
    assert [each.name for each in found] == ["a", "b"]


def test_parts_of_a_robot_are_those_of_its_parameter(tmp_path: Path) -> None:
    (tmp_path / "package.xml").write_text("<package><name>robots</name></package>", encoding="utf-8")
    (tmp_path / "robot.launch.py").write_text(
        "from launch import LaunchDescription\nfrom launch_ros.actions import Node\n\n\n"
        "def generate_launch_description():\n"
        "    return LaunchDescription([Node(package='robots', executable='robot', "
        "parameters=[{'arms': ['left', 'right']}])])\n",
        encoding="utf-8",
    )
    found = _of(
        tmp_path,
        'for (const auto & arm : declare_parameter("arms", std::vector<std::string>())) {\n'
        '  outs_.push_back(create_publisher<std_msgs::msg::String>(arm + "/state", 1));\n}',
    )
    assert [each.name for each in found] == ["left/state", "right/state"]


def test_a_wrapper_of_the_same_name_makes_ports_where_it_is_called(tmp_path: Path) -> None:
    base = """
class Base : public rclcpp::Node {
 public:
  explicit Base(const std::string & name) : Node(name) {}
  template<typename MessageT, typename CallbackT>
  auto create_subscription(const std::string & topic, CallbackT && callback, const rclcpp::QoS & qos = 5) {
    return vendor::create_subscription<MessageT>(
      shared_from_this(), topic, std::forward<CallbackT>(callback), qos);
  }
};
class Robot : public Base {
 public:
  Robot() : Base("robot") {
    in_ = create_subscription<std_msgs::msg::String>("in", [this](const std_msgs::msg::String & text) {
      RCLCPP_INFO(get_logger(), text.data); }, rclcpp::QoS(3));
  }
  rclcpp::Subscription<std_msgs::msg::String>::SharedPtr in_;
};
"""
    (found,) = _entities(tmp_path, base)
    assert (found.name, found.type, found.port) == ("in", "std_msgs/msg/String", "in_")
    assert (found.details["depth"], found.at.line) == (3, 17)
    assert not found.callbacks["callback"].is_open


def test_methods_of_a_nested_class_are_callbacks(tmp_path: Path) -> None:
    code = """
class Robot : public rclcpp::Node {
 public:
  Robot();
  struct Inner;
  Inner * inner_;
};
struct Robot::Inner {
  void onText(const String & text);
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr out;
};
Robot::Robot() : Node("robot") {
  inner_ = new Inner;
  inner_->out = create_publisher<std_msgs::msg::String>("out", 1);
  create_subscription<std_msgs::msg::String>("in", 1,
    std::bind(&Robot::Inner::onText, this->inner_, std::placeholders::_1));
}
void Robot::Inner::onText(const String & text) { out->publish(text); }
"""
    out, heard = _entities(tmp_path, code)
    assert [(each.do, each.entity) for each in heard.callbacks["callback"].effects] == [("publish", out)]


@pytest.mark.parametrize(
    ("written", "period"),
    [("int(pause * 1000)", 0.3), ("int(pause)", 0.0), ("int(vendor::pause())", None)],
)
def test_a_type_that_is_called_makes_a_number_of_it(
    tmp_path: Path, written: str, period: float | None
) -> None:
    (timer,) = _of(
        tmp_path,
        "double pause = 0.3;\n"
        f"create_wall_timer(std::chrono::milliseconds({written}), [this]() {{ onText(String()); }});",
    )
    found = timer.details["period"]
    assert is_open(found) if period is None else found == period


def test_a_node_that_a_library_makes_is_named(tmp_path: Path) -> None:
    body = """
    buffer_ = std::make_unique<tf2_ros::Buffer>(get_clock());
    listener_ = std::make_shared<tf2_ros::TransformListener>(*buffer_);
"""
    assert _of(tmp_path, body) == []
    (node,) = read_source(tmp_path).nodes
    ((place, words),) = node.others
    assert (place.file, place.line) == ("robot.cpp", 10)
    assert words.startswith("tf2_ros::TransformListener makes a node of its own")
    assert len(_of(tmp_path, body.replace("*buffer_", "*buffer_, this"))) == 2
    assert read_source(tmp_path).nodes[0].others == []


def test_functions_of_one_name_in_two_namespaces(tmp_path: Path) -> None:
    """As rmf_traffic_ros2: each program makes its node by a function ``make_node``."""
    for space in ("left", "right"):
        (tmp_path / f"{space}.cpp").write_text(
            f"""{HEAD}
namespace {space} {{
std::shared_ptr<rclcpp::Node> make_node(const rclcpp::NodeOptions & options) {{
  auto node = std::make_shared<rclcpp::Node>("{space}", options);
  static auto pub = node->create_publisher<String>("of_{space}", 1);
  return node;
}}
}}"""
        )
    (tmp_path / "main.cpp").write_text(
        f"{HEAD}int main() {{ rclcpp::init(0, nullptr); rclcpp::spin(right::make_node({{}})); }}"
    )
    facts = read_source(tmp_path)
    assert [node.name for node in facts.nodes] == ["right"]
    assert [each.name for each in facts.nodes[0].of("publishers")] == ["of_right"]


def test_constructors_that_call_each_other(tmp_path: Path) -> None:
    """As the schedule node of rmf_traffic_ros2: of two with as many parameters, the types decide."""
    robot = """
struct Store {};
struct Queries {};
struct Later {};
class Robot : public rclcpp::Node {
 public:
  Robot(Store store, int, Later) : Node("robot") {}
  Robot(Store store, Queries queries, int number) : Robot(number, "base") { makes("setup"); }
  Robot(int number, const char * name) : Robot(number, name, 2, 3) { makes(name); }
  Robot(int number, const char * name, int, int) : Robot(number, name, 2, 3, 4) {}
  Robot(int number, const char * name, int, int, int) : Node("robot") { makes("last"); }
  Robot() : Robot(Store(), Queries(), 1) {}
  void makes(const std::string & name) { pubs_.push_back(create_publisher<String>(name, 1)); }
  std::vector<rclcpp::Publisher<String>::SharedPtr> pubs_;
};
"""
    assert [each.name for each in _entities(tmp_path, robot)] == ["last", "base", "setup"]


@pytest.mark.parametrize(
    ("parameters", "argument", "made"),
    [
        (("const String &", "const std_msgs::msg::Bool &"), "text", "first"),
        (("const std_msgs::msg::Bool &", "const String &"), "text", "second"),
        (("std_msgs::msg::String", "String::SharedPtr"), "std::make_shared<String>(text)", None),
        (("String::ConstSharedPtr", "const String &"), "kept", "first"),
        (("std::shared_ptr<const String>", "const String &"), "*kept", "second"),
        (("const String *", "const String &"), "&text", "first"),
        (("const String &", "std_msgs::msg::Bool::UniquePtr"), "std::move(sent)", "second"),
        (("int", "const std::string &"), "3", "first"),
        (("double", "const std::string &"), '"front"', "second"),
        (("double", "bool"), "true", "second"),
        (("const std::string &", "double"), "member_", "second"),
        (("const String &", "const std_msgs::msg::Bool &"), "unknown()", None),
    ],
)
def test_overloads_are_chosen_by_the_types_of_arguments(
    tmp_path: Path, parameters: tuple[str, str], argument: str, made: str | None
) -> None:
    """Without a known type, each of them is possible."""
    functions = [
        f'void make(rclcpp::Node & node, {kind} a) {{ node.create_publisher<String>("{name}", 1); }}\n'
        for kind, name in zip(parameters, ("first", "second"), strict=True)
    ]
    methods = [each.replace("make(rclcpp::Node & node, ", "give(").replace("node.", "") for each in functions]
    head = (
        "void set(const String & text) { String::SharedPtr kept; std_msgs::msg::Bool::UniquePtr sent; CALL }"
    )
    for call, members in (("make(*this, {});", ""), ("give({});", "".join(methods))):
        text = f"double member_;\n{members}" + head.replace("CALL", call.format(argument))
        found = _of(tmp_path, "set(String());", text, "" if members else "".join(functions))
        assert [each.name for each in found] == ([made] if made else ["first", "second"])


@pytest.mark.parametrize(
    ("makes", "calls", "member"),
    [
        ('calls_["a"] = [this] { send(); };', "auto it = calls_.find(key); it->second();", ""),
        ('calls_.emplace("a", [this] { send(); });', "calls_.at(key)();", ""),
        ('calls_["a"] = std::bind(&Robot::send, this);', "for (auto & [k, call] : calls_) { call(); }", ""),
        ("", "(this->*state_)();", "using State = void (Robot::*)(); State state_ = &Robot::send;"),
        ("state_ = &Robot::send;", "(this->*state_)();", "using State = void (Robot::*)(); State state_;"),
    ],
)
def test_functions_that_members_hold_are_followed(
    tmp_path: Path, makes: str, calls: str, member: str
) -> None:
    body = (
        f'pub_ = create_publisher<String>("out", 1); {makes}\n'
        + """
      sub_ = create_subscription<String>("in", 1, [this](const String & text) { onText(text); run("a"); });"""
    )
    members = f"""void send() {{ pub_->publish(String()); }}
      void run(const std::string & key) {{ {calls} }}
      rclcpp::Publisher<String>::SharedPtr pub_;
      rclcpp::Subscription<String>::SharedPtr sub_;
      std::map<std::string, std::function<void()>> calls_;
      {member}"""
    _of(tmp_path, body, members)
    (node,) = read_source(tmp_path).nodes
    (found,) = [each for each in node.callbacks if each.kind == "subscription"]
    assert [each.do for each in found.effects if each.do == "publish"] == ["publish"]
