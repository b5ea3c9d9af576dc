"""TLS, credentials and tokens, with a real broker and real servers; secrets are shown to nobody."""

from __future__ import annotations

import http.server
import json
import logging
import ssl
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

from dineros.metamodel.errors import DinerosError
from dineros.runtime.bridges.mqtt import MqttSignals
from dineros.runtime.bridges.rest import RestPoll, RestServer
from dineros.runtime.bridges.security import Credentials, SecurityError, Tls, shown_url
from dineros.runtime.nodes.net import Net
from tests.runtime.bridges.broker import PATIENCE, Broker

SECRET = "s3cret"


def is_told(net: Net, text: str) -> None:
    """Wait until the only bridge says that this went wrong."""
    net.wait_for(lambda state: text in str(state.sources[0].last_error), PATIENCE)


class TestMqtt:
    @pytest.fixture
    def safe_broker(self, tmp_path: Path, broker: Broker, certificates: Path) -> Iterator[Broker]:
        """A broker that wants TLS, a password and a certificate of the client."""
        passwords = tmp_path / "passwords"
        subprocess.run(
            ["mosquitto_passwd", "-b", "-c", str(passwords), "cell", SECRET], check=True, capture_output=True
        )
        made = Broker(
            tmp_path,
            f"allow_anonymous false\npassword_file {passwords}\nrequire_certificate true\n"
            f"cafile {certificates / 'ca.pem'}\ncertfile {certificates / 'server.pem'}\n"
            f"keyfile {certificates / 'server.pem'}\n",
        )
        yield made
        made.stop()

    @pytest.mark.parametrize("version", ["5", "3.1.1"])
    def test_tls_and_password(
        self, net: Net, safe_broker: Broker, certificates: Path, tmp_path: Path, version: str
    ) -> None:
        file = tmp_path / "credentials.json"
        file.write_text(json.dumps({"username": "cell", "password": SECRET}))
        file.chmod(0o600)
        tls = Tls(certificates / "ca.pem", certificates / "client.pem", certificates / "client.pem")
        with MqttSignals(
            net,
            port=safe_broker.port,
            credentials=Credentials.from_file(file),
            tls=tls,
            version=version,  # type: ignore[arg-type]
        ) as bridge:
            assert bridge.wait(PATIENCE)
            safe_broker.publish(
                "talker/signals/Button",
                "true",
                auth={"username": "cell", "password": SECRET},
                tls={name: str(certificates / f"{file}.pem") for name, file in _FILES.items()},
            )
            net.wait_for(lambda state: state.signals["Button"], PATIENCE)

    def test_wrong_password_and_wrong_authority(
        self, net: Net, safe_broker: Broker, certificates: Path, caplog: pytest.LogCaptureFixture
    ) -> None:
        own = certificates / "client.pem"
        for ca, password, told in (
            ("ca", "wrong-one", "refuses: Not authorized"),
            ("other", SECRET, "verify failed"),
        ):
            credentials = Credentials("cell", password)
            tls = Tls(certificates / f"{ca}.pem", own, own)
            with MqttSignals(net, port=safe_broker.port, credentials=credentials, tls=tls) as bridge:
                is_told(net, told)
                assert not bridge.wait(0)
                assert not net.inspect().sources[0].is_connected
        assert SECRET not in caplog.text
        assert "wrong-one" not in caplog.text


_FILES = {"ca_certs": "ca", "certfile": "client", "keyfile": "client"}


class TestRestServer:
    def test_token(self, net: Net, caplog: pytest.LogCaptureFixture) -> None:
        with RestServer(net, port=0, credentials=Credentials(token=SECRET)) as server:
            for header in (None, "Bearer", "Bearer wrong", f"bearer{SECRET}", f"Basic {SECRET}", "Bearer é"):
                headers = {} if header is None else {"Authorization": header.encode()}
                for answer in (
                    httpx.get(f"{server.url}/signals", headers=headers),  # type: ignore[arg-type]
                    httpx.put(f"{server.url}/signals/Button", headers=headers, content="true"),  # type: ignore[arg-type]
                ):
                    assert (answer.status_code, answer.headers["WWW-Authenticate"]) == (401, "Bearer")
            assert not net.inspect().signals["Button"]
            right = {"Authorization": f"Bearer {SECRET}"}
            assert httpx.put(f"{server.url}/signals", headers=right, json={"Button": True}).is_success
            with RestPoll(
                net, {"Button": f"{server.url}/signals/Button"}, credentials=Credentials(token=SECRET)
            ):
                net.wait_for(
                    lambda state: len(state.sources) == 2 and state.sources[1].is_connected, PATIENCE
                )
        assert SECRET not in caplog.text

    def test_https(self, net: Net, certificates: Path, server_tls: Tls) -> None:
        with RestServer(net, port=0, tls=server_tls) as server:
            assert server.url.startswith("https://")
            net.signal("Button").set(True)
            with RestPoll(
                net, {"Button": f"{server.url}/signals/Button"}, tls=Tls(certificates / "ca.pem"), period=0.05
            ):
                net.wait_for(lambda state: state.sources[-1].is_connected, PATIENCE)
            with RestPoll(
                net, {"Button": f"{server.url}/signals/Button"}, tls=Tls(certificates / "other.pem")
            ):
                net.wait_for(lambda state: "VERIFY_FAILED" in str(state.sources[-1].last_error), PATIENCE)

    def test_clients_with_certificates(self, net: Net, certificates: Path) -> None:
        own = certificates / "server.pem"
        with RestServer(net, port=0, tls=Tls(certificates / "ca.pem", own, own)) as server:
            client = certificates / "client.pem"
            for tls, is_let_in in (
                (Tls(certificates / "ca.pem"), False),
                (Tls(certificates / "ca.pem", client, client), True),
            ):
                with RestPoll(net, {"Button": f"{server.url}/signals/Button"}, tls=tls, period=0.05):
                    net.wait_for(
                        lambda state, expected=is_let_in: (  # type: ignore[misc]
                            state.sources[-1].is_connected if expected else state.sources[-1].failures > 0
                        ),
                        PATIENCE,
                    )

    def test_it_is_said_what_is_open(self, net: Net, caplog: pytest.LogCaptureFixture) -> None:
        RestServer(net, host="0.0.0.0", port=0)
        assert "everyone who can reach 0.0.0.0:0 can set the signals of talker" in caplog.text
        with pytest.raises(SecurityError, match="have a token"):
            RestServer(net, credentials=Credentials("a", "b"))


class TestSecretsOfAddresses:
    def test_neither_logged_nor_recorded(self, net: Net, caplog: pytest.LogCaptureFixture) -> None:
        """User, password and query reach the server and nobody else, also at the lowest level of logs."""
        caplog.set_level(logging.DEBUG)
        asked: list[tuple[str, str | None]] = []
        answer = [b"true"]

        class Handler(http.server.BaseHTTPRequestHandler):
            def log_message(self, *arguments: object) -> None:
                pass

            def do_GET(self) -> None:
                asked.append((self.path, self.headers["Authorization"]))
                self.send_response(200)
                self.end_headers()
                self.wfile.write(answer[0])

        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        told: list[str] = []
        net.on_change(lambda change: told.append(repr(change.fields)))
        url = f"http://robot:{SECRET}@127.0.0.1:{server.server_port}/x?token=hush"
        with RestPoll(net, {"Button": url}, period=0.01):
            net.wait_for(lambda state: state.signals["Button"], PATIENCE)
            answer[0] = b"nonsense"
            net.wait_for(lambda state: state.sources[0].failures > 0, PATIENCE)
            shown = repr(net.inspect().sources)
        server.shutdown()
        server.server_close()
        assert asked[0] == ("/x?token=hush", "Basic cm9ib3Q6czNjcmV0")
        told_of = caplog.text + shown + "".join(told)
        assert f"http://127.0.0.1:{server.server_port}/x" in told_of
        for secret in (SECRET, "hush", "robot", "cm9ib3Q6czNjcmV0"):
            assert secret not in told_of

    @pytest.mark.parametrize(
        "url", ["", "ftp://robot:s3cret@a/", "http://", "http://robot:s3cret@[::1", "http://a b:s3cret@c:x/"]
    )
    def test_no_address(self, net: Net, url: str) -> None:
        with pytest.raises(SecurityError) as caught:
            RestPoll(net, {"Button": url})
        assert SECRET not in str(caught.value)

    def test_shown(self) -> None:
        assert shown_url("https://a:b@plc:8443/door?c=d#e") == "https://plc:8443/door"


class TestCredentials:
    def test_environment(self) -> None:
        environment = {"CELL_USERNAME": "cell", "CELL_PASSWORD": SECRET}
        found = Credentials.from_environment("CELL", environment)
        assert (found.username, found.password, found.token) == ("cell", SECRET, None)
        assert SECRET not in repr(found)
        with pytest.raises(SecurityError, match="has none of CELL_USERNAME, CELL_PASSWORD, CELL_TOKEN"):
            Credentials.from_environment("CELL", {})

    def test_file_for_all_to_read(self, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
        file = tmp_path / "token.json"
        file.write_text(json.dumps({"token": SECRET}))
        file.chmod(0o644)
        assert Credentials.from_file(file).token == SECRET
        assert "other users of this machine can read these credentials" in caplog.text

    @pytest.mark.parametrize(
        "text",
        ["", "s3cret", "{}", '{"token": 1}', '{"token": ""}', '{"tokn": "s3cret"}', '{"token": "s3cret\\n"}'],
        ids=range(7),
    )
    def test_wrong_files(self, tmp_path: Path, text: str) -> None:
        file = tmp_path / "token.json"
        file.write_text(text)
        file.chmod(0o600)
        with pytest.raises(DinerosError) as caught:
            Credentials.from_file(file)
        assert SECRET not in str(caught.value)
        with pytest.raises(DinerosError):
            Credentials.from_file(tmp_path / "nowhere")

    def test_certificates_that_are_none(self, tmp_path: Path, certificates: Path) -> None:
        nonsense = tmp_path / "nonsense.pem"
        nonsense.write_text("nonsense")
        for tls in (Tls(ca=nonsense), Tls(ca=tmp_path / "nowhere"), Tls(certificate=nonsense, key=nonsense)):
            with pytest.raises(DinerosError):
                tls.client_context()
        for tls in (Tls(), Tls(certificate=certificates / "server.pem"), Tls(nonsense, nonsense, nonsense)):
            with pytest.raises(DinerosError):
                tls.server_context()
        context = Tls(certificates / "ca.pem").client_context()
        assert (context.verify_mode, context.check_hostname) == (ssl.CERT_REQUIRED, True)
        assert context.minimum_version >= ssl.TLSVersion.TLSv1_2
