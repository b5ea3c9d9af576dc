"""Models that break the constraints of `guards`."""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.build import read
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small

CASES = Cases()

GUARD = "write a condition over fields of tokens that it takes or reads, such as Response.success = false"
ASSIGNED = "assign a value or a field to a field of a token that it puts: Answer.success := true"


def _with_fields(small: Small) -> Small:
    small["Token"].fields.extend(
        [
            sym.TokenField(name="ok", kind="boolean"),
            sym.TokenField(name="mode", kind="integer", values="IDLE=0, BUSY=1"),
        ]
    )
    return small


@CASES.breaks(
    "guard-usable",
    "transition 'Done' has a guard that cannot be used: column 4 has '!', which is not allowed there",
    "write not, or <> between two values",
)
def no_condition(small: Small) -> None:
    _with_fields(small)["Done"].guard = "ok ! false"


@CASES.breaks(
    "guard-usable",
    "transition 'Done' has a guard that cannot be used: no place has a field 'okay'",
    "did you mean 'ok'?",
)
def unknown_field(small: Small) -> None:
    _with_fields(small)["Done"].guard = "okay = false"


@CASES.breaks(
    "guard-usable",
    "transition 'Done' has a guard that cannot be used: the transition takes no 'Idle'",
    "its places are Answer",
)
def place_that_is_put(small: Small) -> None:
    _with_fields(small)["Done"].guard = "Idle.ok = false"


@CASES.breaks(
    "guard-usable",
    "transition 'Done' has a guard that cannot be used: the field 'text' is neither a boolean nor an integer",
    "use a boolean or an integer",
)
def field_that_is_a_text(small: Small) -> None:
    _with_fields(small)["Token"].fields.append(sym.TokenField(name="text"))
    small["Done"].guard = "text = 'x'"


@CASES.breaks(
    "guard-usable",
    "transition 'Done' has a guard that cannot be used: no token of Answer can fulfil it",
    "its fields have values: ok: false|true",
)
def contradiction(small: Small) -> None:
    _with_fields(small)["Done"].guard = "ok = true and Answer.ok = false"


@CASES.breaks(
    "guard-usable",
    "transition 'Done' has a guard that cannot be used: the field 'mode' has no value 'BUZY'",
    "did you mean 'BUSY'?",
)
def unknown_value(small: Small) -> None:
    _with_fields(small)["Done"].guard = "mode = 'BUZY'"


@CASES.breaks(
    "guard-usable",
    "transition 'Done' has a guard that cannot be used: the field 'ok' takes true or false, not 1",
    GUARD,
)
def number_for_a_truth_value(small: Small) -> None:
    _with_fields(small)["Done"].guard = "ok = 1"


@CASES.breaks(
    "guard-usable",
    "transition 'Done' has a guard that cannot be used: one part compares fields of Answer and Idle",
    "join conditions about different places by 'and' only",
)
def places_in_one_part(small: Small) -> None:
    done = _with_fields(small)["Done"]
    read(small["Idle"], done)
    done.guard = "Answer.ok = true or Idle.ok = true"


@CASES.breaks(
    "guard-usable",
    "transition 'Done' has a guard that cannot be used: it asks about Answer, of which the transition takes "
    "or reads 2 tokens",
    "let it take or read one token, by one arc",
)
def two_tokens(small: Small) -> None:
    done = _with_fields(small)["Done"]
    done.incoming[0].weight = 2
    done.guard = "ok = true"


@CASES.breaks(
    "assignments-usable",
    "transition 'Done' has assignments that cannot be used: Idle.mode cannot be 2",
    ASSIGNED,
)
def value_out_of_range(small: Small) -> None:
    _with_fields(small)["Done"].assigns = "Idle.mode := 2"


@CASES.breaks(
    "assignments-usable",
    "transition 'Done' has assignments that cannot be used: it assigns Idle.ok twice",
    ASSIGNED,
)
def assigned_twice(small: Small) -> None:
    _with_fields(small)["Done"].assigns = "Idle.ok := true, ok := Answer.ok"


@CASES.breaks(
    "assignments-usable",
    "transition 'Done' has assignments that cannot be used: Answer.wide has values that "
    "Idle.mode cannot have",
    "give both fields the same range",
)
def copy_of_a_wider_field(small: Small) -> None:
    done = _with_fields(small)["Done"]
    small["Token"].fields.append(sym.TokenField(name="wide", kind="integer", minimum=0, maximum=3))
    done.assigns = "Idle.mode := Answer.wide"


@CASES.breaks(
    "guard-not-sent",
    "transition 'Done' has a guard about tokens that a port sends: place 'Ask'",
    "put the guard on the transition before it, about the token that this one takes",
)
def guard_about_a_request(small: Small) -> None:
    done = _with_fields(small)["Done"]
    read(small["Ask"], done)
    done.guard = "Ask.ok = true"
