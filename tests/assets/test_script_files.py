"""An archive's shader scripts: which entry counts, and what is read when."""

import math
from pathlib import Path

import numpy as np
import pytest
from archive_fixtures import write_files, write_pak

from followspot.assets.archive import Archive
from followspot.assets.script_files import MAX_SCRIPT_BYTES, load_scripts
from followspot.assets.shader_script import lookup_name
from followspot.assets.shader_values import (
    AlphaTest,
    BlendFactor,
    Sides,
    SkyParms,
)
from followspot.errors import AssetError

BASEOA = Path("/usr/share/games/openarena/baseoa")


class _Files:
    """An archive in memory, made of full names."""

    def __init__(self, files: dict[str, bytes | AssetError]) -> None:
        self.sources = {source.split(":")[-1].removeprefix("/base/"): source for source in files}
        self.files = files

    def names(self, prefix: str, suffix: str) -> list[str]:
        return [name for name in self.sources if name.startswith(prefix) and name.endswith(suffix)]

    def read(self, name: str) -> bytes:
        data = self.files[self.sources[name]]
        if isinstance(data, AssetError):
            raise data
        return data

    def source(self, name: str) -> str:
        return self.sources[name]

    def root(self, name: str) -> int:
        return 0


@pytest.mark.parametrize("games", [("baseoa", "baseq3"), ("baseq3", "baseoa")])
def test_an_entry_of_an_earlier_root_wins_whatever_its_script_is_called(
    tmp_path: Path, games: tuple[str, str]
) -> None:
    roots = [tmp_path / game for game in games]
    for root, script in zip(roots, ("z", "a"), strict=True):
        text = f"textures/x {{ {root.name} }}"
        write_pak(root / f"pak{script}.pk3", {f"scripts/{script}.shader": text})
    write_files(roots[0], {"scripts/y.shader": "textures/y { loose }"})
    write_pak(roots[1] / "pak0.pk3", {"scripts/y2.shader": "textures/y { packed }"})
    with Archive.open(roots) as archive:
        scripts = load_scripts(archive)
        assert [archive.root(f"scripts/{name}.shader") for name in "za"] == [0, 1]
    assert str(scripts["textures/x"].directives[0]) == games[0]
    assert str(scripts["textures/y"].directives[0]) == "loose"


def test_of_entries_with_one_name_the_engines_choice_wins() -> None:
    files = _Files(
        {
            "/base/scripts/z.shader": b"pak { loose }\nloose { loose }",
            "b.pk3:scripts/y.shader": b"pak { b }\nscript { b }",
            "A.pk3:scripts/a.shader": b"pak { a }\nscript { first }\nloose { a }",
            "A.pk3:scripts/b.shader": b"SCRIPT { last }\nscript { late }\nagain { 1 }\nagain { 2 }",
            "A.pk3:scripts/b.txt": b"pak { text }",
            "A.pk3:maps/c.shader": b"pak { map }",
        }
    )
    scripts = load_scripts(files)
    assert {name: str(shader.directives[0]) for name, shader in scripts.items()} == {
        "pak": "a",
        "script": "last",
        "again": "1",
        "loose": "a",
    }
    assert scripts["script"].source == "A.pk3:scripts/b.shader"
    assert scripts.problems == ()


def test_only_entries_that_are_asked_for_are_read_and_have_problems() -> None:
    text = b"good { cull none }\nbad\n{\n  cull sideways\n}\nlost { { { } } }\nworse { sort up }"
    scripts = load_scripts(_Files({"p.pk3:scripts/a.shader": text}))
    assert list(scripts) == ["good", "bad", "worse"]
    lost = ("line 6", "'{'")
    assert [(problem.place, problem.found) for problem in scripts.problems] == [lost]

    assert scripts["good"].cull is Sides.BOTH
    assert scripts.get("lost") is None
    assert [(problem.place, problem.found) for problem in scripts.problems] == [lost]

    wrong = ("line 4", "'cull sideways'")
    for _ in range(2):  # a problem is told once, however often its entry is asked for
        assert scripts["bad"].cull is Sides.FRONT
        assert [(problem.place, problem.found) for problem in scripts.problems] == [lost, wrong]
    assert scripts["bad"] is scripts["bad"]
    with pytest.raises(KeyError):
        scripts["lost"]


def test_a_bad_file_is_a_problem_and_the_others_are_kept() -> None:
    broken = AssetError("p.pk3:scripts/b.shader", expected="a checksum", found="another")
    files = _Files(
        {
            "p.pk3:scripts/a.shader": b"a { \xe9 }\n}",
            "p.pk3:scripts/b.shader": broken,
            "p.pk3:scripts/c.shader": b" " * (MAX_SCRIPT_BYTES + 1),
            "p.pk3:scripts/d.shader": b"",
        }
    )
    scripts = load_scripts(files)
    assert list(scripts) == ["a"]
    assert scripts.problems[1] is broken
    assert [(problem.source, problem.place) for problem in scripts.problems] == [
        ("p.pk3:scripts/c.shader", ""),
        ("p.pk3:scripts/b.shader", ""),
        ("p.pk3:scripts/a.shader", "line 2"),
    ]


@pytest.mark.openarena
def test_known_openarena_entries() -> None:
    with Archive.open([BASEOA]) as archive:
        scripts = load_scripts(archive)
    assert len(scripts) >= 1575
    assert not scripts.problems  # no entry is lost
    assert len(list(scripts.values())) == len(scripts)  # now all are read
    sources = [problem.source for problem in scripts.problems]
    assert set(sources) == {
        "pak6-patch088.pk3:scripts/hotmenu.shader",
        "z_oacmp-volume1-v3.pk3:scripts/akom_teleporter.shader",
    }

    desert = scripts["textures/cosmo_skies/desertsky1"]
    assert desert.source == "pak6-patch088.pk3:scripts/cosmoflash.shader"
    assert desert.sky_box == SkyParms("env/sky1/sky001", 512.0, None)
    assert desert.surfaceparms == {"noimpact", "nomarks", "nolightmap", "sky", "nodlight"}
    assert desert.sun is not None
    np.testing.assert_allclose(desert.sun.color, [1, 0.572 / 0.98, 0.172 / 0.98])
    assert desert.sun.intensity == 175
    flat = -math.cos(math.radians(75)) * math.sqrt(0.5)
    height = math.sin(math.radians(75))
    np.testing.assert_allclose(desert.sun.direction_to_sun, [flat, flat, height])

    clouds = scripts["textures/gig01/gigsky1"]
    assert clouds.sky_box == SkyParms(None, 512.0, None)
    assert [layer.image for layer in clouds.stages] == [
        "textures/gig01/dimclouds_gr.tga",
        "textures/skies/dimclouds.tga",
    ]
    assert [layer.blend for layer in clouds.stages] == [None, (BlendFactor.ONE, BlendFactor.ONE)]
    assert str(clouds.stages[1].get("tcmod")) == "tcmod scroll 0.02 0.07"

    icon = scripts["team_icon/scumm_red"]
    assert (icon.line, icon.cull, icon.is_polygonoffset) == (1, Sides.BOTH, True)
    assert icon.stages[0].alpha_test is AlphaTest.GE128
    assert icon.stages[0].blend == (BlendFactor.DST_COLOR, BlendFactor.ONE)
    assert str(icon.stages[0].get("rgbgen")) == "rgbgen wave sin .9 1 0 .1"

    assert scripts[lookup_name("models\\weapons2\\grapple\\hook.tga")].name.endswith("/hook")
