"""What a CMakeLists.txt builds and installs."""

from __future__ import annotations

from dineros.sources.cmake import LONGEST_WORD, MOST_VALUES, Component, read_cmake

TEXT = """
cmake_minimum_required(VERSION 3.8)
project(robot)  # add_executable(not_this src/not_this.cpp)
#[[ add_executable(nor_this src/nor_this.cpp) ]]
set(SOURCES src/main.cpp "src/help er.cpp")
add_executable(${PROJECT_NAME}_node ${SOURCES})
target_sources(robot_node PRIVATE src/more.cpp)
ament_auto_add_executable(other src/other.cpp)
rclcpp_components_register_node(robot_core
  PLUGIN "robot::Driver"
  EXECUTABLE driver
  EXECUTOR MultiThreadedExecutor)
rclcpp_components_register_nodes(robot_core "robot::Arm" robot::Hand)
install(PROGRAMS scripts/teleop.py ${OTHER}/no.py DESTINATION lib/${PROJECT_NAME})
"""


def test_programs_components_and_scripts_are_read() -> None:
    built = read_cmake(TEXT)
    assert built.sources == {
        "robot_node": ["src/main.cpp", "src/help er.cpp", "src/more.cpp"],
        "other": ["src/other.cpp"],
    }
    assert built.components == [
        Component("robot::Driver", "driver", "MultiThreadedExecutor"),
        Component("robot::Arm"),
        Component("robot::Hand"),
    ]
    assert built.scripts == ["scripts/teleop.py"]


def test_what_is_not_known_stays_as_it_is_written() -> None:
    built = read_cmake('add_executable(node ${FILES} "${DIR}/main.cpp")')
    assert built.sources == {"node": ["${FILES}", "${DIR}/main.cpp"]}


def test_variables_that_double_stay_small() -> None:
    text = 'set(A "xy")' + 'set(A "${A}${A}")' * 200 + "set(B ${A} ${A})" + "set(B ${B} ${B})" * 200
    built = read_cmake(f"{text} add_executable(node ${{A}}.cpp ${{B}})")
    assert sum(map(len, built.sources["node"])) <= (MOST_VALUES + 1) * LONGEST_WORD


def test_broken_text_gives_what_can_be_read() -> None:
    assert read_cmake("add_executable(node src/main.cpp").sources == {}
    assert read_cmake("project() add_executable() set() install(").sources == {}
