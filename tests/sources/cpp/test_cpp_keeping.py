"""Programs in C++ that are kept from run to run: the same facts as without, also after edits and damage."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import random
import re
from pathlib import Path
from typing import Any

import pytest

from dineros.sources.cpp.keeping import Keeper
from dineros.sources.facts import NodeFact
from dineros.sources.keeping.graphs import to_plain
from dineros.sources.reading import read_source
from tests.sources.support import WORD, edit_a_line

pytest.importorskip("tree_sitter_cpp")

FILES = {
    "common.hpp": """
#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/string.hpp>
constexpr double RATE = 10.0;
using Text = std_msgs::msg::String;
inline std::string topic_of(const std::string & name) { return name + "/out"; }
class Base : public rclcpp::Node {
 public:
  explicit Base(const std::string & name) : rclcpp::Node(name) {
    pub_ = create_publisher<Text>(topic_of(name), 10);
  }
  void say();
 protected:
  rclcpp::Publisher<Text>::SharedPtr pub_;
};
""",
    "common.cpp": """
#include "common.hpp"
void Base::say() { Text text; pub_->publish(text); }
""",
    "a.cpp": """
#include "common.hpp"
class A : public Base {
 public:
  A() : Base("a") {
    timer_ = create_wall_timer(std::chrono::duration<double>(1.0 / RATE), [this]() { say(); });
  }
  rclcpp::TimerBase::SharedPtr timer_;
};
int main() { rclcpp::init(0, nullptr); rclcpp::spin(std::make_shared<A>()); }
""",
    "b.cpp": """
#include "common.hpp"
class B : public rclcpp::Node {
 public:
  B() : rclcpp::Node("b") {
    sub_ = create_subscription<Text>("a/out", 5, [this](Text::SharedPtr text) { heard(); });
  }
  void heard() { std::this_thread::sleep_for(std::chrono::milliseconds(5)); }
  rclcpp::Subscription<Text>::SharedPtr sub_;
};
int main() { rclcpp::init(0, nullptr); rclcpp::spin(std::make_shared<B>()); }
""",
}
EDITS = {
    "a constant of another file": ("common.hpp", "RATE = 10.0", "RATE = 20.0"),
    "a method that stands elsewhere": (
        "common.cpp",
        "pub_->publish(text);",
        "pub_->publish(text); rclcpp::shutdown();",
    ),
    "an alias": ("common.hpp", "std_msgs::msg::String;", "std_msgs::msg::Bool;"),
    "a function": ("common.hpp", '"/out"', '"/in"'),
    "a base class": ("common.hpp", "topic_of(name), 10", "topic_of(name), 3"),
    "lines": ("common.cpp", "#include", "\n\n#include"),
    "a program": ("b.cpp", '"a/out", 5', '"a/out", 7'),
}


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    folder = tmp_path / "code"
    folder.mkdir()
    for name, text in FILES.items():
        (folder / name).write_text(text)
    return folder


def facts(folder: Path, cache: Path | None = None) -> str:
    """Return all facts, with the branches of callbacks, which the schema of the facts does not show."""
    found = read_source(folder, cache=cache)
    return json.dumps([found.to_json(), to_plain(found.nodes)])


def count(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Return a list that gets, for each program, whether it was kept."""
    found: list[bool] = []
    load = Keeper.load

    def noted(self: Keeper, program: Any) -> Any:
        result = load(self, program)
        found.append(result is not None)
        return result

    monkeypatch.setattr(Keeper, "load", noted)
    return found


def test_what_has_not_changed_is_not_followed_again(workspace: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache, was_kept = workspace.parent / "cache", count(monkeypatch)
    first = facts(workspace, cache)
    assert first == facts(workspace) == facts(workspace, cache)
    assert was_kept == [False, False, True, True]
    assert oct(cache.stat().st_mode)[-3:] == "700"


BRANCHES = """
#include <rclcpp/rclcpp.hpp>
#include <std_srvs/srv/set_bool.hpp>
using Switch = std_srvs::srv::SetBool;
class Both : public rclcpp::Node {
 public:
  Both() : rclcpp::Node("both") {
    client_ = create_client<Switch>("ask");
    service_ = create_service<Switch>("serve", std::bind(&Both::serve, this, _1, _2));
    publisher_ = create_publisher<std_msgs::msg::String>("done", 10);
    timer_ = create_wall_timer(std::chrono::seconds(1), [this]() { ask(); });
  }
  void ask() {
    client_->async_send_request(std::make_shared<Switch::Request>(),
      [this](rclcpp::Client<Switch>::SharedFuture future) {
        auto response = future.get();
        if (response->success && !busy_) {
          publisher_->publish(std_msgs::msg::String());
        } else {
          for (int i = 0; i < count_; ++i) { client_->wait_for_service(std::chrono::seconds(1)); }
        }
      });
  }
  void serve(const std::shared_ptr<Switch::Request> request, std::shared_ptr<Switch::Response> response) {
    if (request->data) { response->success = true; return; }
    response->success = false;
  }
  rclcpp::Client<Switch>::SharedPtr client_;
  rclcpp::Service<Switch>::SharedPtr service_;
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr publisher_;
  rclcpp::TimerBase::SharedPtr timer_;
  bool busy_;
  int count_;
};
int main() { rclcpp::init(0, nullptr); rclcpp::spin(std::make_shared<Both>()); }
"""
PLAIN = """
#include <rclcpp/rclcpp.hpp>
int main() {
  rclcpp::init(0, nullptr);
  auto node = rclcpp::Node::make_shared("plain");
  auto publisher = node->create_publisher<std_msgs::msg::String>("plain", 10);
  rclcpp::spin(node);
}
"""


def test_branches_and_nodes_without_a_class_are_kept(
    workspace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache, was_kept = workspace.parent / "cache", count(monkeypatch)
    for each in FILES:
        (workspace / each).unlink()
    (workspace / "both.cpp").write_text(BRANCHES)
    (workspace / "plain.cpp").write_text(PLAIN)
    first = facts(workspace, cache)
    assert first == facts(workspace) == facts(workspace, cache)
    assert was_kept == [False, False, True, True]
    assert all(f'"{each}"' in first for each in ("Answered", "Give", "Branch", "Joined", "Loop"))


@pytest.mark.parametrize("edit", EDITS)
def test_an_edit_counts_at_once(workspace: Path, edit: str, monkeypatch: pytest.MonkeyPatch) -> None:
    cache = workspace.parent / "cache"
    before = facts(workspace, cache)
    name, old, new = EDITS[edit]
    text = (workspace / name).read_text()
    assert old in text
    (workspace / name).write_text(text.replace(old, new, 1))
    was_kept = count(monkeypatch)
    after = facts(workspace, cache)
    assert after == facts(workspace) != before
    assert was_kept == ([True, False] if name == "b.cpp" else [False, name == "common.cpp"])


def test_a_new_file_that_gives_a_name_another_meaning_counts(workspace: Path) -> None:
    cache = workspace.parent / "cache"
    facts(workspace, cache)
    (workspace / "more.hpp").write_text("class Base { public: int other() { return 1; } };\n")
    (workspace / "sleeps.cpp").write_text("void heard() {}\n#define RATE 5.0\n")
    assert facts(workspace, cache) == facts(workspace)
    (workspace / "common.cpp").unlink()
    assert facts(workspace, cache) == facts(workspace)


def test_tables_and_places_are_part_of_the_key(workspace: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache, was_kept = workspace.parent / "cache", count(monkeypatch)
    facts(workspace, cache)
    table = workspace.parent / "own.toml"
    table.write_text('[[idiom]]\npath = "lib::Any"\narguments = ["node"]\n')
    read_source(workspace, [table], cache=cache)
    monkeypatch.setattr("dineros.sources.cpp.keeping.reader_digest", lambda: "another reader")
    facts(workspace, cache)
    assert was_kept == [False] * 6


def test_random_edits_never_give_stale_facts(workspace: Path) -> None:
    """A cache that is full of earlier states against none, with a fixed seed."""
    cache, random_ = workspace.parent / "cache", random.Random(7)
    words = sorted({word for text in FILES.values() for word in re.findall(WORD, text)})
    for _ in range(25):
        edit_a_line(workspace / random_.choice(sorted(FILES)), words, random_)
        assert facts(workspace, cache) == facts(workspace)


@pytest.mark.parametrize(
    "damage", ["cut", "other", "empty", "link", "folder", "forged", "deep", "huge number", "body"]
)
def test_a_damaged_entry_is_ignored(workspace: Path, damage: str) -> None:
    cache = workspace.parent / "cache"
    (workspace / "b.cpp").write_text(BRANCHES)
    right = facts(workspace, cache)
    for entry in sorted(cache.iterdir()):
        content = entry.read_bytes()
        if damage == "cut":
            entry.write_bytes(content[: len(content) // 2])
        elif damage == "other":
            entry.write_bytes(b"\x80\x04cposix\nsystem\n")
        elif damage == "empty":
            entry.write_bytes(b"")
        elif damage in ("link", "folder"):
            entry.unlink()
            entry.symlink_to("/dev/zero") if damage == "link" else entry.mkdir()
        else:
            entry.write_bytes(_forged(content, damage))
    assert facts(workspace, cache) == right


def _forged(content: bytes, how: str) -> bytes:
    """Return an entry with a right hash whose facts have another shape."""
    entry = json.loads(content.partition(b"\n")[2])
    _, node, *rows = entry["facts"]
    at = {each.name: number for number, each in enumerate(dataclasses.fields(NodeFact), start=1)}
    if how == "forged":
        node[at["entities"]] = ["list", ["object", -1], True, ["object", 10**6]]
    elif how == "body":
        for row in rows:
            if row[0] == "CallbackFact":
                row[-2] = ["list", ["object", 0], ["object", 7]]
    elif how == "huge number":
        node[at["pool"]] = 1e308
    else:
        node[at["entities"]] = json.loads("[" * 60 + "]" * 60)
    text = json.dumps(entry).encode()
    return hashlib.sha256(text).hexdigest().encode() + b"\n" + text


def test_a_folder_that_others_may_change_is_not_used(
    workspace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache, was_kept = workspace.parent / "cache", count(monkeypatch)
    cache.mkdir()
    cache.chmod(0o777)
    assert facts(workspace, cache) == facts(workspace, cache)
    assert was_kept == [False] * 4 and [*cache.iterdir()] == []
    (workspace.parent / "file").write_text("")
    assert facts(workspace, workspace.parent / "file") == facts(workspace)


def test_a_link_in_the_cache_is_not_written_through(workspace: Path) -> None:
    cache, other = workspace.parent / "cache", workspace.parent / "other"
    (workspace / "b.cpp").write_text(BRANCHES)
    right = facts(workspace, cache)
    other.write_text("of the user")
    for entry in sorted(cache.iterdir()):
        entry.unlink()
        entry.symlink_to(other)
    assert facts(workspace, cache) == right
    assert other.read_text() == "of the user"
