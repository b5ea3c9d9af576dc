"""Security of bridges: credentials, TLS, and URLs without secrets for messages.

Secrets come from a file or from the environment, never from a command line, which each user of the machine
can read. They are sent only to the other end: no log, trace, error or ``repr`` shows them.
"""

from __future__ import annotations

import ipaddress
import logging
import os
import ssl
import stat
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn
from urllib.parse import urlsplit

from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.files.reading import read_bytes
from dineros.metamodel.json_text import decode_json

LOG = logging.getLogger("dineros.runtime.bridges")
_PARTS = ("username", "password", "token")


class SecurityError(DinerosError):
    """Credentials or certificates cannot be used."""


@dataclass(frozen=True)
class Credentials:
    """A user's name and password, or a token; never shown.

    Attributes
    ----------
    username, password : str, optional
        For an MQTT broker, and for HTTP's basic authentication (RFC 7617).
    token : str, optional
        For HTTP's bearer authentication (RFC 6750).
    """

    username: str | None = None
    password: str | None = field(default=None, repr=False)
    token: str | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        for name in _PARTS:
            value = getattr(self, name)
            if value is not None and not (isinstance(value, str) and value and value.isprintable()):
                raise SecurityError(f"the {name} is empty or has characters that cannot be sent")
        if self.token is not None and not (self.token.isascii() and " " not in self.token):
            raise SecurityError("the token has characters that cannot be sent", hint="RFC 6750, section 2.1")
        if self.username is not None and ":" in self.username:
            raise SecurityError("the username has a colon, which cannot be sent", hint="RFC 7617, section 2")

    @classmethod
    def from_file(cls, path: Path | str) -> Credentials:
        """Read them from a JSON file: ``{"username": "cell", "password": "..."}`` or ``{"token": "..."}``.

        Raises
        ------
        DinerosError
            The file cannot be read, or has another form.
        """
        location = Location(path)
        found = decode_json(read_bytes(path, limit=64 * 1024), location=location, keys_once=True)
        if not isinstance(found, dict) or not found or not set(found) <= set(_PARTS):
            raise SecurityError(
                "holds no credentials",
                location=location,
                hint='such as {"username": "...", "password": "..."}',
            )
        if Path(path).stat().st_mode & (stat.S_IRGRP | stat.S_IROTH):
            LOG.warning("%s: other users of this machine can read these credentials (chmod 600)", path)
        try:
            return cls(**found)
        except SecurityError as error:
            raise SecurityError(str(error), location=location) from None

    @classmethod
    def from_environment(
        cls, prefix: str = "DINEROS", environment: Mapping[str, str] = os.environ
    ) -> Credentials:
        """Read them from ``PREFIX_USERNAME``, ``PREFIX_PASSWORD`` and ``PREFIX_TOKEN``.

        Raises
        ------
        SecurityError
            None of them is set.
        """
        names = {part: f"{prefix}_{part.upper()}" for part in _PARTS}
        found = {part: environment[name] for part, name in names.items() if name in environment}
        if not found:
            raise SecurityError(f"the environment has none of {', '.join(names.values())}")
        return cls(**found)


@dataclass(frozen=True)
class Tls:
    """Certificates, as PEM files.

    Attributes
    ----------
    ca : Path, optional
        Trusted authorities. A client without this trusts those of the system; a server with this accepts only
        clients with a certificate from one of them.
    certificate, key : Path, optional
        Own certificate, with its chain, and key; a server needs both. The key is not encrypted, but its file
        may be readable only for its owner's group.
    """

    ca: Path | str | None = None
    certificate: Path | str | None = None
    key: Path | str | None = None

    def client_context(self) -> ssl.SSLContext:
        """Return the context of a client: TLS 1.2 or later; the server's certificate and name are checked.

        Raises
        ------
        SecurityError
            A file cannot be read or used.
        """
        context = ssl.create_default_context()
        if self.ca is not None:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
            self._trust(context)
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        if self.certificate is not None:
            self._own(context)
        return context

    def server_context(self) -> ssl.SSLContext:
        """Return the context of a server: TLS 1.2 or later.

        Raises
        ------
        SecurityError
            A file is missing, or cannot be read or used.
        """
        if self.certificate is None or self.key is None:
            raise SecurityError("a server needs a certificate and its key")
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        self._own(context)
        if self.ca is not None:
            self._trust(context)
            context.verify_mode = ssl.CERT_REQUIRED
        return context

    def _trust(self, context: ssl.SSLContext) -> None:
        assert self.ca is not None
        try:
            context.load_verify_locations(cadata=read_bytes(self.ca).decode("ascii"))
        except (ssl.SSLError, ValueError) as error:
            raise SecurityError(f"holds no certificates: {error}", location=Location(self.ca)) from None

    def _own(self, context: ssl.SSLContext) -> None:
        assert self.certificate is not None
        for path in (self.certificate, self.key):
            if path is not None:
                read_bytes(path)  # its errors name the file

        def refuse() -> NoReturn:  # otherwise OpenSSL asks at the terminal
            raise SecurityError("the key is encrypted", hint="give a key without a passphrase")

        try:
            context.load_cert_chain(self.certificate, self.key, password=refuse)
        except (ssl.SSLError, OSError) as error:
            raise SecurityError(
                f"is not a certificate with its key: {error}", location=Location(self.certificate)
            ) from None


def shown_url(url: str) -> str:
    """Return a URL without user, password, query and fragment.

    Examples
    --------
    >>> shown_url("https://robot:secret@plc:8443/door?token=abc")
    'https://plc:8443/door'
    """
    parts = urlsplit(url)
    return f"{parts.scheme}://{parts.netloc.rpartition('@')[2]}{parts.path}"


def is_own_machine(host: str) -> bool:
    """Return whether a host name is this machine's: traffic to it does not leave the machine."""
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host.lower() == "localhost"
