"""Models that break the constraints of `tokens`."""

from __future__ import annotations

from dineros.metamodel import sym
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small

CASES = Cases()


@CASES.breaks(
    "field-unique",
    "token field 'tag' of token type 'Token' has the name of another field",
    "give it another name",
)
def same_name(small: Small) -> None:
    small["Token"].fields.append(sym.TokenField(name="tag"))


@CASES.breaks(
    "field-name-valid",
    "token field 'the pose' of token type 'Token' has no name that Python and ROS interfaces can use",
    "use letters, digits and _, starting with a letter, that is not a keyword",
)
def blank(small: Small) -> None:
    small["Token"].fields[1].name = "the pose"


@CASES.breaks(
    "field-name-valid",
    "token field 'class' of token type 'Token' has no name that Python and ROS interfaces can use",
    "use letters, digits and _, starting with a letter, that is not a keyword",
)
def keyword(small: Small) -> None:
    small["Token"].fields[1].name = "class"


@CASES.breaks(
    "field-length",
    "token field 'tag' of token type 'Token' of the kind text has the length 3",
    "use a length of 1 or more, for lists only",
)
def text_with_a_length(small: Small) -> None:
    small["Token"].fields[2].length = 3


@CASES.breaks(
    "field-length",
    "token field 'empty' of token type 'Token' of the kind list has the length 0",
    "use a length of 1 or more, for lists only",
)
def length_0(small: Small) -> None:
    small["Token"].fields.append(sym.TokenField(name="empty", kind="list", length=0))


@CASES.breaks(
    "field-elements-simple",
    "token field 'deep' of token type 'Token' is a list of elements of the kind list",
    "use text, integer, number or boolean elements",
)
def list_of_lists(small: Small) -> None:
    small["Token"].fields.append(sym.TokenField(name="deep", kind="list", elementKind="list"))


@CASES.breaks(
    "field-default-fits",
    "token field 'count' of token type 'Token' has a default that does not fit: count takes an "
    'integer, not "many"',
    "write the default as JSON of the field's kind",
)
def text_for_an_integer(small: Small) -> None:
    small["Token"].fields[0].default = '"many"'


@CASES.breaks(
    "field-default-fits",
    "token field 'count' of token type 'Token' has a default that does not fit: no JSON at column "
    "2: Extra data",
    "write the default as JSON of the field's kind",
)
def no_json(small: Small) -> None:
    small["Token"].fields[0].default = "1,"


@CASES.breaks(
    "field-default-fits",
    "token field 'pose' of token type 'Token' has a default that does not fit: pose takes 2 elements, not 1",
    "write the default as JSON of the field's kind",
)
def wrong_length(small: Small) -> None:
    small["Token"].fields[1].default = "[1]"


@CASES.breaks(
    "balloon-fits",
    "balloon token 1 of place 'Idle' does not fit the token type: no JSON at column 2: Expecting "
    "property name enclosed in double quotes",
    "write a JSON object with fields of the token type",
)
def no_json_2(small: Small) -> None:
    small["Idle"].balloons[0].data = "{count: 3}"


@CASES.breaks(
    "balloon-fits",
    "balloon token 1 of place 'Idle' does not fit the token type: no JSON object",
    'write {"field": value}',
)
def no_object(small: Small) -> None:
    small["Idle"].balloons[0].data = "[3]"


@CASES.breaks(
    "balloon-fits",
    "balloon token 1 of place 'Idle' does not fit the token type: the token type has no field 'cuont'",
    "did you mean 'count'?",
)
def unknown_field(small: Small) -> None:
    small["Idle"].balloons[0].data = '{"cuont": 3}'


@CASES.breaks(
    "balloon-fits",
    "balloon token 1 of place 'Idle' does not fit the token type: count takes an integer, not 1.5",
    "write a JSON object with fields of the token type",
)
def wrong_kind(small: Small) -> None:
    small["Idle"].balloons[0].data = '{"count": 1.5}'


@CASES.breaks(
    "balloon-fits",
    "balloon token 1 of place 'Idle' does not fit the token type: pose[1] takes a number, not \"north\"",
    "write a JSON object with fields of the token type",
)
def wrong_element(small: Small) -> None:
    small["Idle"].balloons[0].data = '{"pose": [1, "north"]}'


@CASES.breaks(
    "balloon-fits",
    "balloon token 1 of place 'Idle' does not fit the token type: no JSON: nested too deep",
    "write a JSON object with fields of the token type",
)
def nested_too_deep(small: Small) -> None:
    small["Idle"].balloons[0].data = "[" * 100_000


@CASES.breaks(
    "balloon-has-type",
    "balloon token 1 of place 'Idle' carries data, but the model has no token type",
    "add a token type with a field for each name in the data",
)
def no_token_type(small: Small) -> None:
    small["chatter"].mappings.clear()
    small.net.tokenType = None


@CASES.breaks(
    "balloons-are-tokens",
    "place 'Idle' has 1 balloon tokens but 0 tokens",
    "remove data or add tokens",
)
def more_data_than_tokens(small: Small) -> None:
    small["Idle"].tokens = 0


@CASES.breaks(
    "field-range",
    "token field 'tag' of token type 'Token' has no valid range: a field of the kind text has no range",
    "give an integer a minimum and a maximum, or named values: IDLE=0, BUSY=1",
)
def text_with_a_range(small: Small) -> None:
    small["Token"].fields[2].maximum = 3


@CASES.breaks(
    "field-range",
    "token field 'level' of token type 'Token' has no valid range: the minimum "
    "3 is greater than the maximum 0",
    "give an integer a minimum and a maximum, or named values: IDLE=0, BUSY=1",
)
def empty_range(small: Small) -> None:
    small["Token"].fields.append(sym.TokenField(name="level", kind="integer", minimum=3, maximum=0))


@CASES.breaks(
    "field-range",
    "token field 'level' of token type 'Token' has no valid range: level takes uint8, 0 to 255, not 300",
    "give an integer a minimum and a maximum, or named values: IDLE=0, BUSY=1",
)
def wider_than_ros(small: Small) -> None:
    small["Token"].fields.append(sym.TokenField(name="level", kind="integer", ros="uint8", maximum=300))


@CASES.breaks(
    "field-range",
    "token field 'mode' of token type 'Token' has no valid range: it has named "
    "values, and a minimum or maximum",
    "give an integer a minimum and a maximum, or named values: IDLE=0, BUSY=1",
)
def names_and_bounds(small: Small) -> None:
    small["Token"].fields.append(sym.TokenField(name="mode", kind="integer", values="A=0", minimum=0))


@CASES.breaks(
    "field-range",
    "token field 'mode' of token type 'Token' has no valid range: the value 0 is given twice",
    "give each value one name",
)
def two_names_for_a_value(small: Small) -> None:
    small["Token"].fields.append(sym.TokenField(name="mode", kind="integer", values="A=0, B=0"))


@CASES.breaks(
    "field-range-default",
    "token field 'mode' of token type 'Token' has no default, and 0 is not in its range",
    "give it a default of its range",
)
def range_without_0(small: Small) -> None:
    small["Token"].fields.append(sym.TokenField(name="mode", kind="integer", values="A=1, B=2"))


@CASES.breaks(
    "field-default-fits",
    "token field 'mode' of token type 'Token' has a default that does not fit: mode takes A, B, not 7",
    "write the default as JSON of the field's kind",
)
def default_out_of_range(small: Small) -> None:
    small["Token"].fields.append(sym.TokenField(name="mode", kind="integer", values="A=1, B=2", default="7"))


@CASES.breaks(
    "field-default-fits",
    "token field 'mode' of token type 'Token' has a default that does not fit: it is a number, and B names 2",
    "write the default as JSON of the field's kind",
)
def default_by_name(small: Small) -> None:
    small["Token"].fields.append(sym.TokenField(name="mode", kind="integer", values="A=1, B=2", default="B"))


@CASES.breaks(
    "value-names-unique",
    "token field 'door' of token type 'Token' names a value OPEN, as another field of its token type does",
    "give the values different names, such as DOOR_OPEN and GATE_OPEN",
)
def one_name_in_two_fields(small: Small) -> None:
    for name in ("gate", "door"):
        small["Token"].fields.append(sym.TokenField(name=name, kind="integer", values="SHUT=0, OPEN=1"))
    small["Token"].fields[-1].values = "CLOSED=0, OPEN=1"
