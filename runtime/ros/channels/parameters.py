"""The parameters of a node: declared with description and range, set by launch files or ``--ros-args``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.ros_names import resource_names
from dineros.runtime.ros.process.session import RosError
from dineros.runtime.scheduling.watchdog import LIMIT


@dataclass(frozen=True)
class Parameter:
    """A parameter.

    Attributes
    ----------
    name : str
        Its name in ROS.
    default : bool, int, float or str
        Its default value, which also determines the type.
    description : str
        What it does.
    least, most : int or float, optional
        Its range, for numbers.
    is_any : bool
        Whether values of other types are accepted, too.
    is_fixed : bool
        Whether it can be set only at the start.
    """

    name: str
    default: bool | int | float | str
    description: str
    least: float | None = None
    most: float | None = None
    is_any: bool = False
    is_fixed: bool = True


REQUEST_TIMEOUT = Parameter(
    "request_timeout",
    5.0,
    "Seconds after which a request without response is recorded as timed out and sent again.",
    0.01,
    86400.0,
)
DISCOVERY_TIMEOUT = Parameter(
    "discovery_timeout",
    10.0,
    "Seconds that the node waits at its start until its publishers have as many subscribers as expected.",
    0.0,
    3600.0,
)
JOURNAL = Parameter("journal", "", "Folder for the records of the run; empty: nothing is recorded.")
RESUME = Parameter("resume", True, "Whether to continue from the journal if it holds an earlier run.")
WATCHDOG = Parameter(
    "watchdog",
    LIMIT,
    "Seconds after which a handler that blocks its node is reported; 0: never.",
    0.0,
    86400.0,
)
SEED = Parameter("seed", -1, "Seed of the firing selection; -1: another one in each run.", -1, 2**32 - 1)
DIAGNOSTICS_PERIOD = Parameter(
    "diagnostics_period",
    1.0,
    "Seconds between two reports of the node's state on /diagnostics; 0: no reports.",
    0.0,
    3600.0,
)
METRICS_PORT = Parameter(
    "metrics_port", 0, "Port on 127.0.0.1 where Prometheus finds the node's metrics; 0: none.", 0, 65535
)
LOG_LEVEL = Parameter(
    "log_level",
    "info",
    "Least severity that is logged: debug, info, warn, error or fatal; can be changed while the node runs.",
    is_fixed=False,
)


def signal_parameters(signals: Iterable[tuple[str, SignalSetting]]) -> dict[str, Parameter]:
    """Return the parameter for the start value of each signal, by the signal's id."""
    initial = dict(signals)
    names = resource_names(initial)
    return {
        id: Parameter(f"signals.{names[id]}", value, f"Value of the input signal {id} at the start.")
        for id, value in initial.items()
    }


def stale_parameters(signals: Mapping[str, Sequence[str]]) -> dict[str, tuple[Parameter, Parameter]]:
    """Return the parameters for a silent source of each signal, by its id: the time, and what is done.

    Parameters
    ----------
    signals : mapping of str to sequence of str
        Ids of the signals, with the names of their values.
    """
    choices = {id: " or ".join(values or ("true", "false")) for id, values in signals.items()}
    return {
        id: (
            Parameter(
                f"stale_after.{name}",
                0.0,
                f"Seconds after which {id} is stale if it is not set; 0: never.",
                0.0,
                86400.0 * 365,
            ),
            Parameter(
                f"when_stale.{name}",
                "keep",
                f"Reaction if {id} is stale: keep its value, stop the net, or {choices[id]}.",
                is_any=True,
            ),
        )
        for id, name in resource_names(signals).items()
    }


def subscriber_parameters(channels: Iterable[str]) -> dict[str, Parameter]:
    """Return the parameter for the number of expected subscribers of each published topic, by channel id."""
    return {
        id: Parameter(
            f"expected_subscribers.{name}",
            0,
            f"Number of subscribers to {id} that the node waits for at its start.",
            0,
            1000,
        )
        for id, name in resource_names(channels).items()
    }


def period_parameters(timers: Iterable[tuple[str, float]]) -> dict[str, Parameter]:
    """Return the parameter for the period of each timer, by the id of its callback page."""
    periods = dict(timers)
    return {
        id: Parameter(
            f"periods.{name}",
            float(periods[id]),
            f"Seconds between two ticks of the timer of the callback {id}.",
            1e-9,
            1e9,
        )
        for id, name in resource_names(periods).items()
    }


def declare(node: Any, parameter: Parameter) -> Any:
    """Declare a parameter of a ROS node and return its value.

    An integer is accepted for a floating-point number: `5` for `5.0`, as usual on a command line.

    Raises
    ------
    RosError
        Its value is out of range or of another type.
    """
    from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
    from rclpy.exceptions import InvalidParameterTypeException, ParameterException

    if node.has_parameter(parameter.name):
        return node.get_parameter(parameter.name).value
    descriptor = ParameterDescriptor(
        description=parameter.description, read_only=parameter.is_fixed, dynamic_typing=parameter.is_any
    )
    if parameter.least is not None and parameter.most is not None:
        if isinstance(parameter.default, float):
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=float(parameter.least), to_value=float(parameter.most))
            ]
        else:
            descriptor.integer_range = [
                IntegerRange(from_value=int(parameter.least), to_value=int(parameter.most), step=1)
            ]
    try:
        try:
            return node.declare_parameter(parameter.name, parameter.default, descriptor).value
        except InvalidParameterTypeException:
            given = _integer(node, parameter)
            if given is None:
                raise
            return node.declare_parameter(parameter.name, given, descriptor, ignore_override=True).value
    except ParameterException as error:
        raise RosError(
            f"the parameter {parameter.name} cannot have the given value: {error}",
            hint=parameter.description,
        ) from error


def _integer(node: Any, parameter: Parameter) -> float | None:
    """Return the integer value of a floating-point parameter; None: its value is not an integer."""
    from rcl_interfaces.msg import ParameterDescriptor

    if not isinstance(parameter.default, float):
        return None
    free = ParameterDescriptor(dynamic_typing=True)
    value = node.declare_parameter(parameter.name, parameter.default, free).value
    node.undeclare_parameter(parameter.name)
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else None
