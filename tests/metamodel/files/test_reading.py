"""Opening files that users and strangers name: nothing but plain files, and not too much of them."""

from __future__ import annotations

import bz2
import gc
import gzip
import lzma
import os
from pathlib import Path

import pytest
from backports import zstd

from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files import load
from dineros.metamodel.files.reading import (
    FEW_OBJECTS,
    collector_paused,
    open_plain,
    read_bytes,
    read_pieces,
    read_text,
)


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("pipe", "is not a plain file"),
        ("device", "is not a plain file"),
        ("folder", "is a directory, not a file"),
        ("missing", "No such file or directory"),
        ("nul\0", "null byte"),
    ],
)
def test_only_plain_files_are_read(tmp_path: Path, kind: str, said: str) -> None:
    path = tmp_path / kind
    if kind == "pipe":
        os.mkfifo(path)  # opening it plainly would wait forever
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "folder":
        path.mkdir()
    for read in (read_bytes, read_text, lambda path: list(read_pieces(path))):
        with pytest.raises(ModelFileError, match=said):
            read(path)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n", "is a pointer of Git LFS"),
        (gzip.compress(b"net n", mtime=0), r"is packed by gzip \(unpack it first\)"),
        (bz2.compress(b"net n"), "is packed by bzip2"),
        (lzma.compress(b"net n"), "is packed by xz"),
        (zstd.compress(b"net n"), "is packed by zstd"),
        (b"PK\x03\x04", "is packed by zip"),
    ],
)
def test_what_stands_in_the_place_of_a_file_is_named(tmp_path: Path, content: bytes, said: str) -> None:
    path = tmp_path / "net.net"
    path.write_bytes(content)
    for read in (read_bytes, read_text, load, lambda path: list(read_pieces(path))):
        with pytest.raises(ModelFileError, match=said):
            read(path)


def test_a_link_is_followed_only_where_it_may_be(tmp_path: Path) -> None:
    (tmp_path / "target").write_text("secret")
    link = tmp_path / "link"
    link.symlink_to("target")
    assert read_text(link) == "secret"
    with pytest.raises(ModelFileError, match="link: is a symbolic link, which is not followed here"):
        read_text(link, follow_links=False)


def test_text_is_utf8(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"\xff")
    with pytest.raises(ModelFileError, match="a: is not UTF-8: invalid start byte"):
        read_text(tmp_path / "a")


def test_what_is_no_plain_file_is_not_emptied(tmp_path: Path) -> None:
    (tmp_path / "target").write_text("precious")
    (tmp_path / "link").symlink_to("target")
    os.mkfifo(tmp_path / "pipe")
    flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC
    for name in ("link", "pipe"):
        with pytest.raises(ModelFileError):
            os.close(open_plain(tmp_path / name, flags, follow_links=False))
    assert (tmp_path / "target").read_text() == "precious"
    os.close(open_plain(tmp_path / "target", flags, follow_links=False))
    assert (tmp_path / "target").read_text() == ""


def test_large_files_come_in_pieces(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"0123456789")
    assert list(read_pieces(tmp_path / "a", 3, size=4)) == [b"3456", b"789"]


def test_frozen_objects_are_counted_only_after_many_new_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    """Counting walks through all that the caller has frozen: a million objects take 20 ms or more."""
    counts = iter(range(1, 9))
    monkeypatch.setattr(gc, "get_freeze_count", lambda: next(counts))
    gc.collect()
    for size, following in ((1000, 1), (2 * FEW_OBJECTS, 3)):
        with collector_paused():
            made: list[list[int]] = [[] for _ in range(size)]
        assert (len(made), gc.isenabled(), next(counts)) == (size, True, following)
