"""The courtyard that the program brings along: whole, reproducible, fit to be walked in."""

import io
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import followspot.builtin
from followspot.assets.bsp import BspFile
from followspot.assets.bsp_reader import read_bsp
from followspot.assets.shader_parser import find_entries
from followspot.builtin import build_courtyard
from followspot.builtin.courtyard_materials import SUN_PITCH, SUN_YAW
from followspot.builtin.courtyard_sky import SUFFIXES, daylight, face_directions, sky_radiance
from followspot.game import EYE_HEIGHT
from followspot.spaces import forward_from_angles

PK3 = Path(followspot.builtin.__file__).with_name("courtyard.pk3")
SUN = forward_from_angles(SUN_YAW, -SUN_PITCH)


@pytest.fixture(scope="module")
def files() -> dict[str, bytes]:
    with zipfile.ZipFile(PK3) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


@pytest.fixture(scope="module")
def bsp(files: dict[str, bytes]) -> BspFile:
    return read_bsp(files["maps/courtyard.bsp"], "courtyard.bsp")


def picture(data: bytes) -> NDArray[np.uint8]:
    return np.asarray(Image.open(io.BytesIO(data)))


def cluster_at(bsp: BspFile, point: NDArray[np.float64]) -> int:
    node = 0
    while node >= 0:
        plane = bsp.planes[bsp.nodes["plane"][node]]
        node = bsp.nodes["children"][node][int(plane["normal"] @ point < plane["distance"])]
    return int(bsp.leafs["cluster"][-1 - node])


def test_the_pk3_is_what_the_scripts_make(files: dict[str, bytes]) -> None:
    made = build_courtyard.courtyard_files()
    assert made.keys() == files.keys()
    for name, data in made.items():
        if name.endswith((".jpg", ".png")):  # encoders differ from machine to machine
            ours, theirs = picture(data).astype(int), picture(files[name]).astype(int)
            assert np.abs(ours - theirs).max() <= 8, name
        else:
            assert data == files[name], name


def test_the_pk3_is_small_and_its_textures_are_powers_of_two(files: dict[str, bytes]) -> None:
    assert PK3.stat().st_size < 4_000_000
    for name, data in files.items():
        if name.endswith((".jpg", ".png")):
            height, width = picture(data).shape[:2]
            assert height & (height - 1) == 0 and width & (width - 1) == 0, name


def test_every_surface_has_a_script_or_an_image(files: dict[str, bytes], bsp: BspFile) -> None:
    scripts = re.findall(r"^(textures/\S+)$", files["scripts/courtyard.shader"].decode(), re.M)
    stems = {name.rsplit(".", 1)[0] for name in files}
    for name in {shader["name"].decode() for shader in bsp.shaders}:
        assert name in scripts or name in stems, name
    named = re.findall(r"\S+/\S+\.(?:jpg|png)", files["scripts/courtyard.shader"].decode())
    assert set(named) <= files.keys()


def test_players_start_on_a_floor_with_room_to_stand(bsp: BspFile) -> None:
    starts = [e for e in bsp.entities if e["classname"] == "info_player_deathmatch"]
    assert len(starts) >= 4
    for start in starts:
        origin = np.array(start["origin"].split(), float)
        for above, is_open in ((EYE_HEIGHT, True), (-23.9, True), (-24.1, False)):
            assert (cluster_at(bsp, origin + np.array([0, 0, above])) >= 0) == is_open


def test_the_named_views_are_in_the_open(bsp: BspFile) -> None:
    views = re.findall(r"^    (\w+) +(-?\d+) +(-?\d+) +(\d+) ", build_courtyard.__doc__ or "", re.M)
    assert len(views) >= 6
    for name, *eye in views:
        assert cluster_at(bsp, np.array(eye, float)) >= 0, name


def test_the_skys_images_meet_without_a_seam(files: dict[str, bytes]) -> None:
    names = {s: f"env/courtyard_{s}.jpg" for s in SUFFIXES}
    faces = {s: picture(files[name]).astype(float) for s, name in names.items()}
    size = faces["rt"].shape[0]
    edges = []
    for suffix in SUFFIXES:
        directions, image = face_directions(suffix, size), faces[suffix]
        for line in (np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1]):
            edges.append((directions[line], image[line]))
    matched = 0
    for i, (directions, colours) in enumerate(edges):
        for other_directions, other_colours in edges[i + 1 :]:
            for way in (slice(None), slice(None, None, -1)):
                if np.abs(directions - other_directions[way]).max() < 2.1 / size:
                    matched += 1
                    assert np.abs(colours - other_colours[way]).mean() < 4
    assert matched == 12


def test_the_clear_sky_is_brightest_at_the_sun_and_bluest_opposite() -> None:
    up = np.array([0.0, 0.0, 1.0])
    opposite = SUN * [-1, -1, 1]
    at_sun, at_zenith, across = daylight(np.stack([SUN, up, opposite]), SUN, 2.8)
    assert at_sun.sum() > 2 * across.sum() > 0
    assert across[2] / across[0] > 1.5 and at_zenith[2] / at_zenith[0] > 1.5
    # the zenith's luminance, kcd/m2, by the paper's own formula
    chi = (4 / 9 - 2.8 / 120) * (np.pi - 2 * np.arccos(SUN[2]))
    zenith = (4.0453 * 2.8 - 4.9710) * np.tan(chi) - 0.2155 * 2.8 + 2.4192
    assert at_zenith @ [0.2126, 0.7152, 0.0722] == pytest.approx(zenith, rel=0.01)


def test_the_sky_has_no_holes() -> None:
    for suffix in SUFFIXES:
        radiance = sky_radiance(face_directions(suffix, 32), SUN)
        assert np.isfinite(radiance).all() and (radiance >= 0).all()


def test_the_shader_script_is_well_formed(files: dict[str, bytes]) -> None:
    text = files["scripts/courtyard.shader"].decode()
    entries, problems = find_entries(text, "courtyard.shader")
    assert len(entries) == 6 and not problems
    for entry in entries:
        assert entry.read().problems == ()
