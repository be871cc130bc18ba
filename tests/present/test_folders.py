"""Folders in place of others: the new one, or the one before."""

import errno
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from followspot.errors import UsageError
from followspot.present import files, film, folders
from followspot.present.film_plan import Output
from followspot.present.frames import Film
from followspot.present.interrupt import Interrupt
from followspot.present.report.publish import FIGURES, published
from followspot.scene.path import CameraPath, Key

RENAME = Path.rename


def contents(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder)): path.read_text()
        for path in folder.rglob("*")
        if path.is_file()
    }


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A report's folder, with nothing beside it; its name is one that might be taken inside."""
    folder = tmp_path / "before"
    with published(folder) as made:
        (made / FIGURES).write_text(f'{{"files": ["{FIGURES}"]}}')
    return folder


class Failing:
    """In place of `Path.rename`: something goes wrong the first time a name is taken.

    Args:
        name: That name.
        error: What goes wrong.
        late: Whether that is after it was taken.
        for_good: Whether it goes wrong ever after.
    """

    def __init__(
        self, name: Path, error: BaseException, *, late: bool = False, for_good: bool = False
    ) -> None:
        self.name, self.error, self.late, self.for_good = name, error, late, for_good
        self.failed = False

    def rename(self, path: Path, target: Path) -> Path:
        fails = target == self.name and (self.for_good or not self.failed)
        self.failed |= fails
        if fails and not self.late:
            raise self.error
        RENAME(path, target)
        if fails:
            raise self.error
        return target

    def put_on(self, monkeypatch: pytest.MonkeyPatch) -> None:
        for name in ("rename", "replace"):
            monkeypatch.setattr(Path, name, lambda path, target: self.rename(path, target))


BUSY = OSError(errno.EBUSY, "Device or resource busy")


def test_a_report_that_cannot_take_its_place_leaves_the_one_before(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = contents(place)
    Failing(place, BUSY).put_on(monkeypatch)
    with (
        pytest.raises(UsageError, match="before: cannot be written: Device"),
        published(place) as m,
    ):
        (m / "new").write_text("new")
    assert contents(place) == before and list(place.parent.iterdir()) == [place]


def film_into(folder: Path) -> None:
    def pictures() -> Iterator[np.ndarray]:
        yield np.zeros((2, 2, 3), np.uint8)

    path = CameraPath((Key(0.0, np.zeros(3)), Key(1.0, np.ones(3))))
    film.write(
        Output(folder, is_folder=True), pictures(), Film(path, (2, 2), Fraction(1), 1), None,
        Interrupt(),
    )  # fmt: skip


def test_so_does_a_folder_of_frames(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = contents(place)
    Failing(place, BUSY).put_on(monkeypatch)
    with pytest.raises(UsageError, match="before: cannot be written: Device"):
        film_into(place)
    assert contents(place) == before and list(place.parent.iterdir()) == [place]


def test_whatever_its_name_is_it_takes_that(place: Path) -> None:
    """Twice, so that both have a name at a time."""
    film_into(place)
    assert [path.name for path in place.iterdir()] == ["frame-00000.png"]
    assert list(place.parent.iterdir()) == [place]


@pytest.fixture
def made(place: Path) -> Path:
    folder = place.parent / "made"
    folder.mkdir()
    (folder / "new").write_text("new")
    return folder


@pytest.mark.parametrize("late", [False, True])
def test_an_interrupt_between_the_two_loses_neither(
    place: Path, made: Path, monkeypatch: pytest.MonkeyPatch, late: bool
) -> None:
    wanted = {"new": "new"} if late else contents(place)
    Failing(place, KeyboardInterrupt(), late=late).put_on(monkeypatch)
    with pytest.raises(KeyboardInterrupt):
        folders.put(made, place)
    assert contents(place) == wanted
    assert set(place.parent.iterdir()) == ({place} if late else {place, made})


def test_what_cannot_go_back_is_not_deleted(
    place: Path, made: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = contents(place)
    Failing(place, BUSY, for_good=True).put_on(monkeypatch)
    with pytest.raises(OSError, match="busy"):
        folders.put(made, place)
    (aside,) = (path for path in place.parent.iterdir() if path.name.startswith(".before-"))
    assert contents(aside / "before") == before and contents(made) == {"new": "new"}


def test_what_fills_a_report_tells_of_its_own_errors(place: Path) -> None:
    """A level's file that has gone meanwhile does not keep the report's folder from being written;
    a full disk does.
    """
    before = contents(place)
    with pytest.raises(FileNotFoundError, match=r"gone\.pk3"), published(place):
        (place.parent / "gone.pk3").open().close()
    with (
        pytest.raises(UsageError, match="before: cannot be written: No space left"),
        published(place),
        files.writing(place),
    ):
        raise OSError(errno.ENOSPC, "No space left on device")
    assert contents(place) == before and list(place.parent.iterdir()) == [place]
