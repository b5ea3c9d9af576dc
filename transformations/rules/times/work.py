"""Durations of callbacks (rules D2 to D4)."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.transformations.language import Absent, ForAll, Index, Made, Meaning, New, Node, image, less
from dineros.transformations.rules.actions.callbacks import E6Answer
from dineros.transformations.rules.actions.ends import End
from dineros.transformations.rules.actions.feedback import A5
from dineros.transformations.rules.actions.goals import A2
from dineros.transformations.rules.actions.slots import SlotCallback
from dineros.transformations.rules.executors import E3, Beginning, E3Serve, E3Take, Ending
from dineros.transformations.rules.notation import SHEET, arc, at_once, place, read, transition
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.callbacks import Callback, Ends, LastSteps
from dineros.transformations.rules.queries.message_times import CallsArriveInTime, CallsOnTheWay
from dineros.transformations.rules.queries.times import (
    GivenDuration,
    GoalDuration,
    HasDuration,
    HasInterval,
    HoldsForAllRuns,
    LatestHoldsForAllRuns,
    Moves,
    RunsAtOnce,
    RunsCallbacks,
    Stretch,
    Waits,
    WorksOnGoals,
)
from dineros.transformations.rules.requests import R6Instance
from dineros.transformations.rules.services import S1, S2, instances
from dineros.transformations.rules.times.clocks import Clock


class D2Take(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """An executor takes a message as soon as a thread, its group and what it needs are free."""

    reader = Node(sym.SubscriberPort)
    page = Node(sym.CallbackPage, of=Callback(reader.place))
    beginning = Made(E3Take.beginning, of=[reader, page])
    move = Node(pn.Transition, of=beginning.move)

    prompt = at_once(move)

    where = [~HasInterval(move)]


class D2Serve(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """An executor takes a request without latency as soon as it can."""

    client = Node(sym.ClientPort)
    call = Made(S2.t_call, of=client)
    move = Node(pn.Transition, of=call)
    page = Node(sym.CallbackPage)
    beginning = Made(E3Serve.beginning, of=page)

    prompt = at_once(move)

    where = [beginning.move == move, CallsOnTheWay(client) > 0, ~HasInterval(move)]


class D2Late(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """An executor takes a request whose client has given up as soon as it can."""

    service = Node(sym.ServiceChannel)
    instance = Index(upto=instances(service))
    call = Made(R6Instance.t_call, of=[service, instance])
    move = Node(pn.Transition, of=call)
    page = Node(sym.CallbackPage)
    beginning = Made(E3Serve.beginning, of=page)

    prompt = at_once(move)

    where = [beginning.move == move, CallsArriveInTime(service), ~HasInterval(move)]


class D2Response(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """An executor takes a response as soon as it can."""

    client = Node(sym.ClientPort)
    t_res = Made(S1.t_res, of=client)

    prompt = at_once(t_res)

    where = [RunsCallbacks(client.response), CallsOnTheWay(client) > 0, ~HasInterval(t_res)]


class D2Feedback(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """An executor takes feedback that has arrived as soon as it can, if it begins a callback."""

    client = Node(sym.ActionClientPort)
    page = Node(sym.CallbackPage)
    beginning = Made(E6Answer.beginning, of=[client, page])
    heard = Made(A5.heard, of=client)
    move = Node(pn.Transition, of=heard.move)

    prompt = at_once(move)

    where = [beginning.move == move, ~HasInterval(move)]


class D2(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A callback that has a duration and never waits works for that duration, from its beginning."""

    page = Node(sym.CallbackPage)
    running = Made(E3.running, of=page)

    begun = place("{page.id}.works", means=Meaning("{callback} begins to work"))
    worked = place("{page.id}.worked", means=Meaning("{callback} has done its work"))

    where = [HasDuration(page)]


class D2Begin(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """The work of a callback begins with the callback."""

    page = Node(sym.CallbackPage)
    begun = Made(D2.begun, of=page)
    beginning = Made(Beginning, of=page)

    begins = arc(beginning.move, begun)


class D2End(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """The callback ends when its work is done."""

    page = Node(sym.CallbackPage)
    worked = Made(D2.worked, of=page)
    ending = Made(Ending, of=page)

    ends = arc(worked, ending.move)


class D2Clock(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """Each run of a callback with a duration has a clock."""

    page = Node(sym.CallbackPage)
    begun = Made(D2.begun, of=page)
    worked = Made(D2.worked, of=page)
    number = Index(upto=RunsAtOnce(page))

    clock = Clock(
        "{page.id}.work[{number}]",
        source=begun,
        target=worked,
        within=GivenDuration(page),
        begins="a thread executes {callback}",
        runs="{callback} is being executed",
        ends="the work of {callback} is done",
    )

    where = [~WorksOnGoals(page)]


class D2Accept(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """The work on a goal begins when it is accepted."""

    served = SlotCallback()
    begun = Made(D2.begun, of=served.callback)
    accept = Made(A2.accept, of=[served.action, served.slot])

    begins = arc(accept, begun)


class D2Finish(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A goal ends when the work on it is done."""

    served = SlotCallback()
    worked = Made(D2.worked, of=served.callback)
    end = Made(End, of=[served.action, served.slot])

    ends = arc(worked, end.move)


class D2Goal(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """The work on a goal has a clock; it may end early if the goal may be canceled."""

    served = SlotCallback()
    begun = Made(D2.begun, of=served.callback)
    worked = Made(D2.worked, of=served.callback)

    clock = Clock(
        "{callback.id}.work",
        source=begun,
        target=worked,
        within=GoalDuration(served.callback, served.action),
        begins="a thread executes {callback}",
        runs="{callback} is being executed",
        ends="the work of {callback} is done",
    )


class D2Stop(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """The work on a goal ends with the step that stops it, if that step makes the goal canceled."""

    served = SlotCallback()
    stopped = Node(pn.Place, of=image(served.action.server.canceled, served.page))
    worked = Made(D2.worked, of=served.callback)
    clock = Made(D2Goal.clock, of=[served.action, served.slot])

    stop = transition("{callback.id}.stop", means=Meaning("{callback} stops its work"), at_once=True)
    arcs = [
        arc(clock.busy, stop),
        read(stopped, stop),
        arc(stop, worked),
        arc(stop, clock.free),
    ]


class D2Order(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A run of a callback takes the first free clock."""

    page = Node(sym.CallbackPage)
    number = Index(upto=RunsAtOnce(page))
    clock = Made(D2Clock.clock, of=[page, number])
    lower = Index(upto=less(number, 1))
    before = Made(D2Clock.clock, of=[page, lower])

    waits = read(before.busy, clock.begin)


class D3(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A step of a callback with a duration fires at any moment of the work, at the latest at its end."""

    page = Node(sym.CallbackPage)
    worked = Made(D2.worked, of=page)
    step = Node(pn.Transition, of=Moves(page))
    end = Node(pn.Transition, of=Ends(page))
    last = Node(pn.Transition, of=LastSteps(page))
    entering = Node(pn.Arc, target=step)
    leaving = Node(pn.Arc, source=step)

    late = transition(
        "{step.id}.late", means=Meaning("{callback} does its remaining work"), at_once=True, repeats=True
    )
    done = read(worked, late)
    takes = ForAll(
        [entering],
        make=[
            New(
                pn.Arc, page=SHEET, id="{entering.id}.late", source=entering.source, target=late,
                weight=entering.weight, kind=entering.kind,
            )
        ],
    )  # fmt: skip
    puts = ForAll(
        [leaving],
        make=[
            New(
                pn.Arc, page=SHEET, id="{leaving.id}.late", source=late, target=leaving.target,
                weight=leaving.weight, kind=leaving.kind,
            )
        ],
    )  # fmt: skip

    where = [~HasInterval(step)]
    absent = [Absent(end, where=[end == step]), Absent(last, where=[last == step])]


class D3Last(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """The last step of a server fires when its work is done."""

    page = Node(sym.CallbackPage)
    worked = Made(D2.worked, of=page)
    last = Node(pn.Transition, of=LastSteps(page))

    done = read(worked, last)

    where = [~HasInterval(last)]


class D3Early(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """If several runs of a callback share a transition with one clock, it may fire early.

    Its latest bound stays where one clock allows all that a clock for each run would allow.
    """

    page = Node(sym.CallbackPage)
    move = Node(pn.Transition, of=Moves(page))
    past = Node(pn.TimeInterval, of=move.interval)

    until = New(pn.TimeInterval, into=move.interval, latest=past.latest)

    where = [RunsAtOnce(page) > 1, ~HoldsForAllRuns(move), LatestHoldsForAllRuns(move)]
    deletes = [past]


class D3Open(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """If several runs of a callback share a transition with one clock, its interval is left open.

    It stays where one clock allows all that a clock for each run would allow.
    """

    page = Node(sym.CallbackPage)
    move = Node(pn.Transition, of=Moves(page))
    past = Node(pn.TimeInterval, of=move.interval)

    where = [RunsAtOnce(page) > 1, ~LatestHoldsForAllRuns(move)]
    deletes = [past]


class D2Ends(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """When the work is done, the transition that ends the callback fires at once, with all its effects."""

    page = Node(sym.CallbackPage)
    worked = Made(D2.worked, of=page)
    end = Node(pn.Transition, of=Ends(page))

    prompt = at_once(end)

    where = [~HasInterval(end)]


class D3Prompt(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """When the work is done, a step that is left fires at once."""

    page = Node(sym.CallbackPage)
    worked = Made(D2.worked, of=page)
    last = Node(pn.Transition, of=LastSteps(page))

    prompt = at_once(last)

    where = [~HasInterval(last)]


class D4(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """If a callback with a duration waits, each of its phases takes at most the duration."""

    page = Node(sym.CallbackPage)
    move = Node(pn.Transition, of=Moves(page))

    stretch = New(pn.TimeInterval, into=move.interval, latest=Stretch(page))

    where = [RunsCallbacks(page), Waits(page), ~HasInterval(move)]
