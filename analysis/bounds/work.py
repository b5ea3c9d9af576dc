"""What one run of a callback does: how long it works, what it publishes, and that it always ends.

A bound of times holds only if no run of a callback can get stuck. A run is explored with all orders of its
steps. Places that other callbacks or nodes change may hold anything, so at each moment of the run one step
must be possible whatever they hold: it has no guard, and needs only tokens of the run itself, and places that
no firing changes. Or several steps have guards, one of which always holds. Or the steps that are left need a
token of one of several places, which form a marked trap: each firing that takes from them puts a token there,
so that one of them is always marked (T. Murata, Proc. IEEE 77(4), 1989, Sect. VI).
"""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass, field
from fractions import Fraction

from dineros.analysis.bounds.branching import is_complete
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import callback_page_of
from dineros.metamodel.elements import arcs, label, resolve, transitions
from dineros.metamodel.times.given import duration_of, runs_at_once, waits
from dineros.metamodel.times.rates import seconds_of
from dineros.metamodel.times.runs import places_of_ports

MOST_STATES = 500
"""Largest number of markings of one run that are explored."""


class NotBoundedError(Exception):
    """No bound exists; the message gives the reason in the terms of the model."""


@dataclass(frozen=True)
class Publishing:
    """How often a run publishes by a port at least and at most, and whether it does so only when it ends."""

    fewest: int
    most: int
    only_at_end: bool


@dataclass(frozen=True)
class Work:
    """What one run does."""

    least: Fraction
    most: Fraction
    """`least`, `most`: seconds from its beginning to its end."""
    publishes: dict[pn.Place, Publishing]
    """By place of a publisher."""


class _KeptError(Exception):
    """Places of a callback hold something else when it ends."""

    def __init__(self, places: set[pn.Place]) -> None:
        super().__init__()
        self.places = places


@dataclass
class _WorkMove:
    takes: Counter[pn.Place] = field(default_factory=Counter)
    reads: Counter[pn.Place] = field(default_factory=Counter)
    puts: Counter[pn.Place] = field(default_factory=Counter)
    inhibits: bool = False

    def effect(self, place: pn.Place) -> int:
        return self.puts[place] - self.takes[place]

    def needs(self, place: pn.Place) -> int:
        return max(self.takes[place], self.reads[place])


class Works:
    """Describes what runs of callbacks do."""

    def __init__(self, model: sym.SystemModel) -> None:
        self.model = model
        self.moves = {each: _WorkMove() for each in transitions(model)}
        for arc in arcs(model):
            source, target = resolve(arc.source), resolve(arc.target)
            if isinstance(source, pn.Transition) and isinstance(target, pn.Place):
                self.moves[source].puts[target] += arc.weight
            elif isinstance(target, pn.Transition) and isinstance(source, pn.Place):
                move = self.moves[target]
                match arc.kind:
                    case pn.ArcKind.normal:
                        move.takes[source] += arc.weight
                    case pn.ArcKind.read:
                        move.reads[source] = max(move.reads[source], arc.weight)
                    case _:
                        move.inhibits = True
        self.around: dict[pn.Place, list[pn.Transition]] = defaultdict(list)
        for transition, move in self.moves.items():
            for place in {*move.takes, *move.reads, *move.puts}:
                self.around[place].append(transition)
        self.ports = places_of_ports(model)
        self.starts = {
            start
            for page in model.eAllContents()
            if isinstance(page, sym.CallbackPage) and page.kind == sym.CallbackKind.timer
            for start in Body(page).beginnings()
        }
        self.overridden = {under for each in self.moves for under in each.overrides} | {
            each for each in self.moves if each.overrides
        }

    def is_steady(self, place: pn.Place) -> bool:
        """Return whether no firing changes a place, not even for the time of a run.

        The callback of a timer takes what its first transition needs before that fires.
        """
        return place not in self.ports and all(
            not move.effect(place) and not (each in self.starts and move.takes[place])
            for each in self.around[place]
            for move in (self.moves[each],)
        )

    def always_one(self, wanted: set[pn.Place]) -> bool:
        """Return whether one of some places is always marked: the greatest trap among them is marked."""
        left = {place for place in wanted if place not in self.ports}
        while True:
            gone = {
                place
                for place in left
                if any(
                    self.moves[each].takes[place]
                    and (each in self.starts or not any(self.moves[each].puts[other] for other in left))
                    for each in self.around[place]
                )
            }
            if not gone:
                return any(place.tokens for place in left)
            left -= gone

    def of(self, page: sym.CallbackPage, message: pn.Place | None) -> Work:
        """Return what one run of a callback does that a message or a tick (None) begins.

        Raises
        ------
        NotBoundedError
            Nothing bounds how long it takes.
        """
        return _WorkRun(self, page, message).work()


_Marking = frozenset[tuple[pn.Place, int]]


@dataclass
class _WaysOnward:
    """Common properties of the continuations from a marking of a run."""

    latest: Fraction = Fraction(0)
    earliest: Fraction | None = None
    puts: Counter[pn.Place] = field(default_factory=Counter)
    fewest: Counter[pn.Place] | None = None


class _WorkRun:
    def __init__(self, works: Works, page: sym.CallbackPage, message: pn.Place | None) -> None:
        self.works, self.page, self.message = works, page, message
        self.body = Body(page)
        self.name = f"callback {label(page)}"
        self.given = duration_of(page)
        self.own = {
            place
            for place in works.around
            if callback_page_of(place) is page
            and place not in works.ports
            and all(callback_page_of(each) is page for each in works.around[place])
            and any(works.moves[each].needs(place) for each in works.around[place])
        } | ({message} if message is not None else set())
        self.ends = set(self.body.ends())
        self.known: dict[_Marking, _WaysOnward | None] = {}
        self.idle: Counter[pn.Place] = Counter()
        self.is_sequential = True

    def work(self) -> Work:
        """Explore the run; places of the page that keep something from run to run may hold anything."""
        self._require_plain()
        while True:
            try:
                return self._explored()
            except _KeptError as kept:
                self.own -= kept.places
                self.known.clear()

    def _explored(self) -> Work:
        idle = Counter({place: place.tokens for place in self.own if place.tokens})
        if self.message is not None and self.message.tokens:
            raise NotBoundedError(f"{self.name} has messages at the start")
        self.idle = idle
        starts = set(self.body.beginnings()) if self.message is None else set()
        for each in self.body.transitions:
            if each not in starts and self._possible(each, idle):
                raise NotBoundedError(f"{self.name} can fire transitions between its runs")
        if self.message is None:
            found = self._started(starts)
        else:
            found = self._from(idle + Counter({self.message: 1}))
        if runs_at_once(self.page) > 1 and (idle or not self.is_sequential):
            raise NotBoundedError(f"runs of {self.name} overlap, and may have to wait for one another")
        if self.given is not None:
            assert self.given.latest is not None
            least, most = seconds_of(self.given.earliest or 0.0), seconds_of(self.given.latest)
        else:
            least = (found.earliest if self.is_sequential else None) or Fraction(0)
            most = found.latest
        publishes = {}
        for place, number in found.puts.items():
            puts = [each for each in self.body.transitions if self.works.moves[each].puts[place]]
            fewest = 0 if found.fewest is None else found.fewest[place]
            publishes[place] = Publishing(fewest, number, all(each in self.ends for each in puts))
        return Work(least, most, publishes)

    def _require_plain(self) -> None:
        """Refuse what is not followed."""
        if waits(self.page):
            raise NotBoundedError(f"{self.name} waits for a response")
        timed = [each for each in self.body.transitions if each.interval is not None]
        if self.given is None and not timed:
            raise NotBoundedError(f"the duration of {self.name} is not given")
        if self.given is not None and (timed or self.given.latest is None):
            raise NotBoundedError(f"the duration of {self.name} is not given")
        if timed and runs_at_once(self.page) > 1:
            raise NotBoundedError(f"the duration of {self.name} is not given, and its runs overlap")
        for each in self.body.transitions:
            if isinstance(each, sym.Transition) and (each.clause is not None or each.duration is not None):
                raise NotBoundedError(f"{self.name} has transition {label(each)}, which signals delay")
            if self.works.moves[each].inhibits or each in self.works.overridden:
                raise NotBoundedError(
                    f"{self.name} has transition {label(each)}, which other callbacks can delay"
                )
            touched = {*self.works.moves[each].takes, *self.works.moves[each].puts}
            if full := next((place for place in touched if place.capacity), None):
                raise NotBoundedError(f"{self.name} uses place {label(full)}, which can be full")

    def _started(self, starts: set[pn.Transition]) -> _WaysOnward:
        """Explore a run of a timer: it begins if its first transition can fire, and takes what that needs."""
        ready = [each for each in starts if self._possible(each, self.idle)]
        if not any(self._is_free(each) for each in ready):
            raise NotBoundedError(f"{self.name} can begin only in some states")
        found = _WaysOnward()
        for each in ready:
            self._add(found, each, self._after(each, self.idle))
        return found

    def _from(self, marking: Counter[pn.Place]) -> _WaysOnward:
        key = frozenset((+marking).items())
        if key in self.known:
            if (known := self.known[key]) is None:
                raise NotBoundedError(f"{self.name} can repeat its steps without end")
            return known
        if len(self.known) >= MOST_STATES:
            raise NotBoundedError(f"{self.name} has too many steps")
        self.known[key] = None
        steps = [each for each in self.body.transitions if self._possible(each, marking)]
        if self.message is None:
            steps = [each for each in steps if each not in self.works.starts]
        self._require_onward(steps)
        if sum(marking[place] - self.idle[place] for place in self.own) > 1:
            self.is_sequential = False
        found = _WaysOnward()
        for each in steps:
            self._add(found, each, self._after(each, marking))
        self.known[key] = found
        return found

    def _add(self, found: _WaysOnward, step: pn.Transition, after: Counter[pn.Place]) -> None:
        """Add a way onward that begins with a step."""
        if step in self.ends:
            if kept := {place for place in self.own if after[place] != self.idle[place]}:
                if self.message in kept:
                    raise NotBoundedError(f"{self.name} can end without its message")
                raise _KeptError(kept)
            onward = _WaysOnward(earliest=Fraction(0), fewest=Counter())
        else:
            onward = self._from(after)
        interval = step.interval
        if self.given is None and (interval is None or interval.latest is None):
            raise NotBoundedError(f"the latest time of transition {label(step)} of {self.name} is not given")
        latest = Fraction(0) if interval is None or interval.latest is None else seconds_of(interval.latest)
        earliest = Fraction(0) if interval is None else seconds_of(interval.earliest or 0.0)
        found.latest = max(found.latest, latest + onward.latest)
        if onward.earliest is not None:
            total = earliest + onward.earliest
            found.earliest = total if found.earliest is None else min(found.earliest, total)
        puts = self.works.moves[step].puts
        if onward.fewest is not None:
            fewest = puts + onward.fewest
            found.fewest = fewest if found.fewest is None else found.fewest & fewest
        for place in {*puts, *onward.puts}:
            if place not in self.own:
                found.puts[place] = max(found.puts[place], puts[place] + onward.puts[place])

    def _require_onward(self, steps: list[pn.Transition]) -> None:
        """Reject a marking in which other callbacks can delay the run."""
        if any(self._is_free(each) for each in steps):
            if self.given is None and not all(self._is_free(each) for each in steps):
                raise NotBoundedError(f"{self.name} may have to wait for other callbacks")
            return
        if self._branches(steps):
            return
        wanted: set[pn.Place] = set()
        for each in steps:
            if _is_guarded(each):
                continue
            move = self.works.moves[each]
            foreign = [
                place
                for place in {*move.takes, *move.reads}
                if place not in self.own and not self._is_there(place, each)
            ]
            if len(foreign) == 1 and move.needs(foreign[0]) == 1:
                wanted.add(foreign[0])
        if self.given is None or not wanted or not self.works.always_one(wanted):
            raise NotBoundedError(f"{self.name} may have to wait for other callbacks")

    def _is_free(self, step: pn.Transition) -> bool:
        """Return whether a step that the run's tokens allow is possible for all other tokens and data."""
        return not _is_guarded(step) and self._needs_own(step)

    def _branches(self, steps: list[pn.Transition]) -> bool:
        """Return whether the guards of steps only choose between them: one of them always holds."""
        if self.given is None and not all(map(self._needs_own, steps)):
            return False
        guards: list[tuple[sym.Transition, Counter[pn.Place]]] = []
        for each in steps:
            if isinstance(each, sym.Transition) and _is_guarded(each) and self._needs_own(each):
                move = self.works.moves[each]
                seen = Counter({place: move.needs(place) for place in {*move.takes, *move.reads}})
                guards.append((each, seen))
        return is_complete(guards, self.works.model)

    def _needs_own(self, step: pn.Transition) -> bool:
        """Return whether a step needs only tokens of the run, and places that no firing changes."""
        move = self.works.moves[step]
        return all(self._is_there(each, step) for each in {*move.takes, *move.reads} if each not in self.own)

    def _is_there(self, place: pn.Place, step: pn.Transition) -> bool:
        return self.works.is_steady(place) and place.tokens >= self.works.moves[step].needs(place)

    def _possible(self, step: pn.Transition, marking: Counter[pn.Place]) -> bool:
        move = self.works.moves[step]
        needed = {*move.takes, *move.reads} & self.own
        return all(marking[each] >= move.needs(each) for each in needed)

    def _after(self, step: pn.Transition, marking: Counter[pn.Place]) -> Counter[pn.Place]:
        move, after = self.works.moves[step], marking.copy()
        for place in {*move.takes, *move.puts}:
            if place in self.own:
                after[place] += move.effect(place)
        return after


def _is_guarded(step: pn.Transition) -> bool:
    return isinstance(step, sym.Transition) and step.guard is not None
