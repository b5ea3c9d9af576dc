"""The simulated cell, without any net."""

from __future__ import annotations

from sorting_cell.world import Visit, World

Change = tuple[str, str, bool]


def run(world: World, seconds: float, step: float = 0.05) -> None:
    for _ in range(round(seconds / step)):
        world.advance(step)


def make(**options: object) -> tuple[World, list[Change]]:
    changes: list[Change] = []
    world = World(lambda node, signal, value: changes.append((node, signal, value)), **options)  # type: ignore[arg-type]
    return world, changes


def test_it_tells_all_signals_when_it_begins() -> None:
    """Nodes that continue may remember those of an earlier cell: that there is danger, say."""
    world, changes = make()
    world.start()
    told = {(node, signal): value for node, signal, value in changes}
    assert {name for name, value in told.items() if value} == {
        ("executor", "RobotIsIdle"),
        ("sensorics", "Sensor"),
    }
    assert told["executor", "Danger"] is False
    assert {signal for node, signal in told if node == "selector"} == {"Red", "Blue", "Green"}


def test_a_motion_shows_its_result_before_its_end() -> None:
    world, changes = make(colors=())
    world.start()
    world.command("pick", "red-1")
    run(world, 1)
    assert changes[-2:] == [
        ("executor", "ObjectIsPicked", True),
        ("executor", "RobotHasFinished", True),
    ]


def test_a_new_motion_takes_back_the_result_before_anything_else() -> None:
    world, changes = make(colors=())
    world.command("pick", "red-1")
    run(world, 1)
    changes.clear()
    world.command("place", "red-1")
    assert changes[0] == ("executor", "ObjectIsPlaced", False)
    run(world, 1)
    assert world.placed == ["red-1"]


def test_the_arm_rests_while_the_human_is_inside() -> None:
    world, changes = make(colors=(), visits=[Visit(motion=1, after=0.1, stay=2.0)])
    world.command("pick", "red-1")
    run(world, 1.5)
    inside = world.is_human_inside
    assert inside
    assert ("executor", "Danger", True) in changes
    assert ("executor", "RobotHasFinished", True) not in changes
    run(world, 2)
    assert not world.is_human_inside
    assert changes[-1] == ("executor", "RobotHasFinished", True)


def test_an_object_whose_pick_was_given_up_is_fetched_when_it_is_placed() -> None:
    world, _ = make(colors=(), motion_time=1.0)
    world.command("pick", "red-1")
    world.abort()
    world.command("place", "red-1")
    run(world, 1.5)
    assert world.placed == []
    run(world, 1)
    assert world.placed == ["red-1"]
    assert world.aborted == 1


def test_each_button_is_pressed_and_let_go() -> None:
    world, changes = make(colors=("Red", "Green"), press_time=1.0)
    run(world, 5.5)
    assert changes == [
        ("selector", color, value) for color in ("Red", "Green", "Red") for value in (True, False)
    ]
