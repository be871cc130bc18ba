"""Where levels are looked for, and the ways to name one."""

import os
from pathlib import Path

import pytest
from archive_fixtures import OPENARENA, write_files, write_pak

from followspot.assets import locate
from followspot.assets.archive import Archive
from followspot.assets.locate import list_levels, locate_level, search_path
from followspot.errors import AssetError


@pytest.fixture
def no_installs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(locate, "INSTALL_FOLDERS", ())
    monkeypatch.delenv("FOLLOWSPOT_ASSETS", raising=False)


def test_search_path_puts_named_folders_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = tmp_path / "home"
    for folder in ("home/.q3a/baseq3", "home/.openarena/baseoa", "a", "b/baseq3", "b/baseoa", "c"):
        (tmp_path / folder).mkdir(parents=True)
    pak = write_pak(tmp_path / "p.pk3", {})
    (tmp_path / "link").symlink_to(tmp_path / "a")
    monkeypatch.setenv("HOME", str(home))
    listed = [tmp_path / "c", tmp_path / "link", home / ".q3a"]
    monkeypatch.setenv("FOLLOWSPOT_ASSETS", os.pathsep.join(["", *map(str, listed)]))
    found = search_path([tmp_path / "a", tmp_path / "b", pak])
    assert found[:7] == [
        tmp_path / "a",
        tmp_path / "b/baseoa",
        tmp_path / "b/baseq3",
        pak,
        tmp_path / "c",
        home / ".q3a/baseq3",
        home / ".openarena/baseoa",
    ]
    assert all(path.name in ("baseoa", "baseq3") for path in found[7:])


@pytest.mark.usefixtures("no_installs")
def test_search_path_refuses_what_does_not_exist(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert search_path() == []
    with pytest.raises(AssetError, match="gone: expected a game folder"):
        search_path([tmp_path / "gone"])
    monkeypatch.setenv("FOLLOWSPOT_ASSETS", str(tmp_path / "gone"))
    with pytest.raises(AssetError, match="gone: environment variable FOLLOWSPOT_ASSETS: expected"):
        search_path()


def test_levels_are_located_by_name_path_and_pak(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    game = write_files(tmp_path / "game", {"maps/One.bsp": "game one", "maps/two.bsp": "game two"})
    mine = write_files(tmp_path / "mine", {"maps/one.bsp": "my one", "textures/t.tga": "t"})
    write_files(tmp_path / "loose", {"one.bsp": "bare one"})
    single = write_pak(tmp_path / "Single.pk3", {"maps/one.bsp": "packed one", "x.txt": ""})
    many = write_pak(tmp_path / "many.pk3", {"maps/one.bsp": "1", "maps/sub/two.bsp": "2"})
    monkeypatch.chdir(mine / "maps")

    def read(name: str) -> tuple[str, str]:
        archive, entry = locate_level(name, [game])
        with archive:
            assert archive.exists("maps/two.bsp")  # the search path is always there
            return entry, archive.read(entry).decode()

    for name in ("one", "ONE", "maps/one.bsp", "Maps\\One.BSP", "one.BSP"):
        assert read(name) == ("maps/one.bsp", "game one")
    assert read("one.bsp") == ("maps/one.bsp", "my one")  # a file in the working directory
    assert read(str(mine / "maps/one.bsp")) == ("maps/one.bsp", "my one")
    assert read("../maps/one.bsp") == ("maps/one.bsp", "my one")
    assert read(str(tmp_path / "loose/one.bsp")) == ("one.bsp", "bare one")
    assert read(str(single)) == ("maps/one.bsp", "packed one")
    assert read(f"{single}:ONE") == ("maps/one.bsp", "packed one")
    assert read(f"{many}:maps/sub/two.bsp") == ("maps/sub/two.bsp", "2")
    archive, _ = locate_level(str(mine / "maps/one.bsp"), [])
    with archive:
        assert archive.read("textures/t.tga") == b"t"


def test_levels_that_cannot_be_located_say_what_is_near(tmp_path: Path) -> None:
    game = write_files(tmp_path / "game", {f"maps/oa_dm{i}.bsp": "" for i in range(1, 4)})
    many = write_pak(tmp_path / "many.pk3", {"maps/one.bsp": "", "maps/two.bsp": ""})
    none = write_pak(tmp_path / "none.pk3", {"x": ""})

    def refused(name: str, search: list[Path]) -> AssetError:
        with pytest.raises(AssetError) as caught:
            locate_level(name, search)
        assert "\n" not in str(caught.value)
        return caught.value

    error = refused("oa_dm1x", [game, many])
    assert error.source == "oa_dm1x"
    assert f"in {game}, {many}" in error.expected
    assert error.found.startswith("none; close names are oa_dm1, ")
    assert refused("zzz", [game]).found == "none"
    assert "name one with --assets" in refused("oa_dm1", []).expected
    assert refused(str(tmp_path / "gone/maps/oa_dm2.bsp"), [game]).found == "none"
    assert refused(str(tmp_path / "gone.pk3"), []).source == str(tmp_path / "gone.pk3")
    assert refused(str(many), []).found == "one, two"
    assert refused(str(none), []).found == "no level"
    error = refused(f"{many}:tow", [])
    assert (error.place, error.found) == ("tow", "none; close names are two")
    refused("x" * 5000, [game])
    (game / "download.pk3").touch()
    assert refused("zzz", [game]).found.startswith(f"none; left out: {game / 'download.pk3'}: ")
    refused("a\0b", [game])


@pytest.mark.openarena
def test_openarenas_levels_are_listed() -> None:
    with Archive.open([OPENARENA]) as archive:
        levels = list_levels(archive)
    assert len(levels) >= 85
    assert {"oa_dm5", "am_thornish"} <= set(levels)
    assert levels == sorted(levels)


@pytest.mark.openarena
def test_openarena_is_found_without_being_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("FOLLOWSPOT_ASSETS", raising=False)
    found = search_path()
    assert OPENARENA in found
    archive, entry = locate_level("OA_DM5", found)
    with archive:
        assert entry == "maps/oa_dm5.bsp"
