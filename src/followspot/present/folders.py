"""New files and folders in place of old ones: one of the two is always there."""

import shutil
import tempfile
from pathlib import Path


def put(made: Path, place: Path) -> None:
    """Give what has been made its name; a file or folder that had it goes when that has gone well.

    Args:
        made: A file or folder on the same file system.
        place: Its name from now on.

    Raises:
        OSError: it cannot have that name, and what had it still does. Should even that go wrong,
            the folder before is in a hidden one beside it.
    """
    if not place.is_dir():
        made.replace(place)
        return
    aside = Path(tempfile.mkdtemp(prefix=".before-", dir=place.parent))
    before = aside / "before"
    try:
        place.rename(before)
        made.rename(place)
    except BaseException:
        if before.exists() and not place.exists():
            before.rename(place)
        raise
    finally:
        if place.exists():
            shutil.rmtree(aside)
