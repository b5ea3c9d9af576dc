"""Models that break the constraints of `sizes`."""

from __future__ import annotations

from tests.support.broken.cases import Cases
from tests.support.broken.small import Small, runtime

CASES = Cases()
WARNING = "make it smaller, unless this size is intended"


@CASES.breaks(
    "size-within-limit",
    "service channel 'ask' has instances 2147483647, more than the limit of 1000",
    "make it smaller, or raise the limit: --limit instances=2147483647",
)
def countless_instances(small: Small) -> None:
    small["ask"].instances = 2**31 - 1


@CASES.breaks(
    "size-within-limit",
    "server port '/serve' of place 'Entry' has instances 1001, more than the limit of 1000",
    "make it smaller, or raise the limit: --limit instances=1001",
    of=runtime,
)
def countless_instances_at_run_time(small: Small) -> None:
    small["Entry"].ports[0].instances = 1001


@CASES.breaks(
    "size-within-limit",
    "token field 'pose' of token type 'Token' has length 2147483647, more than the limit of 1000000",
    "make it smaller, or raise the limit: --limit length=2147483647",
)
def endless_list(small: Small) -> None:
    pose = small.net.tokenType.fields[1]
    pose.default, pose.length = None, 2**31 - 1


@CASES.breaks(
    "size-within-limit",
    "place 'Count' has tokens 2147483647, more than the limit of 100000",
    "make it smaller, or raise the limit: --limit tokens=2147483647",
)
def countless_tokens(small: Small) -> None:
    small["Count"].tokens = 2**31 - 1


@CASES.breaks(
    "size-within-limit",
    "arc 'Idle-Talk' has weight 2147483647, more than the limit of 100000",
    "make it smaller, or raise the limit: --limit weight=2147483647",
)
def arc_that_moves_countless_tokens(small: Small) -> None:
    small["Idle-Talk"].weight = 2**31 - 1


@CASES.breaks(
    "size-within-limit",
    "dispatcher 'listener' of topic channel 'chatter' has limit 2147483647, more than the limit of 1000000",
    "make it smaller, or raise the limit: --limit queue=2147483647",
)
def endless_queue(small: Small) -> None:
    small["chatter"].dispatchers[0].limit = 2**31 - 1


@CASES.breaks(
    "size-within-limit",
    "node net 'talker' has threads 100000, more than the limit of 1000",
    "make it smaller, or raise the limit: --limit threads=100000",
)
def countless_threads(small: Small) -> None:
    small["talker"].threads = 100_000


@CASES.breaks(
    "size-usual",
    "service channel 'ask' has instances 101, which costs memory and time; up to 100 is usual",
    WARNING,
)
def many_instances(small: Small) -> None:
    small["ask"].instances = 101


@CASES.breaks(
    "size-usual",
    "place 'Count' has tokens 1001, which costs memory and time; up to 1000 is usual",
    WARNING,
)
def many_tokens(small: Small) -> None:
    small["Count"].tokens = 1001
