"""A planner and a driver whose tokens have types of their own: orders, and two installed messages of ROS."""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.build import flow

PLANNER = '''
@firings.on("TPlan")
def plan(firing: firings.TPlanFiring) -> firings.TPlanOutcome:
    """Orders become goals."""
    order = firing.inputs["Orders"][0].data
    where = tokens.pose(position=tokens.point(x=float(order["count"]), y=0.1))
    return {"header": tokens.header(frame_id=order["article"]), "pose": where}


@firings.on("TAsk")
def ask(firing: firings.TAskFiring) -> firings.Outcome:
    """Ask for a lamp."""
    return {"article": "lamp", "count": 255, "sizes": [0.1, 2.0], "urgency": tokens.ORDER_HIGH}
'''
DRIVER = '''
@firings.on("TDrive")
def drive(firing: firings.TDriveFiring) -> firings.TDriveOutcome:
    """Goals become reports."""
    target = firing.inputs["Target"][0].data
    firing.data["data"] = f"{target['header']['frame_id']} at {target['pose']['position']['x']:g}"
    return None


@firings.on("TServe")
def serve(firing: firings.TServeFiring) -> firings.TServeOutcome:
    """Orders become a goal and a line in the log."""
    order = firing.inputs["Entry"][0].data
    turned = tokens.pose(orientation=tokens.quaternion(z=1.0, w=0.0))
    goal: tokens.GoalChanges = {"pose": turned, "header": tokens.header(frame_id=order["article"])}
    urgent = order["urgency"] == tokens.ORDER_HIGH
    return firing.give({"Exit": goal, "Log": {"data": f"{order['count']}{'!' if urgent else ''}"}})
'''
"""Handlers of the packages; they need `firings` and `tokens` of the package."""


def shop() -> sym.SystemModel:
    """Return a topic of each installed message, and a service whose requests and responses differ."""
    order = sym.TokenType(
        id="Order",
        fields=[
            sym.TokenField(name="article", ros="string<=8"),
            sym.TokenField(name="count", kind="integer", ros="uint8"),
            sym.TokenField(name="sizes", kind="list", elementKind="number", ros="float32", bound=3),
            sym.TokenField(name="urgency", kind="integer", ros="uint8", values="LOW=0, HIGH=2"),
        ],
    )
    goal = sym.TokenType(id="Goal", ros="geometry_msgs/msg/PoseStamped")
    note = sym.TokenType(id="Note", ros="std_msgs/msg/String")

    def place(id: str, token_type: sym.TokenType | None = None, tokens: int = 0) -> sym.Place:
        return sym.Place(id=id, tokenType=token_type, tokens=tokens)

    orders, goals = place("Orders", tokens=2), place("Goals", goal)
    orders.balloons.append(sym.BalloonToken(data='{"article": "nut", "count": 7}'))
    start, ask, answer, kept = (
        place("Start", tokens=1),
        place("Ask"),
        place("Answer", goal),
        place("Kept", goal),
    )
    arrived, done = place("Arrived", note), place("Done", note)
    plan, tell, keep, close = (sym.Transition(id=id) for id in ("TPlan", "TAsk", "TKeep", "TClose"))
    on_report = sym.CallbackPage(id="OnReport", objects=[arrived, close, done])
    own = [orders, plan, goals, start, tell, ask, answer, keep, kept, on_report]
    planner = sym.NodeNet(id="planner", package="shop_planner", objects=own)
    flow(orders, plan, goals)
    flow(start, tell, ask)
    flow(answer, keep, kept)
    flow(arrived, close, done)

    target, drive, report = place("Target", goal), sym.Transition(id="TDrive"), place("Report", note)
    entry, exit_, log, serve = (
        place("Entry"),
        place("Exit", goal),
        place("Log", note),
        sym.Transition(id="TServe"),
    )
    on_goal = sym.CallbackPage(id="OnGoal", objects=[target, drive, report])
    locate = sym.CallbackPage(id="Locate", kind="server", objects=[entry, serve, exit_, log])
    driver = sym.NodeNet(id="driver", package="shop_driver", objects=[on_goal, locate])
    flow(target, drive, report)
    flow(entry, serve, exit_)
    flow(serve, log)

    return sym.SystemModel(
        id="shop",
        tokenType=order,
        otherTokenTypes=[goal, note],
        pages=[planner, driver],
        channels=[
            _topic("GoalTopic", "/goal", goals, target),
            _topic("ReportTopic", "/report", report, arrived),
            sym.ServiceChannel(
                id="Where",
                service="where",
                server=sym.ServerPort(entry=entry, exit=exit_, page=locate),
                clients=[sym.ClientPort(client="planner", request=ask, response=answer)],
            ),
        ],
    )


def _topic(id: str, topic: str, source: sym.Place, target: sym.Place) -> sym.TopicChannel:
    return sym.TopicChannel(
        id=id,
        topic=topic,
        publishers=[sym.PublisherPort(place=source)],
        subscribers=[sym.SubscriberPort(place=target)],
    )
