"""How many messages one run of a callback publishes."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.times.runs import least_put, most_put


class Listener:
    """A node with a callback that a message starts; `out` is what it publishes."""

    def __init__(self, kind: str = "exclusive") -> None:
        self.heard, self.out = sym.Place(id="Heard"), sym.Place(id="Out")
        self.page = sym.CallbackPage(id="OnMessage", kind="subscriber", objects=[self.heard, self.out])
        group = sym.CallbackGroup(id="group", kind=kind)
        self.page.group = group
        node = sym.NodeNet(id="node", execution="callbacks", executor="multi", threads=2, objects=[self.page])
        node.callbackGroups.append(group)
        channel = sym.TopicChannel(id="T", topic="/t")
        channel.subscribers.append(sym.SubscriberPort(place=self.heard, limit=4))
        answer = sym.TopicChannel(id="A", topic="/a")
        answer.publishers.append(sym.PublisherPort(place=self.out, limit=4))
        self.model = sym.SystemModel(id="model", middleware="ros2", pages=[node], channels=[channel, answer])

    def add(self, name: str, before: list[pn.Place], after: list[pn.Place]) -> sym.Transition:
        """Add a transition, and the places that are not there yet."""
        made = sym.Transition(id=name, page=self.page)
        for place in (*before, *after):
            if place.page is None:
                place.page = self.page
        for place in before:
            flow(place, made)
        for place in after:
            flow(made, place)
        return made

    def most(self) -> int | None:
        return most_put(self.page, self.out)

    def least(self) -> int:
        return least_put(self.page, self.out)


def test_steps_in_turn_are_counted_once() -> None:
    listener, done = Listener(), sym.Place(id="Done")
    listener.add("First", [listener.heard], [done, listener.out])
    listener.add("Second", [done], [listener.out])
    assert listener.most() == 2


def test_either_way_of_a_fork_that_joins_counts_alone() -> None:
    listener = Listener()
    works, silent, worked, told = (sym.Place(id=name) for name in ("Works", "Silent", "Worked", "Told"))
    listener.add("Fork", [listener.heard], [works, silent])
    listener.add("Work", [works], [worked])
    listener.add("Tell", [silent], [told, listener.out])
    listener.add("Late", [silent, worked], [told, worked, listener.out])
    listener.add("Join", [worked, told], [])
    assert listener.most() == 1


def test_a_fork_of_runs_that_overlap_gives_no_bound() -> None:
    listener = Listener("reentrant")
    left, right = sym.Place(id="Left"), sym.Place(id="Right")
    listener.add("Fork", [listener.heard], [left, right])
    listener.add("Join", [left, right], [listener.out])
    assert listener.most() is None


def test_a_circle_gives_no_bound() -> None:
    listener, again = Listener(), sym.Place(id="Again")
    listener.add("Begin", [listener.heard], [again])
    listener.add("Repeat", [again], [again, listener.out])
    listener.add("End", [again], [])
    assert listener.most() is None


def test_what_a_run_leaves_gives_no_bound() -> None:
    listener = Listener()
    now, later = sym.Place(id="Now"), sym.Place(id="Later")
    listener.add("Begin", [listener.heard], [now, later])
    listener.add("Flush", [now, later], [now, listener.out])
    end = listener.add("End", [now], [])
    end.kind = sym.TransitionKind.end
    assert listener.most() is None


def test_tokens_that_no_port_gives_start_no_run_that_is_counted() -> None:
    listener, pool = Listener(), sym.Place(id="Pool", tokens=6)
    listener.add("Take", [listener.heard], [])
    listener.add("Send", [pool], [listener.out])
    assert listener.most() is None


def test_what_another_page_puts_counts_as_given() -> None:
    listener = Listener()
    begun, shared = sym.Place(id="Begun"), sym.Place(id="Shared")
    listener.add("Begin", [listener.heard], [begun])
    listener.add("Send", [begun, shared], [begun, listener.out])
    listener.add("End", [begun], [shared])
    other = sym.CallbackPage(id="Other", kind="timer", timer=1.0)
    listener.model.pages[0].objects.append(other)
    more = sym.Transition(id="More", page=other)
    assert listener.most() == 1
    flow(more, pn.ReferencePlace(id="Shared there", target=shared, page=other))
    assert listener.most() is None


def test_the_way_that_publishes_least_counts() -> None:
    listener, done = Listener(), sym.Place(id="Done")
    listener.add("First", [listener.heard], [done, listener.out])
    listener.add("Second", [done], [listener.out])
    assert listener.least() == 2
    listener.add("Without", [done], [])
    assert (listener.least(), listener.most()) == (1, 2)
    listener.add("Silently", [listener.heard], [done])
    assert (listener.least(), listener.most()) == (0, 2)


def test_a_circle_and_starts_that_no_port_gives_leave_the_least_unknown() -> None:
    listener, again = Listener(), sym.Place(id="Again")
    listener.add("Begin", [listener.heard], [again, listener.out])
    listener.add("Repeat", [again], [again, listener.out])
    listener.add("End", [again], [])
    assert listener.least() == 0
    listener, pool = Listener(), sym.Place(id="Pool", tokens=6)
    listener.add("Take", [listener.heard], [listener.out])
    listener.add("Send", [pool], [listener.out])
    assert listener.least() == 0
