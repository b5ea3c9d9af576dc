"""Publishers and subscribers of a node."""

from __future__ import annotations

from dineros.runtime.traffic import SendError, Traffic, number_of, sender_of
from dineros.runtime.transport import Message, PublisherPort, SubscriberPort


class Publisher:
    """Sends the tokens of a place on a topic; places of several server instances share the port."""

    def __init__(self, traffic: Traffic, port: PublisherPort, place: int) -> None:
        self._traffic = traffic
        self._port = port
        self._place = place

    def send(self) -> None:
        """Publish the oldest token.

        Raises
        ------
        SendError
            The transport failed; the token stays where it is.
        """
        traffic, port, place = self._traffic, self._port, self._place
        token = traffic.engine.oldest(place)
        message = Message(traffic.next_id(place), token.data)
        try:
            is_sent = traffic.joined.publish(port, message)
        except Exception as error:
            raise SendError(f"cannot publish on {port.topic}: {error}") from error
        traffic.engine.take(place)
        if is_sent:
            traffic.count_sent(place)
        else:
            traffic.drops[port.channel, "publisher"] += 1
        if traffic.observer.is_observing:
            name = traffic.engine.structure.places[place]
            fields = {"channel": port.channel, "place": name, "token": token.id}
            change = {name: -1}
            if is_sent:
                traffic.observer.emit("publish", **fields, message=message.id, change=change)
            else:
                traffic.observer.emit("drop", **fields, queue="publisher", count=1, change=change)


class Subscriber:
    """Makes tokens of the messages of a topic.

    Attributes
    ----------
    seen : dict of str to int
        Sender -> number of its last message: what comes again is ignored. One sender's messages come in
        order.
    """

    def __init__(self, traffic: Traffic, port: SubscriberPort, place: int) -> None:
        self._traffic = traffic
        self._port = port
        self._place = place
        self.seen: dict[str, int] = {}

    def arrived(self, message: Message, lost: int) -> None:
        """Put the token of a message, unless it came before; `lost` are missing just before it."""
        traffic, port = self._traffic, self._port
        if lost > 0:
            traffic.lost(port, "subscriber", lost)
        number = number_of(message.id)
        if number is not None:
            sender = sender_of(message.id)
            if number <= self.seen.get(sender, 0):
                return
        token = traffic.arriving(port.topic, message.data)
        if token is None:
            return
        if number is not None:
            self.seen[sender] = number
        traffic.engine.put(self._place, token)
        if traffic.observer.is_observing:
            traffic.observer.emit(
                "take",
                channel=port.channel,
                place=port.place,
                token=token.id,
                message=message.id,
                data=token.data,
                change={port.place: 1},
            )
