"""The environment of ROS processes: which machines they reach, and where they log.

By default, Fast DDS binds sockets on all interfaces of the machine, even if ROS is restricted to the machine.
A profile file restricts it to shared memory or to 127.0.0.1 (Fast DDS, "XML profiles").
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.atomic import write_atomically

Reach = Literal["memory", "machine", "network"]
"""Reach of ROS processes: shared memory only, this machine only, or no restriction."""

DOMAINS = range(102)
"""Domains whose ports are free on every system (ROS 2, "The ROS_DOMAIN_ID")."""

_TRANSPORTS = {
    "memory": [("memory", "<type>SHM</type>")],
    "machine": [
        (
            "loopback",
            "<type>UDPv4</type><maxInitialPeersRange>100</maxInitialPeersRange>"
            "<interfaceWhiteList><address>127.0.0.1</address></interfaceWhiteList>",
        ),
        ("memory", "<type>SHM</type>"),
    ],
}


# Peers are contacted one by one: by default Fast DDS would listen to a multicast address.
_UNICAST = {
    "memory": "",
    "machine": "        <builtin>\n"
    "          <metatrafficUnicastLocatorList><locator/></metatrafficUnicastLocatorList>\n"
    "          <initialPeersList>\n"
    "            <locator><udpv4><address>127.0.0.1</address></udpv4></locator>\n"
    "          </initialPeersList>\n"
    "        </builtin>\n",
}


def fast_dds_profile(reach: Literal["memory", "machine"]) -> str:
    """Return the profile file that restricts Fast DDS to this machine."""
    transports = _TRANSPORTS[reach]
    described = "".join(
        f"      <transport_descriptor><transport_id>{name}</transport_id>{text}</transport_descriptor>\n"
        for name, text in transports
    )
    used = "".join(f"<transport_id>{name}</transport_id>" for name, _ in transports)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<dds xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles">\n'
        "  <profiles>\n"
        f"    <transport_descriptors>\n{described}    </transport_descriptors>\n"
        '    <participant profile_name="dineros" is_default_profile="true">\n'
        f"      <rtps>\n{_UNICAST[reach]}"
        f"        <userTransports>{used}</userTransports>\n"
        "        <useBuiltinTransports>false</useBuiltinTransports>\n"
        "      </rtps>\n"
        "    </participant>\n"
        "  </profiles>\n"
        "</dds>\n"
    )


def ros_environment(
    folder: Path, domain: int, reach: Reach = "memory", base: Mapping[str, str] | None = None
) -> dict[str, str]:
    """Return the environment for ROS processes that communicate only with each other.

    Parameters
    ----------
    folder : Path
        Folder for the profile file and ROS's logs; created if it does not exist.
    domain : int
        The ROS domain, 0 to 101; processes of other domains are not visible.
    reach : {"memory", "machine", "network"}
        Reach of the processes; ``network`` changes nothing in `base`.
    base : mapping of str to str, optional
        The environment to extend; by default that of this process.

    Raises
    ------
    DinerosError
        The domain is out of range, or the folder cannot be written.
    """
    if domain not in DOMAINS:
        raise DinerosError(f"there is no ROS domain {domain}", hint="take one from 0 to 101")
    environment = dict(os.environ if base is None else base)
    logs = folder / "ros_log"
    try:
        logs.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DinerosError(f"the folder {logs} cannot be made: {error.strerror}") from error
    environment["ROS_DOMAIN_ID"] = str(domain)
    environment["ROS_LOG_DIR"] = str(logs.resolve())
    if reach == "network":
        return environment
    profile = folder / f"fast_dds_{reach}.xml"
    write_atomically(profile, fast_dds_profile(reach).encode())
    environment["RMW_IMPLEMENTATION"] = "rmw_fastrtps_cpp"
    # LOCALHOST would make Fast DDS ignore the profile's transports.
    environment["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SYSTEM_DEFAULT"
    environment["FASTRTPS_DEFAULT_PROFILES_FILE"] = str(profile.resolve())
    environment["FASTDDS_DEFAULT_PROFILES_FILE"] = str(profile.resolve())
    environment.pop("ROS_STATIC_PEERS", None)
    return environment
