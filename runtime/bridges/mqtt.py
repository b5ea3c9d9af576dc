"""Input signals over MQTT: whoever publishes on a signal's topic sets it (MQTT 3.1.1; push)."""

from __future__ import annotations

import logging
import threading
from collections.abc import Mapping
from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.runtime.bridges.values import SignalValueError, read_truth
from dineros.runtime.net import Net

LOG = logging.getLogger("dineros.runtime.bridges")


class MqttSignals:
    """Sets the signals of a net from an MQTT broker, for as long as it is open.

    A broker that is not there, or goes away, is tried again and again. A retained message sets the signal
    when the bridge comes. What is no truth value is logged and changes nothing.

    Parameters
    ----------
    net : Net
        The net.
    topics : mapping of str to str, optional
        Topic -> id or name of a signal; by default ``NODE/signals/SIGNAL`` for each signal of the net.
    host, port : str, int
        The broker.
    username, password : str, optional
        As the broker wants them.

    Raises
    ------
    UnknownElementError
        The net has no such signal.
    DinerosError
        The package paho-mqtt is not installed.
    """

    def __init__(
        self,
        net: Net,
        topics: Mapping[str, str] | None = None,
        *,
        host: str = "127.0.0.1",
        port: int = 1883,
        username: str | None = None,
        password: str | None = None,
    ) -> None:
        try:
            from paho.mqtt import client as mqtt
            from paho.mqtt.enums import CallbackAPIVersion
        except ImportError as error:
            raise DinerosError("MQTT is not there", hint="install dineros[mqtt]") from error
        if topics is None:
            topics = {f"{net.id}/signals/{signal}": signal for signal in net.inspect().signals}
        self._signals = {topic: net.signal(name) for topic, name in topics.items()}
        self._address = (host, port)
        self._subscribed = threading.Event()
        self._client: Any = mqtt.Client(CallbackAPIVersion.VERSION2)
        self._client.reconnect_delay_set(min_delay=1, max_delay=30)
        if username is not None:
            self._client.username_pw_set(username, password)
        self._client.on_connect = self._connected
        self._client.on_disconnect = self._disconnected
        self._client.on_subscribe = lambda *_: self._subscribed.set()
        self._client.on_message = self._heard

    def open(self) -> None:
        """Begin to listen, as soon as the broker is there."""
        self._client.connect_async(*self._address)
        self._client.loop_start()

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until the bridge listens; return whether it does."""
        return self._subscribed.wait(timeout)

    def close(self) -> None:
        """Listen no more."""
        self._client.disconnect()
        self._client.loop_stop()

    def __enter__(self) -> MqttSignals:
        self.open()
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _connected(self, client: Any, data: Any, flags: Any, reason: Any, properties: Any) -> None:
        if reason.is_failure:
            LOG.error("the MQTT broker at %s:%s refuses: %s", *self._address, reason)
        elif self._signals:
            client.subscribe([(topic, 1) for topic in self._signals])
        else:
            self._subscribed.set()

    def _disconnected(self, client: Any, data: Any, flags: Any, reason: Any, properties: Any) -> None:
        self._subscribed.clear()
        if reason.is_failure:
            LOG.warning("the MQTT broker at %s:%s is gone: %s", *self._address, reason)

    def _heard(self, client: Any, data: Any, message: Any) -> None:
        try:
            value = read_truth(message.payload)
        except SignalValueError as error:
            LOG.error("MQTT topic %s: %s", message.topic, error)
            return
        self._signals[message.topic].set(value, f"mqtt {message.topic}")
