import os
from collections.abc import Callable
from pathlib import Path

import pytest

from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files.reading import read_bytes
from dineros.metamodel.files.xml import ELEMENT_LIMIT, line_of, parse, parse_bytes


def refused(content: bytes) -> ModelFileError:
    with pytest.raises(ModelFileError) as caught:
        parse_bytes(content, "model.xmi")
    text = str(caught.value)
    assert text.startswith("model.xmi")
    assert "\n" not in text
    return caught.value


def test_lines_survive_even_beyond_65535() -> None:
    tree = parse_bytes(b"<a>" + b"\n" * 70_000 + b"<b/></a>", "model.xmi")
    assert line_of(tree.getroot()[0]) == 70_001


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "iso-8859-1"])
def test_encodings_are_understood(encoding: str) -> None:
    declared = {"utf-8-sig": "utf-8", "utf-16-le": "utf-16", "utf-16-be": "utf-16"}.get(encoding, encoding)
    content = f'<?xml version="1.0" encoding="{declared}"?><a b="ä"/>'
    assert parse_bytes(content.encode(encoding), "m.xmi").getroot().get("b") == "ä"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-32"])
def test_a_document_type_is_refused_with_its_line(encoding: str) -> None:
    error = refused(
        '<?xml version="1.0"?>\n<!-- --> <!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>'.encode(encoding)
    )
    assert "document type" in error.message
    assert error.location is not None
    assert error.location.line == 2


def test_an_entity_bomb_in_an_unusual_encoding_is_refused() -> None:
    content = b'<?xml version="1.0" encoding="utf-7"?>+ADwAIQ-DOCTYPE a+AD4-+ADw-a/>'
    assert "document type" in refused(content).message


def test_the_word_doctype_in_text_is_no_document_type() -> None:
    assert parse_bytes(b"<a><![CDATA[<!DOCTYPE b>]]></a>", "m.xmi").getroot().text == "<!DOCTYPE b>"


def test_an_external_entity_is_not_read(tmp_path: Path) -> None:
    secret = tmp_path / "secret"
    secret.write_text("password")
    error = refused(f'<!DOCTYPE a [<!ENTITY x SYSTEM "{secret.as_uri()}">]><a>&x;</a>'.encode())
    assert "password" not in str(error)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b" \n\t", "is empty"),
        (bytes(range(256)), "is it an XML file?"),
        (b"\x89PNG\r\n\x1a\n\x00\x00", "is it an XML file?"),
        (b"<a><b></a>", "tag mismatch"),
        (b"<a><b", "b"),
        (b"<x:a/>", "prefix x"),
        (b"<a>&unknown;</a>", "unknown"),
        (b'<?xml version="1.0" encoding="klingon"?><a/>', "klingon"),
        ('<?xml version="1.0" encoding="utf-8"?><a b="ä"/>'.encode("latin-1"), "encoding"),
        (b"<a>" * 100_000, "nest deeper than 256"),
        (b"<a>" * 100_000 + b"</a>" * 100_000, "nest deeper than 256"),
        (lambda: b"<a b='" + b"x " * 25_000_000 + b"'/>", "limit exceeded"),
        (lambda: b"<a>" + b"token " * 8_000_000 + b"</a>", "limit exceeded"),
        (lambda: b"<a>" + b"<b/>" * 12_500_000 + b"</a>", f"more than {ELEMENT_LIMIT} elements"),
    ],
    ids=lambda value: repr(value[:20]) if isinstance(value, bytes) else "",
)
def test_what_is_no_xml_gets_one_line(content: bytes | Callable[[], bytes], message: str) -> None:
    assert message in str(refused(content() if callable(content) else content))


def test_a_missing_file_a_folder_and_a_pipe_are_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.xmi")
    for path, message in [
        (tmp_path / "missing.xmi", "No such file"),
        (tmp_path, "is a directory"),
        (tmp_path / "pipe.xmi", "is not a plain file"),
        (Path("/dev/zero"), "is not a plain file"),
        (tmp_path / "nul\0.xmi", "null byte"),
        (tmp_path / ("x" * 300), "too long"),
    ]:
        with pytest.raises(ModelFileError, match=message):
            parse(path)


def test_a_refusal_of_the_operating_system_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> int:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("dineros.metamodel.files.reading.os.open", refuse)
    with pytest.raises(
        ModelFileError, match=r"a\.xmi: cannot be read: Permission denied \(check who may read it\)"
    ):
        parse("a.xmi")


def test_a_file_above_the_limit_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "large"
    path.write_bytes(b"x" * (1024 * 1024 + 1))
    with pytest.raises(ModelFileError, match="larger than 1 MiB"):
        read_bytes(path, limit=1024 * 1024)
    path.write_bytes(b"x" * 1024 * 1024)
    assert len(read_bytes(path, limit=1024 * 1024)) == 1024 * 1024


def test_blanks_before_the_root_take_no_time() -> None:
    # Once, each blank doubled the time that the search for a document type took.
    content = b"<?xml version='1.0'?>" + b" \n" * 20_000 + b"<!-- one -->" + b"\t" * 1_000
    assert parse_bytes(content + b"<a/>", "model.xmi").getroot().tag == "a"
    assert "document type" in refused(content + b"<!DOCTYPE a><a/>").message
