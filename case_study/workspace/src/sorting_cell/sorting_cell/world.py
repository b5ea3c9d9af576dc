"""The simulated cell: two arms, a human who walks in and out, a sensor, and a user who asks for objects.

The world knows nothing of Petri nets or ROS: it takes commands for its arms and says which input signals
change. Time is what `advance` is told, so that tests need not wait.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal

Operation = Literal["pick", "place"]
SetSignal = Callable[[str, str, bool], None]
"""Takes the node net, the input signal and its value."""

DONE_SIGNAL: dict[Operation, str] = {"pick": "ObjectIsPicked", "place": "ObjectIsPlaced"}


@dataclass(frozen=True)
class Visit:
    """A human who walks in while an arm moves.

    Attributes
    ----------
    motion : int
        Number of the motion, from 1, that is interrupted.
    after : float
        Seconds between the start of the motion and the human's first step into the cell.
    stay : float
        Seconds in the cell.
    """

    motion: int
    after: float
    stay: float


@dataclass
class _Motion:
    number: int
    operation: Operation
    object: str
    left: float


@dataclass
class World:
    """The state of the cell.

    Parameters
    ----------
    set_signal : callable
        Called for each signal that changes; a finished motion is never shown without its result.
    colors : sequence of str
        Colours the user asks for in turn, again and again.
    visits : sequence of Visit
        When the human walks in.
    motion_time : float
        Seconds an arm needs for a pick or a place.
    press_time : float
        Seconds between two changes of a button.
    """

    set_signal: SetSignal
    colors: Sequence[str] = ("Red", "Blue", "Green")
    visits: Sequence[Visit] = ()
    motion_time: float = 0.4
    press_time: float = 0.3
    log: Callable[[str], None] = lambda line: None
    is_human_inside: bool = False
    placed: list[str] = field(default_factory=list)
    aborted: int = 0
    _motion: _Motion | None = None
    _held: str | None = None
    _motions: int = 0
    _now: float = 0.0
    _leave_at: float | None = None
    _enter_at: tuple[float, float] | None = None
    _next_press: float = 0.0
    _presses: int = 0

    def start(self) -> None:
        """Tell all signals: the arm rests, the sensor measures, nobody is there and presses nothing.

        Nodes that continue after a restart may have seen other values of an earlier cell.
        """
        for name in ("ObjectIsPicked", "ObjectIsPlaced", "RobotHasFinished", "Danger"):
            self.set_signal("executor", name, False)
        self.set_signal("executor", "RobotIsIdle", True)
        self.set_signal("sensorics", "Sensor", True)
        for color in self.colors:
            self.set_signal("selector", color, False)

    def command(self, operation: Operation, name: str) -> None:
        """Start a motion; an object that is to be placed and was not picked before is fetched first.

        A command that comes again, from a node that was restarted, changes nothing while the arm moves.
        """
        if self._motion is not None and (self._motion.operation, self._motion.object) == (operation, name):
            return
        self._motions += 1
        self.set_signal("executor", DONE_SIGNAL[operation], False)
        self.set_signal("executor", "RobotHasFinished", False)
        self.set_signal("executor", "RobotIsIdle", False)
        is_held = self._held == name
        seconds = self.motion_time * {"pick": 0 if is_held else 1, "place": 1 if is_held else 2}[operation]
        self._motion = _Motion(self._motions, operation, name, seconds)
        self.log(f"arm starts to {operation} {name}")
        for visit in self.visits:
            if visit.motion == self._motions:
                self._enter_at = (self._now + visit.after, visit.stay)

    def abort(self) -> None:
        """Stop the motion for good; the arm rests."""
        if self._motion is not None:
            self.aborted += 1
            self.log(f"arm gives up to {self._motion.operation} {self._motion.object}")
        self._motion = None
        self.set_signal("executor", "RobotHasFinished", False)
        self.set_signal("executor", "RobotIsIdle", True)

    def advance(self, seconds: float) -> None:
        """Let time pass."""
        self._now += seconds
        self._walk()
        if self._motion is not None and not self.is_human_inside:  # the arm itself stops for a human
            self._motion.left -= seconds
            if self._motion.left <= 0:
                self._finish(self._motion)
        self._press()

    def _walk(self) -> None:
        if self._enter_at is not None and self._now >= self._enter_at[0]:
            self._leave_at, self._enter_at = self._now + self._enter_at[1], None
            self.is_human_inside = True
            self.log("human walks in")
            self.set_signal("executor", "Danger", True)
        elif self._leave_at is not None and self._now >= self._leave_at:
            self._leave_at = None
            self.is_human_inside = False
            self.log("human walks out")
            self.set_signal("executor", "Danger", False)

    def _finish(self, motion: _Motion) -> None:
        self._motion = None
        if motion.operation == "pick":
            self._held = motion.object
        else:
            self._held = None
            self.placed.append(motion.object)
        self.log(f"arm has {'picked' if motion.operation == 'pick' else 'placed'} {motion.object}")
        # First the result, then that there is one: in between neither success nor failure can be seen.
        self.set_signal("executor", DONE_SIGNAL[motion.operation], True)
        self.set_signal("executor", "RobotHasFinished", True)

    def _press(self) -> None:
        """Press the buttons in turn, again and again: down, up, the next one down."""
        if self.colors and self._now >= self._next_press:
            color, is_down = self.colors[self._presses // 2 % len(self.colors)], self._presses % 2 == 0
            self.set_signal("selector", color, is_down)
            self._presses += 1
            self._next_press = self._now + self.press_time
