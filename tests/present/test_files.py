"""Files under names of every kind: whole, where the name leads, or not there."""

import os
import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from followspot.errors import UnwritableError
from followspot.present import files, pictures
from followspot.present.interrupt import Terminated, interruptible

PICTURE = np.random.default_rng(3).integers(0, 256, (40, 60, 3), np.uint8)
NO_TEXT = os.fsdecode(b"b\xffd")


def saved(path: Path) -> None:
    linear = path.suffix in pictures.LINEAR_ENDINGS
    pictures.save(path, PICTURE.astype(np.float32) if linear else PICTURE)


def read(path: Path) -> np.ndarray:
    """What is in a picture's file, by a name that every library takes."""
    if path.suffix == ".exr":
        with files.plain(path) as name:
            return np.asarray(OpenEXR.File(str(name)).channels()["RGB"].pixels)
    with path.open("rb") as file:
        return np.asarray(np.load(file) if path.suffix == ".npy" else Image.open(file))


@pytest.mark.parametrize("ending", [".png", ".exr", ".npy"])
@pytest.mark.parametrize("stem", ["x" * 251, f"{NO_TEXT}/{NO_TEXT}", "mit leer/ü"])
def test_names_of_every_kind(tmp_path: Path, stem: str, ending: str) -> None:
    path = tmp_path / f"{stem}{ending}"
    saved(path)
    assert np.array_equal(read(path), PICTURE)
    assert list(path.parent.iterdir()) == [path]


def test_a_name_for_libraries_that_know_utf_8_alone(tmp_path: Path) -> None:
    with files.plain(tmp_path / "ü.exr") as name:
        assert name == tmp_path / "ü.exr"
    with files.plain(tmp_path / f"{NO_TEXT}.exr") as name:
        assert str(name).isascii() and name.suffix == ".exr"
        name.write_bytes(b"x")
    assert (tmp_path / f"{NO_TEXT}.exr").read_bytes() == b"x"
    assert not name.parent.exists()


def test_a_link_stays_and_its_file_is_written(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    first, second = tmp_path / "first.png", tmp_path / "second.png"
    first.symlink_to("second.png")
    second.symlink_to(Path("deep", "old.data"))
    for before in (None, b"old"):
        if before is not None:
            (tmp_path / "deep" / "old.data").write_bytes(before)
        saved(first)
        assert first.is_symlink() and second.is_symlink()
        assert np.array_equal(np.asarray(Image.open(tmp_path / "deep" / "old.data")), PICTURE)
    assert len(list(tmp_path.rglob("*"))) == 4


@pytest.mark.parametrize("kind", ["circle", "pipe", "link to a pipe"])
def test_what_must_not_be_replaced(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "x.png"
    if kind == "circle":
        path.symlink_to("x.png")
    elif kind == "pipe":
        os.mkfifo(path)
    else:
        os.mkfifo(tmp_path / "pipe")
        path.symlink_to("pipe")
    before = sorted((each.name, each.lstat().st_ino) for each in tmp_path.iterdir())
    told = "symbolic links" if kind == "circle" else "expected a file, found a device or the like"
    with pytest.raises(UnwritableError, match=rf"x\.png: cannot be written: .*{told}"):
        saved(path)
    assert sorted((each.name, each.lstat().st_ino) for each in tmp_path.iterdir()) == before


@contextmanager
def no_room() -> Iterator[None]:
    """Files of at most 4096 bytes; for a moment alone: it holds for the tests' own log, too."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("ending", [".png", ".exr", ".npy"])
def test_why_a_file_is_cut_off_is_told(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"x{ending}"
    told = rf"x\{ending}: cannot be written: .*File too large"
    with pytest.raises(UnwritableError, match=told), no_room():
        saved(path)
    assert list(tmp_path.iterdir()) == []


def test_a_file_in_a_folders_place(tmp_path: Path) -> None:
    file = tmp_path / "file.txt"
    file.write_text("mine")
    for path in (file / "x.png", file / "deep" / "x.png"):
        told = f"{path}: cannot be written: expected a folder, found the file {file}"
        with pytest.raises(UnwritableError) as caught:
            saved(path)
        assert str(caught.value) == told
        with pytest.raises(UnwritableError, match=r"expected a folder, found the file .*file\.txt"):
            files.require_folder(path.parent)
    files.require_folder(tmp_path / "new" / "folder")
    files.require_folder(tmp_path)
    assert list(tmp_path.iterdir()) == [file] and file.read_text() == "mine"


def test_kill_leaves_nothing_half_made(tmp_path: Path) -> None:
    def write(path: Path) -> None:
        path.write_bytes(b"half")
        os.kill(os.getpid(), signal.SIGTERM)
        raise AssertionError("went on")

    before = signal.getsignal(signal.SIGTERM)
    with pytest.raises(Terminated), interruptible():
        files.write_whole(tmp_path / "x.png", write)
    assert signal.getsignal(signal.SIGTERM) == before
    assert list(tmp_path.iterdir()) == []
