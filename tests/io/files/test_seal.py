"""A page proves itself: every change of a byte and every other name breaks its seal."""

import hashlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipcli.io.files.seal import is_sealed, sealed

PAGE = "<!DOCTYPE html>\n<p>π ≈ 3.14</p>\n"


def test_the_last_line_is_the_digest_of_name_and_text():
    text = sealed(PAGE, "a.html")
    digest = hashlib.sha256(b"a.html" + b"\0" + PAGE.encode()).hexdigest()
    assert text == f"{PAGE}<!-- ipcli report {digest} -->\n"


@given(st.text(st.characters(codec="utf-8")), st.text(st.characters(categories=["L", "N"]), min_size=1, max_size=20))
def test_what_was_sealed_is_sealed_under_its_name_alone(tmp_path_factory, text, stem):
    folder = tmp_path_factory.mktemp("sealed")
    own, other = folder / f"{stem}.html", folder / f"{stem}-2.html"
    for path in (own, other):
        path.write_bytes(sealed(text, own.name).encode())
    assert is_sealed(own)
    assert not is_sealed(other)


def test_every_changed_missing_or_added_byte_breaks_the_seal(tmp_path):
    path = tmp_path / "a.html"
    whole = sealed(PAGE, path.name).encode()
    changed = [whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :] for at in range(len(whole))]
    cut = [whole[:at] + whole[at + 1 :] for at in range(len(whole))]
    added = [whole[:at] + b" " + whole[at:] for at in range(len(whole) + 1)]
    for content in (*changed, *cut, *added):
        path.write_bytes(content)
        assert not is_sealed(path), content


def test_a_page_in_a_page_keeps_both_seals(tmp_path):
    """The seal counted is the last one."""
    path = tmp_path / "a.html"
    path.write_text(sealed(sealed(PAGE, "b.html"), path.name), encoding="utf-8", newline="")
    assert is_sealed(path)


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", PAGE.encode(), b"<!-- ipcli report ", b"\x00" * 100])
def test_what_has_no_seal_is_not_sealed(tmp_path, content):
    path = tmp_path / "a.html"
    path.write_bytes(content)
    assert not is_sealed(path)
