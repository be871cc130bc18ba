"""Paks and folders to test with."""

import zipfile
from collections.abc import Mapping
from pathlib import Path

OPENARENA = Path("/usr/share/games/openarena/baseoa")


def write_pak(path: Path, files: Mapping[str, bytes | str]) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as pak:
        for name, data in files.items():
            pak.writestr(name, data)
    return path


def write_files(folder: Path, files: Mapping[str, str]) -> Path:
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder
