"""The causal past of an outcome: the firings of a sequence that brought it about, token by token.

A firing depends on those that made the tokens it takes or reads, and on those that emptied its inhibitor
places. Which token of a place is taken is not defined; here, the oldest one is. Firings outside the causal
past of an outcome can be left out: the rest can still be fired, and the outcome is the same.

References
----------
W. Reisig, *Understanding Petri Nets*, Springer 2013, ch. 4 (distributed runs). M. Weiser, *Program slicing*,
IEEE TSE 10(4), 1984.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from dineros.analysis.nets.compiled import CompiledNet

_INITIAL = -1


@dataclass(frozen=True)
class TokenNeed:
    """Condition that a place holds enough tokens, or no more than it did, at a position of a sequence.

    Attributes
    ----------
    position : int
        How many firings have been before.
    bound : {"at least", "at most"}
        At least: the tokens that were there stay there. At most: none is there that was not.
    tokens : int or None
        At least so many, the oldest; None for all that were there.
    """

    place: int
    position: int
    bound: Literal["at least", "at most"]
    tokens: int | None = None


class CausalPast:
    """Follows the tokens of a firing sequence.

    Parameters
    ----------
    sequence : sequence of int
        Transitions, from the initial marking; each is enabled when it is its turn.
    """

    def __init__(self, net: CompiledNet, sequence: Sequence[int]) -> None:
        self.net = net
        self.sequence = sequence
        self.maker: list[int] = []  # of each token: the firing that made it
        self.taker: list[int] = []  # and that took it; after the end where none did
        self.uses: list[list[int]] = []  # of each firing: the tokens it takes and reads
        self.made: list[list[int]] = []
        self.taken_at: dict[int, list[int]] = {}  # of each place: tokens in the order they are taken
        self._at: dict[int, list[int]] = {}  # of each place: the tokens made, and those taken from the start
        self._follow()

    def _follow(self) -> None:
        net, end = self.net, len(self.sequence)
        waiting: defaultdict[int, deque[int]] = defaultdict(deque)
        initial = net.initial.tolist()
        rows = {t: (net.pre.row(t), dict(net.post.row(t))) for t in set(self.sequence)}
        for step, t in enumerate(self.sequence):
            inputs, outputs = rows[t]
            uses: list[int] = []
            left = dict(outputs)
            for place, weight in inputs:
                read = min(weight, outputs.get(place, 0))
                for _ in range(weight - read):
                    if initial[place]:  # made one by one: a place may begin with a million
                        initial[place] -= 1
                        token = self._new(place, _INITIAL, end)
                    else:
                        token = waiting[place].popleft()
                    self.taker[token] = step
                    self.taken_at.setdefault(place, []).append(token)
                    uses.append(token)
                # A token that is read stays what it is.
                uses += [waiting[place][i] for i in range(max(0, read - initial[place]))]
                left[place] = outputs.get(place, 0) - read
            made = []
            for place, weight in left.items():
                for _ in range(weight):
                    made.append(self._new(place, step, end))
                    waiting[place].append(made[-1])
            self.uses.append(uses)
            self.made.append(made)

    def _new(self, place: int, maker: int, end: int) -> int:
        self.maker.append(maker)
        self.taker.append(end)
        self._at.setdefault(place, []).append(len(self.maker) - 1)
        return len(self.maker) - 1

    def of(self, needs: Iterable[TokenNeed], firings: Iterable[int] = ()) -> list[int]:
        """Return the causal past of conditions and firings.

        Parameters
        ----------
        needs : iterable of TokenNeed
            What is to be as it was.
        firings : iterable of int
            Positions in the sequence of firings that are to happen.

        Returns
        -------
        list of int
            Positions in the sequence, ascending. Firing these alone is possible. At the place of a position
            of the whole sequence in it, what the needs say is true.

        Examples
        --------
        >>> from dineros.analysis.nets.compiled import CompiledNet
        >>> net = CompiledNet.build({"a": 1, "b": 1, "c": 0}, [("t", {"a": 1}, {"c": 1}), ("u", {"b": 1})])
        >>> CausalPast(net, [1, 0]).of([TokenNeed(place=2, position=2, bound="at least")])
        [1]
        """
        search = _PastSearch(self)
        for firing in firings:
            search.need(firing)
        for need in needs:
            if need.bound == "at most":
                search.limit(need.place, need.position)
                continue
            for maker in self._makers(need):
                search.need(maker)
        return search.run()

    def _makers(self, need: TokenNeed) -> list[int]:
        """Return which firings made the tokens that are to be there; none for those there from the start."""
        tokens = self._at.get(need.place, [])
        initial = int(self.net.initial[need.place])
        taken = sum(self.maker[t] == _INITIAL and self.taker[t] < need.position for t in tokens)
        makers = [
            self.maker[t]
            for t in tokens
            if _INITIAL < self.maker[t] < need.position and self.taker[t] >= need.position
        ]
        if need.tokens is None:
            return makers
        return makers[: max(0, need.tokens - (initial - taken))]


class _PastSearch:
    """The firings needed so far, and what they need in turn."""

    def __init__(self, past: CausalPast) -> None:
        self._past = past
        self._place_of = {token: place for place, tokens in past.taken_at.items() for token in tokens}
        self._found: set[int] = set()
        self._todo: list[int] = []
        self._limits: dict[int, int] = {}  # of a place: up to where what was taken has to be taken
        self._seen: dict[int, int] = {}  # of a place: how many of the tokens taken were looked at

    def need(self, firing: int) -> None:
        if firing not in self._found:
            self._found.add(firing)
            self._todo.append(firing)

    def limit(self, place: int, position: int) -> None:
        """Let a place hold no token, at a position, that it did not hold: who took some is needed."""
        if position <= self._limits.get(place, 0):
            return
        self._limits[place] = position
        past, at = self._past, self._seen.get(place, 0)
        tokens = past.taken_at.get(place, [])
        while at < len(tokens) and past.taker[tokens[at]] < position:
            if past.maker[tokens[at]] == _INITIAL or past.maker[tokens[at]] in self._found:
                self.need(past.taker[tokens[at]])
            at += 1
        self._seen[place] = at

    def run(self) -> list[int]:
        past = self._past
        while self._todo:
            firing = self._todo.pop()
            for token in past.uses[firing]:
                if past.maker[token] != _INITIAL:
                    self.need(past.maker[token])
            for place, _ in past.net.inhibitor.row(past.sequence[firing]):
                self.limit(place, firing)
            for token in past.made[firing]:
                taken_from = self._place_of.get(token)  # None: it is never taken
                if taken_from is not None and past.taker[token] < self._limits.get(taken_from, 0):
                    self.need(past.taker[token])
        return sorted(self._found)
