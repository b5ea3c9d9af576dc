"""Models that break the constraints of `bounds`."""

from __future__ import annotations

from dineros.metamodel import sym
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small, flat, plain

CASES = Cases()


@CASES.breaks(
    "required-feature",
    "arc 'p-t' has no source",
    "set its source",
    of=plain,
)
def arc_without_source(small: Small) -> None:
    small["p-t"].source = None


@CASES.breaks(
    "required-feature",
    "arc 'p-t' has no weight",
    "set its weight",
    of=plain,
)
def weight_set_to_none(small: Small) -> None:
    small["p-t"].weight = None


@CASES.breaks(
    "required-feature",
    "topic channel 'chatter' has no topic",
    "set its topic",
)
def topic_is_empty(small: Small) -> None:
    small["chatter"].topic = ""


@CASES.breaks(
    "required-feature",
    "reference place 'pr' has no target",
    "set its target",
    of=plain,
)
def reference_without_target(small: Small) -> None:
    small["pr"].target = None


@CASES.breaks(
    "required-feature",
    "place invariant 'Load + Capacity = 3' of petri net model 'flat' has no terms",
    "set its terms",
    of=flat,
)
def invariant_without_terms(small: Small) -> None:
    small.net.certificate[0].terms.clear()


@CASES.breaks(
    "required-feature",
    "service channel 'ask' has no server",
    "set its server",
)
def service_without_server(small: Small) -> None:
    small["ask"].server = None
    small["serve"].kind = "timer"
    small["serve"].timer = 1.0


@CASES.breaks(
    "number-range",
    "place 'p' has a number out of range: tokens (64 bits)",
    "use one from -2147483648 to 2147483647",
    of=plain,
)
def tokens_of_64_bits(small: Small) -> None:
    small["p"].tokens = 2**63


@CASES.breaks(
    "text-is-writable",
    "place 'p' has characters in its name that no file can hold",
    "remove the control characters",
    of=plain,
)
def name_with_a_control_character(small: Small) -> None:
    small["p"].name = "bell\a"


@CASES.breaks(
    "target-in-model",
    "arc 't-q' refers to place 'q' (target), which is not in the model",
    "add it to the model, or end the reference",
    of=plain,
)
def arc_to_a_place_that_is_gone(small: Small) -> None:
    small["left"].objects.remove(small["q"])


@CASES.breaks(
    "target-in-model",
    "publisher port 'Lost' of topic channel 'chatter' refers to place 'Lost' (place), which is not "
    "in the model",
    "add it to the model, or end the reference",
)
def port_at_a_place_that_is_gone(small: Small) -> None:
    small["talker"].objects.append(sym.Place(id="Lost"))
    small["chatter"].publishers[0].place = (lost := small["Lost"])
    small["talker"].objects.remove(lost)


@CASES.breaks(
    "target-in-model",
    "input signal 'Open' refers to literal 'Open' of disjunction of input clause (literals), which "
    "is not in the model",
    "add it to the model, or end the reference",
)
def signal_of_a_clause_that_is_gone(small: Small) -> None:
    small["Serve"].clause = None
