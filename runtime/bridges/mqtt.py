"""Input signals over MQTT: a message on a signal's topic sets it (MQTT 5 or 3.1.1; push)."""

from __future__ import annotations

import sys
import threading
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.errors import DinerosError
from dineros.runtime.bridges.security import LOG, Credentials, Tls, is_own_machine
from dineros.runtime.bridges.values import SIZE_LIMIT, SignalValueError, read_setting, read_signals
from dineros.runtime.nets.sources import Source
from dineros.runtime.nodes.net import Net
from dineros.runtime.scheduling.threads import join

PACKET_LIMIT = SIZE_LIMIT + 65_535 + 1_024
"""Maximum size of a packet (payload, topic, properties); the broker is asked to send no larger one."""

RETRY_DELAY = 1.0


class MqttSignals:
    """Sets the signals of a net from an MQTT broker while it is open.

    The bridge retries the connection without limit if the broker is missing or lost. A retained message sets
    the signal when the bridge connects. A payload that is not a truth value changes nothing; it is counted,
    and logged and recorded once a minute for each topic. No message ends the bridge. `Net.inspect` shows its
    state.

    Parameters
    ----------
    net : Net
        The net.
    topics : mapping, optional
        Topic -> id or name of a signal: its payload is a truth value, or the name of a value; or topic ->
        several of them: its payload is a JSON object such as ``{"Red": true, "Mode": "idle"}`` that sets some
        of them at once. A
        topic may have the wildcards ``+`` and ``#`` (MQTT 5, section 4.7). By default
        ``NODE/signals/SIGNAL`` for each signal of the net, and ``NODE/signals`` for all.
    host, port : str, int
        The broker; the usual port is 1883, with TLS 8883.
    credentials : Credentials, optional
        Name and password for the broker.
    tls : Tls, optional
        Use TLS. ``Tls()`` trusts the authorities that the system trusts.
    version : {"5", "3.1.1"}
        The protocol. With 3.1.1 the client cannot announce a maximum size: a larger message is read, then
        refused.

    Raises
    ------
    UnknownElementError
        The net has no such signal.
    DinerosError
        The package paho-mqtt is not installed, a topic is invalid, or a certificate cannot be used.
    """

    def __init__(
        self,
        net: Net,
        topics: Mapping[str, str | Sequence[str]] | None = None,
        *,
        host: str = "127.0.0.1",
        port: int = 1883,
        credentials: Credentials | None = None,
        tls: Tls | None = None,
        version: Literal["5", "3.1.1"] = "5",
    ) -> None:
        try:
            from paho.mqtt import client as mqtt
        except ImportError as error:
            raise DinerosError(
                "the package for MQTT is not installed", hint="install dineros[mqtt]"
            ) from error
        if topics is None:
            signals = net.structure.signals
            topics = {f"{net.id}/signals/{signal}": signal for signal in signals}
            if signals:
                topics[f"{net.id}/signals"] = signals
        self._net = net
        self._targets: dict[str, str | dict[str, str]] = {}
        for topic, wanted in topics.items():
            _check_filter(topic)
            self._targets[topic] = (
                net.signal(wanted).id
                if isinstance(wanted, str)
                else {alias: net.signal(name).id for name in wanted for alias in (name, net.signal(name).id)}
            )
        self._matches = mqtt.topic_matches_sub
        self._address = (host, port)
        self._subscribed = threading.Event()
        self._ending = threading.Event()
        self._thread: threading.Thread | None = None
        self._version = version
        self._context = tls.client_context() if tls is not None else None
        if credentials is not None and tls is None and not is_own_machine(host):
            LOG.warning("the password for the MQTT broker at %s:%s is sent unencrypted: use TLS", host, port)
        self._credentials = credentials
        self._is_refused = False
        self._client: Any = None
        self._source: Source | None = None

    def open(self) -> None:
        """Begin to listen, as soon as the broker is there."""
        self._ending.clear()
        self._source = self._net.new_source(f"mqtt {self._address[0]}:{self._address[1]}")
        self._client = self._new_client()
        self._thread = threading.Thread(target=self._run, name="dineros mqtt", daemon=True)
        self._thread.start()

    def _new_client(self) -> Any:
        from paho.mqtt import client as mqtt
        from paho.mqtt.enums import CallbackAPIVersion

        client = mqtt.Client(
            CallbackAPIVersion.VERSION2,
            protocol=mqtt.MQTTv5 if self._version == "5" else mqtt.MQTTv311,
        )
        client.reconnect_delay_set(min_delay=1, max_delay=30)
        if self._credentials is not None:
            client.username_pw_set(self._credentials.username, self._credentials.password)
        if self._context is not None:
            client.tls_set_context(self._context)
        client.on_connect = self._connected
        client.on_connect_fail = self._not_connected
        client.on_disconnect = self._disconnected
        client.on_subscribe = self._has_subscribed
        client.on_message = self._heard
        return client

    def _run(self) -> None:
        """Receive messages until `close`, and reconnect after every error."""
        while not self._ending.is_set():
            try:
                self._client.connect_async(*self._address, properties=self._properties())
                self._client.loop_forever(retry_first_connection=True)
            except Exception as error:
                self._failed(f"{type(error).__name__}: {error}")
            self._ending.wait(RETRY_DELAY)

    def _properties(self) -> Any:
        if self._version != "5":
            return None
        from paho.mqtt.packettypes import PacketTypes
        from paho.mqtt.properties import Properties

        new: Any = Properties  # without types
        properties = new(PacketTypes.CONNECT)
        properties.MaximumPacketSize = PACKET_LIMIT
        return properties

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until the bridge has subscribed; return whether it has."""
        return self._subscribed.wait(timeout)

    def close(self) -> None:
        """Stop receiving."""
        self._ending.set()
        if self._thread is not None:
            self._client.disconnect()
            join(self._thread, 10)
            self._thread = None
        if self._source is not None:
            self._net.remove_source(self._source)

    def __enter__(self) -> MqttSignals:
        self.open()
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _failed(self, error: str) -> None:
        assert self._source is not None
        self._subscribed.clear()
        self._source.connected(False)
        self._source.fail(f"the MQTT broker at {self._address[0]}:{self._address[1]}", error)

    def _connected(self, client: Any, data: Any, flags: Any, reason: Any, properties: Any) -> None:
        if self._ending.is_set():
            client.disconnect()
        elif reason.is_failure:
            self._is_refused = True  # the disconnection that follows is not reported
            self._failed(f"refuses: {reason}")
        elif self._targets:
            client.subscribe([(topic, 1) for topic in self._targets])
        else:
            self._subscribed.set()

    def _not_connected(self, client: Any, data: Any) -> None:
        if self._ending.is_set():
            client.disconnect()  # otherwise it would reconnect forever
        else:
            self._failed(f"cannot be reached: {sys.exc_info()[1]}")

    def _disconnected(self, client: Any, data: Any, flags: Any, reason: Any, properties: Any) -> None:
        self._subscribed.clear()
        if reason.is_failure and not self._is_refused:
            self._failed(f"is gone: {reason}")
        self._is_refused = False

    def _has_subscribed(self, client: Any, data: Any, number: Any, reasons: Any, properties: Any) -> None:
        assert self._source is not None
        refused = [topic for topic, reason in zip(self._targets, reasons, strict=False) if reason.is_failure]
        if refused:
            self._failed(f"does not allow this user to subscribe to {', '.join(refused)}")
            return
        self._source.connected(True)
        self._subscribed.set()

    def _heard(self, client: Any, data: Any, message: Any) -> None:
        assert self._source is not None
        what = "an MQTT message"
        try:
            topic, values = message.topic, dict[str, SignalSetting]()
            for known, target in self._targets.items():
                if self._matches(known, topic):
                    what = f"MQTT topic {known}"
                    values |= self._values(target, message.payload)
            if values:
                self._net.set_signals(values, f"mqtt {topic[:255]}")
                self._source.accept()
        except DinerosError as error:
            self._source.refuse(what, error)
        except Exception as error:
            self._source.fail(what, f"{type(error).__name__}: {error}")

    def _values(self, target: str | dict[str, str], payload: bytes) -> dict[str, SignalSetting]:
        if isinstance(target, str):
            return {target: read_setting(payload, self._net.signal(target).values)}

        def known(name: str) -> tuple[str, ...]:
            if name not in target:
                raise SignalValueError(f"{name[:40]!r} is not a signal that this topic sets")
            return self._net.signal(target[name]).values

        return {target[name]: value for name, value in read_signals(payload, known).items()}


def _check_filter(topic: str) -> None:
    """Refuse an invalid topic filter (MQTT 5, section 4.7)."""
    levels = topic.split("/")
    if not topic or "\0" in topic or len(topic.encode("utf-8", "replace")) > 65_535:
        raise DinerosError(f"{topic[:40]!r} is not an MQTT topic")
    if any(("#" in level or "+" in level) and len(level) > 1 for level in levels) or "#" in levels[:-1]:
        raise DinerosError(
            f"{topic[:40]!r} is not an MQTT topic",
            hint="+ stands for a whole level, # for all levels at the end: cell/+/door, cell/#",
        )
