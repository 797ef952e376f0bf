"""Archives hold what the folder that was packed holds, are gone when nobody holds them, and never write elsewhere."""

import gc
import io
import os
import shutil
import tarfile

import pytest

from ipcli.errors import FormatError
from ipcli.io.files.archive import SUFFIXES, is_archive, listing, unpacked
from tests.fixtures.errors import check_message

FORMATS = {".tar": "w", ".tar.gz": "w:gz", ".tgz": "w:gz", ".tar.xz": "w:xz", ".txz": "w:xz", ".tar.bz2": "w:bz2"}
FILES = {"a.txt": b"a" * 5000, "in/b.bin": bytes(range(256)), "in/deep/c": b""}


@pytest.fixture
def folder(tmp_path):
    for name, content in FILES.items():
        path = tmp_path / "folder" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    (tmp_path / "folder" / "empty").mkdir()
    return tmp_path / "folder"


def pack(folder, suffix):
    path = folder.parent / f"packed{suffix}"
    with tarfile.open(path, FORMATS[suffix.lower()]) as tar:
        for name in sorted(os.listdir(folder), reverse=True):
            tar.add(folder / name, name)
    return path


@pytest.mark.parametrize("suffix", [*SUFFIXES, ".TAR.GZ"])
def test_an_archive_lists_and_holds_what_was_packed(folder, suffix):
    path = pack(folder, suffix)
    assert is_archive(path)
    assert listing(path) == listing(folder) == tuple(sorted(FILES))
    home = unpacked(path)
    assert {name: (home.folder / name).read_bytes() for name in FILES} == FILES


def test_a_folder_is_itself_and_nothing_else_lists_anything(folder):
    assert unpacked(folder).folder == folder
    assert listing(folder / "a.txt") == listing(folder / "none") == ()
    assert not is_archive(folder)
    (folder / "like.tar").mkdir()
    assert not is_archive(folder / "like.tar")


def test_what_was_unpacked_stays_as_long_as_it_is_held(folder):
    home = unpacked(pack(folder, ".tar"))
    place = home.folder
    assert place.is_dir()
    del home
    gc.collect()
    assert not place.exists()
    assert folder.is_dir()


def test_a_list_follows_the_file(folder):
    path = pack(folder, ".tar")
    assert "new" not in listing(path)
    (folder / "new").touch()
    pack(folder, ".tar")
    os.utime(path, ns=(1, 1))
    assert "new" in listing(path)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("share", [0.0, 0.5])
def test_a_cut_archive_is_named(folder, suffix, share):
    path = pack(folder, suffix)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(FormatError) as raised:
        unpacked(path)
    check_message(raised.value, path, "not a readable archive", "Check that the copy is complete")


def _member(name, kind=tarfile.REGTYPE, link=""):
    info = tarfile.TarInfo(name)
    info.type, info.linkname, info.size = kind, link, 4 if kind == tarfile.REGTYPE else 0
    return info


@pytest.mark.parametrize(
    "members",
    [
        [_member("../outside")],
        [_member("in/../../outside")],
        [_member("link", tarfile.SYMTYPE, "../../outside")],
        [_member("link", tarfile.LNKTYPE, "../outside")],
        [_member("in", tarfile.SYMTYPE, ".."), _member("in/outside")],
        [_member("pipe", tarfile.FIFOTYPE)],
    ],
    ids=["above", "through a folder", "symbolic link", "hard link", "through a link", "pipe"],
)
def test_an_archive_that_writes_elsewhere_is_refused(tmp_path, monkeypatch, members):
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    path = tmp_path / "evil.tar"
    with tarfile.open(path, "w") as tar:
        for member in members:
            tar.addfile(member, io.BytesIO(b"evil"))
    with pytest.raises(FormatError) as raised:
        unpacked(path)
    check_message(raised.value, path, "not a readable archive")
    gc.collect()
    assert not list(tmp_path.rglob("outside"))


def test_a_copy_that_lost_its_suffix_is_no_archive(folder):
    path = pack(folder, ".tar")
    shutil.copy(path, folder.parent / "copy")
    assert not is_archive(folder.parent / "copy")


def packed_blocks(tmp_path):
    """An archive of three files a, b, c of one block each, as its blocks: a header, then its data, of each."""
    with tarfile.open(tmp_path / "x.tar", "w") as tar:
        for name in "abc":
            (tmp_path / name).write_bytes(name.encode() * 512)
            tar.add(tmp_path / name, name)
    return bytearray((tmp_path / "x.tar").read_bytes())


@pytest.mark.parametrize("reading", [listing, unpacked])
@pytest.mark.parametrize(
    ("change", "because"),
    [
        (lambda data: data[: 2 * 512 + 3] + b"9" + data[2 * 512 + 4 :], "neither a member nor the end"),
        (lambda data: data[: 4 * 512], "neither a member nor the end at byte 2048"),
        (lambda data: data[: 4 * 512 + 100], "neither a member nor the end at byte 2048"),
        (lambda data: data[: 3 * 512 + 100], "unexpected end of data"),
        (lambda data: data + data, "several were joined"),
    ],
    ids=["damaged header", "cut between members", "cut in a header", "cut in a file", "joined"],
)
def test_a_damaged_archive_loses_no_member_without_a_word(tmp_path, reading, change, because):
    (tmp_path / "bad.tar").write_bytes(change(packed_blocks(tmp_path)))
    with pytest.raises(FormatError) as error:
        reading(tmp_path / "bad.tar")
    check_message(error.value, "bad.tar", because)


def test_a_small_archive_of_large_files_is_refused_before_it_writes(folder, monkeypatch):
    monkeypatch.setenv("IPCLI_MAX_MEMORY", "70MB")
    (folder / "zeros").write_bytes(bytes(80_000_000))
    path = pack(folder, ".tar.gz")
    assert path.stat().st_size < 200_000
    with pytest.raises(FormatError, match="which take 80 MB.*unpack it yourself"):
        unpacked(path)
