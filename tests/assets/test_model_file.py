from pathlib import Path

import pytest

from followspot.assets.archive import Archive
from followspot.assets.model_file import find_model_image, images_beside, locate_model
from followspot.errors import AssetError


def write(folder: Path, *names: str) -> None:
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(name.encode())


def located(name: str | Path, *search: Path) -> tuple[str, bytes]:
    archive, entry = locate_model(str(name), search)
    with archive:
        return entry, archive.read(entry)


def test_a_file_is_looked_at_from_its_own_folder(tmp_path: Path) -> None:
    write(tmp_path, "robot/Tris.MD2", "robot/skin.pcx")
    assert located(tmp_path / "robot" / "Tris.MD2") == ("tris.md2", b"robot/Tris.MD2")
    write(tmp_path, "models/robot.md3")  # nothing says that a game's folder is above
    assert located(tmp_path / "models" / "robot.md3")[0] == "robot.md3"


@pytest.mark.parametrize("mark", ["pak0.pk3/x", "scripts/a.shader", "textures/a.tga"])
def test_a_file_in_a_games_folder_is_looked_at_from_there(tmp_path: Path, mark: str) -> None:
    write(tmp_path, "models/items/a.md3", mark)
    assert located(tmp_path / "models" / "items" / "a.md3")[0] == "models/items/a.md3"


def test_a_name_is_looked_for_in_the_search_path(tmp_path: Path) -> None:
    write(tmp_path, "one/models/a.md3", "two/models/a.md3", "two/models/b.md3")
    assert located("Models\\A.md3", tmp_path / "one", tmp_path / "two")[1] == b"one/models/a.md3"
    assert located("models/b.md3", tmp_path / "one", tmp_path / "two")[1] == b"two/models/b.md3"


@pytest.mark.parametrize("name", ["nothing.md2", "../a.md3", "", "a\0b.md3"])
def test_models_that_are_not_there(tmp_path: Path, name: str) -> None:
    with pytest.raises(AssetError, match="the name of one in a game folder"):
        locate_model(name, [tmp_path])


def test_images_of_a_model(tmp_path: Path) -> None:
    write(tmp_path, "m/bot.pcx", "m/bot2.tga", "m/bot.bmp", "m/botany/x.png", "m/other.tga")
    write(tmp_path, "m/bot.md2", "skins/red.jpg")
    with Archive.open([tmp_path]) as archive:
        assert images_beside(archive, "m/bot.md2") == ["m/bot.bmp", "m/bot.pcx", "m/bot2.tga"]
        assert find_model_image(archive, "m/bot.md2", "skins/red.pcx")[0] == "skins/red.jpg"
        assert find_model_image(archive, "m/bot.md2", "players/x/OTHER.pcx")[0] == "m/other.tga"
        found, tried = find_model_image(archive, "m/bot.md2", "a/none.pcx")
        assert found is None
        assert {"a/none.pcx", "a/none.tga", "m/none.pcx", "m/none.tga"} <= set(tried)
        assert len(tried) == len(set(tried))
