"""What is printed: in any encoding, of names of any bytes, where there is no room for it."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import followspot
from followspot.present.console import as_json, print_json

COURTYARD = Path(followspot.__file__).parent / "builtin" / "courtyard.pk3"
NO_TEXT = os.fsdecode(b"b\xffd")


def run(*arguments: str, **how: object) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "followspot", *arguments]
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **how}
    return subprocess.run(command, text=True, timeout=120, check=False, **options)  # type: ignore[call-overload, no-any-return]


@pytest.mark.parametrize(
    "typed",
    [["--help"], ["--version"], ["inspect", "courtyard"], ["inspect", "courtyard", "--json"]],
)
def test_no_room_for_what_is_printed(typed: list[str]) -> None:
    with Path("/dev/full").open("w") as full:
        done = run(*typed, stdout=full)
    told = "followspot: standard output: cannot be written: No space left on device\n"
    assert (done.returncode, done.stderr) == (2, told)


def test_nobody_who_listens() -> None:
    with Path("/dev/full").open("w") as full:
        assert run("inspect", "no_such_level", stdout=full, stderr=full).returncode == 2


@pytest.mark.parametrize("name", ["g ü 城.pk3", f"{NO_TEXT}.pk3"])
@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "utf-8"])
def test_names_in_every_encoding(tmp_path: Path, name: str, encoding: str) -> None:
    shutil.copy(COURTYARD, tmp_path / name)
    escaped = name.encode(encoding, errors="backslashreplace").decode(encoding)
    as_text = name.encode(errors="backslashreplace").decode()
    how = {"cwd": tmp_path, "env": {**os.environ, "PYTHONIOENCODING": encoding}}
    shown = run("inspect", name, **how, encoding=encoding)
    assert (shown.returncode, shown.stderr) == (0, "")
    assert shown.stdout.startswith(f"{escaped}  ")
    told = run("inspect", name, "--json", **how, encoding=encoding)
    assert (told.returncode, told.stderr) == (0, "")
    assert json.loads(told.stdout)["name"] == as_text


def test_json_of_names_that_are_no_text(capsys: pytest.CaptureFixture[str]) -> None:
    record = {"ü": (1, 0.5, None, True), NO_TEXT: [{"a": NO_TEXT}]}
    expected = {"ü": [1, 0.5, None, True], r"b\udcffd": [{"a": r"b\udcffd"}]}
    assert json.loads(as_json(record)) == expected
    assert as_json({"ü": 1}) == '{\n  "ü": 1\n}'.encode()
    print_json(record)
    assert json.loads(capsys.readouterr().out) == expected
