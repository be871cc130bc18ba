"""The report's folder: whole, or as it was before."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec

from followspot.errors import UnwritableError, UsageError
from followspot.present import files, folders

INDEX, FIGURES = "index.html", "report.json"


@contextmanager
def published(folder: Path) -> Iterator[Path]:
    """A new folder to fill, which takes `folder`'s place when all went well.

    An earlier report there is replaced; anything else is left alone.

    Raises:
        UnwritableError: it, or what is put into it, cannot be written.
        UsageError: something else is there.
        OSError: what fills the folder met one that is not the folder's.
    """
    check(folder)
    with files.writing(folder):
        folder.parent.mkdir(parents=True, exist_ok=True)
        workshop = tempfile.TemporaryDirectory(prefix=files.PREFIX, dir=folder.parent)
    with workshop:
        made = Path(workshop.name) / "report"
        with files.writing(folder):
            made.mkdir()
        try:
            yield made
        except UnwritableError as error:  # of a name that nobody has heard of
            raise UnwritableError(folder, error.reason) from None
        check(folder)
        with files.writing(folder):
            folders.put(made, folder)


def check(folder: Path) -> None:
    """See that a report may take this place.

    Raises:
        UsageError: it has no name of its own, or holds what is not a report's.
    """
    if not folder.name:
        raise UsageError(f"{folder}: expected the name of a folder that can be made anew")
    try:
        if not folder.exists() and not folder.is_symlink():
            return
        if not folder.is_dir() or folder.is_symlink():
            raise UsageError(f"{folder}: expected a folder with a report, or nothing yet")
        others = {path.name for path in folder.iterdir()} - _files_of(folder)
    except OSError as error:
        raise UnwritableError(folder, error.strerror or str(error)) from None
    if others:
        raise UsageError(
            f"{folder}: expected a folder with a report, or nothing yet; found {min(others)} in it"
        )


def _files_of(folder: Path) -> set[str]:
    """Names of the files that the report in a folder says are its own."""
    try:
        told: dict[str, Any] = msgspec.json.decode((folder / FIGURES).read_bytes(), type=dict)
        return set(msgspec.convert(told.get("files"), list[str]))
    except (OSError, msgspec.MsgspecError):
        return set()
