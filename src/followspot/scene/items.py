"""A level's pick-ups where its entities say: weapons, ammunition, armour, health, power-ups, flags.

Sources: the table of items in ``bg_misc.c``, ``FinishSpawningItem`` of ``g_items.c`` and
``CG_Item`` of ``cg_ents.c`` of Quake III Arena and OpenArena.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from followspot.arrays import Floats
from followspot.assets.bsp import BspFile
from followspot.assets.entities import entity_flags, entity_vector
from followspot.errors import AssetError
from followspot.scene import figure, walk
from followspot.scene.character import Character
from followspot.scene.figure import Figure
from followspot.scene.figure_file import FigureFiles
from followspot.scene.ground import Ground

ABOVE_FLOOR = 15.0
"""Units from an item's origin down to the floor (``ITEM_RADIUS``)."""

SUSPENDED = 1
"""The spawn flag of items that hang where they are."""

BOB = 4.0
"""Units by which items move up and down."""

BOB_RATE, BOB_RATE_STEP = 5.0, 0.01
"""Radians a second of that, and how much more for every entity that stands before it in the level.
(The game has its own numbers of entities there, among them players'.)"""

WEAPON_SCALE, WEAPON_RISE = 1.5, 8.0
"""Weapons lie larger than they are held, and so much higher in units."""

RING_RISE = 12.0
"""Units by which the ring of a power-up is higher."""

_SLOW, _FAST, _RING = 360 / 2.048, 360 / 1.024, -360 / 1.024  # degrees a second

_WEAPONS = {
    **{w: w for w in ("gauntlet", "shotgun", "machinegun", "lightning", "railgun", "bfg")},
    "grenadelauncher": "grenadel",
    "rocketlauncher": "rocketl",
    "plasmagun": "plasma",
    "grapplinghook": "grapple",
}
_AMMUNITION = {
    "shells": "shotgun",
    "bullets": "machinegun",
    "grenades": "grenade",
    "cells": "plasma",
    "lightning": "lightning",
    "rockets": "rocket",
    "slugs": "railgun",
    "bfg": "bfg",
    "nails": "nailgun",
    "mines": "proxmine",
    "belt": "chaingun",
}
_HEALTH = {"_small": "small", "": "medium", "_large": "large", "_mega": "mega"}
_POWER_UPS = ("quad", "enviro", "haste", "invis", "regen", "flight")

MODELS: dict[str, tuple[str, ...]] = {
    "item_armor_shard": ("powerups/armor/shard",),
    "item_armor_combat": ("powerups/armor/armor_yel",),
    "item_armor_body": ("powerups/armor/armor_red",),
    "holdable_teleporter": ("powerups/holdable/teleporter",),
    "holdable_medkit": ("powerups/holdable/medkit",),
    "holdable_kamikaze": ("powerups/kamikazi",),
    "holdable_portal": ("powerups/holdable/porter",),
    "holdable_invulnerability": ("powerups/holdable/invulnerability",),
    "item_scout": ("powerups/scout",),
    "item_guard": ("powerups/guard",),
    "item_doubler": ("powerups/doubler",),
    "item_ammoregen": ("powerups/ammo",),
    "team_ctf_redflag": ("flags/r_flag",),
    "team_ctf_blueflag": ("flags/b_flag",),
    "team_ctf_neutralflag": ("flags/n_flag",),
    "weapon_nailgun": ("weapons/nailgun/nailgun",),
    "weapon_prox_launcher": ("weapons/proxmine/proxmine",),
    "weapon_chaingun": ("weapons/vulcan/vulcan",),
    **{f"weapon_{n}": (f"weapons2/{m}/{m}",) for n, m in _WEAPONS.items()},
    **{f"ammo_{n}": (f"powerups/ammo/{m}am",) for n, m in _AMMUNITION.items()},
    **{
        f"item_health{n}": (f"powerups/health/{m}_cross", f"powerups/health/{m}_sphere")
        for n, m in _HEALTH.items()
    },
    **{f"item_{n}": (f"powerups/instant/{n}", f"powerups/instant/{n}_ring") for n in _POWER_UPS},
}
"""By class in lower case: models below ``models``, without ``.md3``; the second goes round the
first. The game's table has second models of armour shards and the medkit, too, but `CG_Item` draws
those of health and power-ups alone."""


class _Item(NamedTuple):
    """An item of a level: the number of its entity, its class, its origin, whether it hangs."""

    number: int
    kind: str
    origin: tuple[float, float, float]
    hangs: bool


def items(bsp: BspFile, files: FigureFiles, ground: Ground) -> list[Character]:
    """All items of a level, turning and bobbing.

    Models that are not there or cannot be read are listed in `FigureFiles.problems` and left out;
    the second model of an item, which many games lack, is left out silently.

    Args:
        bsp: Its entities are looked at.
        files: Where models come from.
        ground: What items that do not hang fall on.
    """
    found = list(_found(bsp))
    places = np.array([item.origin for item in found]).reshape(-1, 3)
    floor = ground.below(places)
    figures: dict[str, Figure | None] = {}
    characters = []
    for item, place, height in zip(found, places, floor.tolist(), strict=True):
        if not item.hangs and height < place[2]:
            place[2] = height + ABOVE_FLOOR
        for order, model in enumerate(MODELS[item.kind]):
            if model not in figures:
                figures[model] = _open(files, model, is_needed=order == 0)
            shown = figures[model]
            if shown is not None:
                characters.append(_character(item, shown, place, is_second=order > 0))
    return characters


def _found(bsp: BspFile) -> Iterator[_Item]:
    for number, entity in enumerate(bsp.entities):
        kind = entity.get("classname", "").lower()
        origin = entity_vector(entity, "origin")
        if kind in MODELS and origin is not None:
            hangs = bool(entity_flags(entity) & SUSPENDED)
            yield _Item(number, kind, (origin[0], origin[1], origin[2]), hangs)


def _open(files: FigureFiles, model: str, *, is_needed: bool) -> Figure | None:
    path = f"models/{model}.md3"
    if not is_needed and not files.has(path):
        return None
    try:
        opened = files.open(path)
    except AssetError as error:
        files.problems.append(error)
        return None
    return _as_it_lies(opened) if model.startswith("weapons") else opened


def _as_it_lies(weapon: Figure) -> Figure:
    """A weapon round its own middle instead of round the hand that holds it."""
    if not weapon.parts:
        return weapon
    points = np.concatenate([part.positions[0] for part in weapon.parts])
    middle = (points.min(axis=0).astype(np.float64) + points.max(axis=0)) / 2
    matrix = np.diag([WEAPON_SCALE] * 3 + [1.0])
    matrix[:3, 3] = -WEAPON_SCALE * middle
    return figure.transformed(weapon, matrix)


def _character(item: _Item, shown: Figure, place: Floats, *, is_second: bool) -> Character:
    rise, spin = 0.0, _SLOW
    if item.kind.startswith("weapon_"):
        rise = WEAPON_RISE
    elif item.kind.startswith("item_health"):
        spin = 0.0 if is_second else _FAST
    elif is_second and item.kind.removeprefix("item_") in _POWER_UPS:
        rise, spin = RING_RISE, _RING
    return Character(
        shown,
        walk.standing(place + np.array([0.0, 0.0, rise])),
        clock=1.0,  # the game bobs by its time plus one second
        spin=spin,
        bob=BOB,
        bob_rate=BOB_RATE + BOB_RATE_STEP * item.number,
    )
