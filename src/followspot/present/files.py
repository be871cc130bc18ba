"""Files that are whole or not there, whatever their names and wherever they lead."""

import errno
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from followspot.errors import UnwritableError

PREFIX = ".followspot-"
"""Of the names that files have while they are made: short, since a file's own may be the longest
that there can be."""


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill a file beside `path`, then give it that name.

    Where `path` is a link, the file that it leads to is written. Missing folders are made.

    Args:
        path: What is told of it if it cannot be written.
        write: Gets a file's name that any library can open, of the same ending.

    Raises:
        UnwritableError: the folder or file cannot be written.
    """
    part: Path | None = None
    with writing(path):
        real = target(path)
        try:
            real.parent.mkdir(parents=True, exist_ok=True)
            handle, name = tempfile.mkstemp(prefix=PREFIX, suffix=path.suffix, dir=real.parent)
            part = Path(name)
            os.close(handle)
            with plain(part) as to:
                write(to)
            part.chmod(0o666 & ~_umask())
            part.replace(real)
        finally:
            if part is not None:
                part.unlink(missing_ok=True)


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Tell of an OSError, within, as of a file or folder that cannot be written.

    Raises:
        UnwritableError: there was one.
    """
    try:
        yield
    except OSError as error:
        raise UnwritableError(path, _reason(path, error)) from None


def _reason(path: Path, error: OSError) -> str:
    """Why it cannot be written; a file where a folder is needed is told by its name."""
    if error.errno in (errno.EEXIST, errno.ENOTDIR):
        for above in path.parents:
            if os.path.lexists(above) and not above.is_dir():
                return f"expected a folder, found the file {above}"
    return error.strerror or str(error)


def require_folder(folder: Path) -> None:
    """See that files may be put into a folder, which may be made for them.

    Raises:
        UnwritableError: it is a file, or is in one.
    """
    for each in (folder, *folder.parents):
        if os.path.lexists(each) and not os.path.isdir(each):  # noqa: PTH112 - never raises
            raise UnwritableError(folder, f"expected a folder, found the file {each}")


def target(path: Path) -> Path:
    """The file that a name leads to, by however many links.

    Raises:
        OSError: the links lead in a circle, or to a device, which nothing must replace.
    """
    real = Path(os.path.realpath(path)) if path.is_symlink() else path
    if real.is_symlink():
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
    if real.exists() and not real.is_file() and not real.is_dir():
        raise OSError(f"expected a file, found a device or the like at {real}")
    return real


@contextmanager
def plain(path: Path) -> Iterator[Path]:
    """A name of a file or folder that libraries can open which take names for UTF-8."""
    name = str(path)
    if os.fsencode(path) == name.encode(errors="backslashreplace"):
        yield path
        return
    with tempfile.TemporaryDirectory(prefix=PREFIX) as folder:
        link = Path(folder) / f"link{path.suffix if path.suffix.isascii() else ''}"
        link.symlink_to(path.absolute())
        yield link


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
