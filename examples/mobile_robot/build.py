"""A mobile robot on its rounds, with a charging dock that it finds by its camera, as a system model.

``python examples/mobile_robot/build.py`` writes `mobile_robot.sym.xmi`, and `mobile_robot_earlier.sym.xmi`,
the same robot with a mistake that `check` found.

* The **mission** sends the robot from waypoint to waypoint: goals of an action. A goal that fails is tried
  once more; when the battery is low, the goal is canceled, and the robot goes to its dock.
* The **navigator** drives to one waypoint at a time, tells how far it is, gives up before an obstacle, and
  brakes when its goal is to be canceled. It has a permit for each leg that the battery has charge for.
* The **lidar** measures what is ahead: a best-effort sensor.
* The **battery** counts the legs that were driven, warns, and gives permits while it is charged.
* The **dock** finds itself by what the detector sees, and has the battery charged.
* The **camera**, a managed node, sends pictures while it is active; the **detector** looks for the dock in
  them.
"""

from __future__ import annotations

from pathlib import Path

from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, flow, here, inhibit, node_net, place, read, step
from dineros.metamodel.files import save

HOME = Path(__file__).resolve().parent
LEGS = 3
"""How many legs a charge is enough for."""
WARNING = 2
"""After how many legs the battery warns."""
ROUND = [("gate", 4.0, 0.0), ("shelf", 4.0, 3.0), ("door", 0.0, 3.0)]
PATIENCE = 0.5
"""Seconds after which the mission asks again to cancel a goal."""
SCAN_PERIOD, PICTURE_PERIOD = 0.1, 0.2
Quality = tuple[sym.Reliability, sym.Durability]
SENSOR = (sym.Reliability.bestEffort, sym.Durability.volatile)
LATCHED = (sym.Reliability.reliable, sym.Durability.transientLocal)

PROPERTIES = {
    "LegsHaveCharge": f"always Permits + Leg + Driven + Spent + Permit <= {LEGS}",
    "NeverDrivesAtTheDock": "never Driving + Docked >= 2",
    "ChargesAtTheDockOnly": "never Charging >= 1 and Docked == 0",
    "PicturesOfAnActiveCameraOnly": "never enabled(TShoot) and camera.active == 0",
    "DocksWithACameraOnly": "never Docked >= 1 and camera.unconfigured >= 1",
    "TriesOnceMore": "always Retry + Tried == 1",
    "OneThingAtATime": "always Idle + UnderWay + Recalled + AskDock + Charged <= 1",
    "RoundsGoOn": "Idle >= 1 stays possible",
    "GoalsEnd": "Done + Failed + Back + Refused >= 1 stays possible",
    "CanAlwaysCharge": "Charging >= 1 stays possible",
}


class Types:
    """What tokens carry: trips, what is told on the way, ranges (a message of ROS), and pictures."""

    def __init__(self, model: sym.SystemModel) -> None:
        numbers = [sym.TokenField(name=name, kind="number") for name in "xy"]
        note = sym.TokenField(name="note", default='"none"')
        self.trip = sym.TokenType(id="Trip", fields=[sym.TokenField(name="name"), *numbers, note])
        self.progress = sym.TokenType(
            id="Progress", fields=[sym.TokenField(name="distance", kind="number", ros="float32")]
        )
        self.range = sym.TokenType(id="Range", ros="std_msgs/msg/Float32")
        self.picture = sym.TokenType(
            id="Picture",
            fields=[
                sym.TokenField(name="number", kind="integer"),
                sym.TokenField(name="marker", kind="boolean"),
            ],
        )
        self.charge = sym.TokenType(id="Charge", fields=[sym.TokenField(name="leg", kind="integer")])
        model.tokenType = self.trip
        model.otherTokenTypes.extend([self.progress, self.range, self.picture, self.charge])


class Robot:
    """The model while it is built: nodes first, then what joins them.

    Parameters
    ----------
    mistake : str
        What is wrong with it: ``"asks once"``, where the mission asks once to cancel a goal, and minds no
        more; ``"docks at once"``, where it sends the robot to the dock before that goal is over; or nothing.
    waypoints : int
        How many of `ROUND` it has.
    has_feedback : bool
        Whether the navigator tells how far it is.
    """

    def __init__(self, mistake: str = "", waypoints: int = len(ROUND), has_feedback: bool = True) -> None:
        self.model = sym.SystemModel(id="mobile_robot", name="mobile_robot", middleware="ros2")
        self.types = Types(self.model)
        self.places: dict[str, sym.Place] = {}
        self.waypoints, self.has_feedback = waypoints, has_feedback
        self.mission(mistake)
        self.navigator()
        self.lidar()
        self.battery()
        self.dock()
        self.camera()
        self.detector()
        self.channels()
        self.properties()

    # Nodes.

    def mission(self, mistake: str) -> None:
        """Send the robot on its round; let it charge when the battery is low."""
        net = self.node("mission", "Again")
        waypoints = self.place(net, "Waypoints", tokens=self.waypoints)
        waypoints.balloons.extend(
            sym.BalloonToken(data=f'{{"name": "{name}", "x": {x}, "y": {y}}}')
            for name, x, y in ROUND[: self.waypoints]
        )
        closed, idle, retries = (
            self.place(net, id, n) for id, n in (("Closed", 0), ("Idle", 1), ("Retry", 1))
        )
        goal, under_way, recalled, tried, recall, ask = self.some(
            net, "Goal", "UnderWay", "Recalled", "Tried", "Recall", "AskDock"
        )
        done, failed, back, no = self.some(net, "Done", "Failed", "Back", "Refused")
        send = step(net, "TSend")
        flow(waypoints, send, goal)
        flow(idle, send, under_way)
        read(retries, send)
        recall.capacity = 1
        if mistake != "asks once":
            inhibit(recall, send)  # what was asked of the last goal must not meet the next one
        step(net, "TAgain", [closed], [waypoints], clause="Again")
        for id, end, into in (("TDone", done, closed), ("TRefused", no, closed)):
            step(net, id, [end, under_way], [into, idle])
        step(net, "TRetry", [failed, under_way, retries], [goal, under_way, tried])
        step(net, "TGiveUp", [failed, under_way, tried], [closed, idle, tried])
        step(net, "TForget", [tried, idle], [retries, idle])

        low = self.place(callback(net, "OnLow"), "Low")
        low_here, charged = here(low, net), self.place(net, "Charged")
        now, later = ([ask], []) if mistake == "docks at once" else ([], [ask])
        step(net, "TRecall", [low_here, under_way], [recall, recalled, *now])
        step(net, "TDock", [low_here, idle], [ask])
        for id, end, into in (
            ("TDoneAtLast", done, closed),
            ("TBack", back, waypoints),
            ("TLeave", failed, waypoints),
            ("TRefusedAtLast", no, closed),
        ):
            step(net, id, [end, recalled], [into, *later])
        if mistake != "asks once":  # a request is gone where no goal is sent yet
            insist = step(net, "TInsist")
            insist.interval = pn.TimeInterval(earliest=PATIENCE)
            read(recalled, insist)
            flow(insist, recall)
        step(net, "TCharged", [charged], [idle])
        if self.has_feedback:
            step(net, "TNote", [self.place(net, "Way", type=self.types.progress)])

    def navigator(self) -> None:
        """Drive to one waypoint at a time."""
        net = self.node("navigator", "AtGoal")
        permits = self.place(callback(net, "OnPermit"), "Permits", LEGS, self.types.charge)
        standing = self.place(net, "Standing", 1)
        page = callback(net, "Navigate", "goal")
        target, driving, there, blocked, stop, stopped, leg = self.some(
            page, "Target", "Driving", "There", "Blocked", "Stop", "Stopped", "Leg"
        )
        leg.tokenType = self.types.charge
        tells = [self.place(page, "Told", type=self.types.progress)] if self.has_feedback else []
        for told in tells:
            told.capacity = 1
        scan = self.place(callback(net, "OnScan"), "Scan", type=self.types.range)
        rest, ahead, permit = here(standing, page), here(scan, page), here(permits, page)
        step(page, "TDrive", [target, permit, rest], [driving, leg])
        step(page, "TArrive", [driving], [there, rest], clause="AtGoal")
        if self.has_feedback:
            step(page, "TProceed", [driving, ahead], [driving, *tells])
        else:  # a scan that changes nothing keeps no other transition waiting
            read(driving, step(page, "TProceed", [ahead]))
        step(page, "TBlocked", [driving, ahead], [blocked, rest])
        step(page, "TBrake", [driving, stop], [stopped, rest])
        step(page, "TStay", [target, stop], [stopped])
        ignore = step(net, "TIgnore")
        flow(here(scan, net), ignore)
        read(standing, ignore)

    def lidar(self) -> None:
        """Measure what is ahead, again and again."""
        page = callback(self.node("lidar"), "OnScanner", "timer", SCAN_PERIOD)
        flow(step(page, "TScan"), self.place(page, "Ahead", type=self.types.range))

    def battery(self) -> None:
        """Count the legs, warn, and give permits while it is charged."""
        net, charge = self.node("battery"), self.types.charge
        spent, permit = self.place(net, "Spent", type=charge), self.place(net, "Permit", type=charge)
        watching, warned, low = (
            self.place(net, "Watching", 1),
            self.place(net, "Warned"),
            self.place(net, "Warning"),
        )
        counting = callback(net, "OnLeg")
        driven = self.place(counting, "Driven", type=charge)
        flow(driven, step(counting, "TCount"), here(spent, counting))
        warn = step(net, "TWarn", [watching], [warned, low])
        read(spent, warn, WARNING)
        page = callback(net, "ChargeServer", "server")
        asked, charging, full = self.some(page, "ChargeEntry", "Charging", "ChargeExit")
        legs = here(spent, page)
        step(page, "TPlug", [asked, here(warned, page)], [charging])
        step(page, "TCharge", [charging, legs], [charging, here(permit, page)])
        inhibit(legs, step(page, "TFull", [charging], [full, here(watching, page)]))

    def dock(self) -> None:
        """Find the dock, and have the battery charged there."""
        net = self.node("dock")
        free = self.place(net, "Free", 1)
        marker = self.place(callback(net, "OnMarker"), "Marker", type=self.types.picture)
        page = callback(net, "DockServer", "server")
        asked, searching, docked, ask, answer, away = self.some(
            page, "DockEntry", "Searching", "Docked", "AskCharge", "Full", "DockExit"
        )
        bay = here(free, page)
        step(page, "TSearch", [asked, bay], [searching])
        step(page, "TApproach", [searching, here(marker, page)], [docked, ask])
        step(page, "TUndock", [docked, answer], [away, bay])
        overlook = step(net, "TOverlook")
        flow(here(marker, net), overlook)
        read(free, overlook)

    def camera(self) -> None:
        """Send pictures while it is active: others activate and deactivate it."""
        net = self.node("camera")
        net.lifecycle = sym.Lifecycle(pauses=True, deactivates=True, configureStep=1, activateStep=2)
        page = callback(net, "OnShutter", "timer", PICTURE_PERIOD)
        flow(step(page, "TShoot"), self.place(page, "Image", type=self.types.picture))

    def detector(self) -> None:
        """Look for the dock's marker in pictures."""
        page = callback(self.node("detector"), "OnImage")
        seen, found = (self.place(page, id, type=self.types.picture) for id in ("Seen", "Found"))
        step(page, "TDetect", [seen], [found])
        step(page, "TNothing", [seen], [])

    # What joins them.

    def channels(self) -> None:
        """Let nodes talk to each other."""
        self.topic("Scans", "/scan", "Ahead", "Scan", 1, SENSOR)
        self.topic("Images", "/camera/images", "Image", "Seen", 1, SENSOR)
        self.topic("Markers", "/dock/marker", "Found", "Marker", 1, SENSOR)
        self.topic("Legs", "/battery/legs", "Leg", "Driven", LEGS, LATCHED)
        permissions = self.topic("Permissions", "/battery/permits", "Permit", "Permits", LEGS, LATCHED)
        permissions.subscribers[0].inHand = LEGS
        self.topic("LowBattery", "/battery/low", "Warning", "Low", 1, LATCHED)
        self.service("Dock", "/dock", "DockServer", "DockEntry", "DockExit", "mission", "AskDock", "Charged")
        self.service(
            "ChargeBattery",
            "/battery/charge",
            "ChargeServer",
            "ChargeEntry",
            "ChargeExit",
            "dock",
            "AskCharge",
            "Full",
        )
        places = self.places
        sym.ActionChannel(
            id="Navigation",
            action="/navigate",
            instances=1,
            depth=5,
            server=sym.ActionServerPort(
                page=places["Target"].page,
                entry=places["Target"],
                succeeded=places["There"],
                aborted=places["Blocked"],
                canceled=places["Stopped"],
                cancel=places["Stop"],
                feedback=places.get("Told"),
                mayReject=True,
            ),
            clients=[
                sym.ActionClientPort(
                    client="mission",
                    goal=places["Goal"],
                    succeeded=places["Done"],
                    aborted=places["Failed"],
                    canceled=places["Back"],
                    rejected=places["Refused"],
                    cancel=places["Recall"],
                    feedback=places.get("Way"),
                )
            ],
            model=self.model,
        )

    def properties(self) -> None:
        """Say what matters, in the robot's own words."""
        for id, text in PROPERTIES.items():
            self.model.properties.append(sym.Property(id=id, text=text))

    # Shorter words.

    def node(self, id: str, *signals: str) -> sym.NodeNet:
        """Add a node net with its signals."""
        return node_net(self.model, id, signals, package=f"robot_{id}")

    def place(self, page: pn.Page, id: str, tokens: int = 0, type: sym.TokenType | None = None) -> sym.Place:
        """Add a place."""
        self.places[id] = made = place(page, id, tokens, type)
        return made

    def some(self, page: pn.Page, *ids: str) -> list[sym.Place]:
        """Add empty places."""
        return [self.place(page, id) for id in ids]

    def topic(
        self, id: str, name: str, sent: str, got: str, depth: int, quality: Quality
    ) -> sym.TopicChannel:
        """Add a topic with histories of one depth and one quality of service at both ends."""
        return sym.TopicChannel(
            id=id,
            topic=name,
            qos=sym.QualityOfService(reliability=quality[0], durability=quality[1]),
            publishers=[sym.PublisherPort(place=self.places[sent], limit=depth)],
            subscribers=[sym.SubscriberPort(place=self.places[got], limit=depth)],
            model=self.model,
        )

    def service(
        self, id: str, name: str, page: str, entry: str, exit: str, client: str, request: str, response: str
    ) -> None:
        """Add a service with one client."""
        places = self.places
        sym.ServiceChannel(
            id=id,
            service=name,
            server=sym.ServerPort(page=places[entry].page, entry=places[entry], exit=places[exit]),
            clients=[sym.ClientPort(client=client, request=places[request], response=places[response])],
            model=self.model,
        )


def build(mistake: str = "", waypoints: int = len(ROUND), has_feedback: bool = True) -> sym.SystemModel:
    """Return the robot, as it is or with a mistake; see `Robot`."""
    return Robot(mistake, waypoints, has_feedback).model


def main() -> None:
    """Write the models."""
    save(build(), HOME / "mobile_robot.sym.xmi")
    save(build("asks once"), HOME / "mobile_robot_earlier.sym.xmi")


if __name__ == "__main__":
    main()
