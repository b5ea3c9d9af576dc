"""A token game on a net: forward and backward, with chosen or random firings."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from random import Random

from dineros.analysis.model.subject import Subject
from dineros.metamodel.editing import CommandError

MOST_STEPS = 100_000
"""Limit of the steps of one game."""


class Game:
    """A marking of a net, with the firings before and after it.

    Parameters
    ----------
    subject : Subject
        The flattened net, with its trace links to the model.
    steps : sequence of int
        Transitions that can be fired one after the other, as a witness has them.
    loop : int or None
        From which step on they repeat forever.
    title : str
        What is played; empty: a game by hand.

    Attributes
    ----------
    at : int
        How many of the steps are fired.
    marking : list of int
        Tokens by place, in the order of the net.

    Raises
    ------
    CommandError
        A step cannot be fired when it is its turn, or there are too many.
    """

    def __init__(
        self, subject: Subject, steps: Sequence[int] = (), loop: int | None = None, title: str = ""
    ) -> None:
        if len(steps) > MOST_STEPS:
            raise CommandError(
                f"has more than {MOST_STEPS:,} steps", hint="use dineros trace to show long traces"
            )
        self.subject, self.loop, self.title = subject, loop, title
        self.steps: list[int] = list(steps)
        self.at = 0
        self.marking: list[int] = subject.net.initial.tolist()
        for number, transition in enumerate(steps, 1):
            if not subject.net.is_enabled(transition, self.marking):
                step = subject.transition_text(transition)
                raise CommandError(f"step {number}, {step!r}, cannot be fired on this model")
            self._change(transition, 1)
        self.marking = subject.net.initial.tolist()

    def enabled(self) -> list[int]:
        """Return the transitions that can be fired now."""
        net = self.subject.net
        return [each for each in range(len(net.transitions)) if net.is_enabled(each, self.marking)]

    def fire(self, transition: int) -> None:
        """Fire a transition; later steps are discarded unless this is the first of them.

        Raises
        ------
        CommandError
            It is not enabled, or the game is too long.
        """
        if not self.subject.net.is_enabled(transition, self.marking):
            raise CommandError(f"{self.subject.transition_text(transition)!r} is not enabled")
        if self.at < len(self.steps) and self.steps[self.at] == transition:
            self.go(self.at + 1)
            return
        if self.at >= MOST_STEPS:
            raise CommandError(f"the game has {MOST_STEPS:,} steps", hint="begin another one")
        del self.steps[self.at :]
        self.loop, self.title = None, ""
        self.steps.append(transition)
        self._change(transition, 1)
        self.at += 1

    def go(self, position: int) -> None:
        """Go forward or back along the steps.

        Raises
        ------
        CommandError
            There are fewer steps.
        """
        if not 0 <= position <= len(self.steps):
            raise CommandError(f"the game has {len(self.steps)} steps")
        while self.at < position:
            self._change(self.steps[self.at], 1)
            self.at += 1
        while self.at > position:
            self.at -= 1
            self._change(self.steps[self.at], -1)

    def wander(self, count: int, draw: Random, outside: Collection[int] = ()) -> int:
        """Fire enabled transitions at random with equal probability; return their number.

        Parameters
        ----------
        count : int
            The largest number; there are fewer in a deadlock.
        draw : Random
            The generator.
        outside : collection of int
            Transitions that are fired only where no other is enabled: changes of signals.
        """
        for fired in range(count):
            enabled = self.enabled()
            choices = [each for each in enabled if each not in outside] or enabled
            if not choices:
                return fired
            self.fire(draw.choice(choices))
        return count

    def _change(self, transition: int, sign: int) -> None:
        for place, tokens in self.subject.net.delta[transition].items():
            self.marking[place] += sign * tokens
