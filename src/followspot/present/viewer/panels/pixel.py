"""One pixel, value by value down the pipeline."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from imgui_bundle import imgui

from followspot.assets.image import linear_to_srgb
from followspot.present.pixel import PixelReport, ShadowLookup, Surface
from followspot.present.viewer.panels import thumbnail
from followspot.present.viewer.state import Seen, State
from followspot.scene.material import Material
from followspot.scene.scene import Scene

_EDGE = 40.0
"""Of the thumbnail."""


def show(state: State, seen: Seen) -> State:
    """Draw the panel."""
    report = seen.found.pixel
    if report is None:
        told = "Click into the picture with the middle button to see how a pixel is made."
        imgui.text_wrapped(told)
        return state
    _, follows = imgui.checkbox("follow", state.follows_pixel)
    imgui.set_item_tooltip("Look at it again while camera, lights or settings change")
    imgui.same_line()
    if imgui.button("Forget"):
        return replace(state, asked=replace(state.asked, pixel=None))
    if seen.found.pixel_is_old and not follows:
        imgui.same_line()
        imgui.text_disabled("has changed since")
    material = _material(state.scene, report.surface)
    wanted = () if material is None else (material,)
    asked = replace(state.asked, follows=follows, thumbnails=(*state.asked.thumbnails, *wanted))
    state = replace(state, follows_pixel=follows, asked=asked)
    _surface(report, material, seen)
    flags = imgui.TableFlags_
    if imgui.begin_table("values", 2, flags.row_bg):
        imgui.table_setup_column("of what", imgui.TableColumnFlags_.width_fixed)
        imgui.table_setup_column("value", imgui.TableColumnFlags_.width_stretch)
        _geometry(report)
        for lookup in report.shadows:
            _shadow(lookup)
        _light(report)
        imgui.end_table()
    return state


def _material(scene: Scene, surface: Surface | None) -> Material | None:
    """The material that a surface's names are of."""
    materials = scene.worn
    names = None if surface is None else (surface.material, surface.texture)
    return next((m for m in materials if (m.name, m.image) == names), None)


def _surface(report: PixelReport, material: Material | None, seen: Seen) -> None:
    """What is seen, beside its thumbnail."""
    thumbnail.show(material, _EDGE, seen.found)
    imgui.same_line()
    imgui.begin_group()
    if report.surface is None:
        imgui.text("the sky")
    else:
        imgui.text(report.surface.material)
        imgui.text_disabled(report.surface.texture or "no image: white")
    imgui.end_group()
    if report.surface is not None:
        imgui.set_item_tooltip(f"{report.surface.material}\n{report.surface.texture or ''}")
    for surface in report.in_front:
        imgui.text_wrapped(f"seen through {surface.material}")


def _geometry(report: PixelReport) -> None:
    surface = report.surface
    face = "" if surface is None or surface.face is None else f"face {surface.face}"
    belongs = face if surface is None else surface.character or face
    _row("pixel", f"{report.x}, {report.y}: {belongs}" if belongs else f"{report.x}, {report.y}")
    if report.position is None or report.normal is None:
        return
    _row("position", _numbers(report.position, ".1f"))
    _row("depth", f"{report.depth:.2f} units")
    _row("normal", _numbers(report.normal, ".3f"))


def _shadow(lookup: ShadowLookup) -> None:
    """What surface and shadow shaders make of it for one light."""
    _row(f"{lookup.light}:", "")
    x, y, z, w = lookup.light_space
    _row("  light space", f"{_numbers((x, y, z), '.5g')}; {w:.5g}")
    _row("  divided by w", _numbers(lookup.divided, ".5f"))
    if not lookup.is_lit:
        _row("  not compared", "turned away, or outside the cone")
        return
    tile = "near" if lookup.is_near else "wide"
    _row("  texel", f"{tile} {lookup.texel[0]}, {lookup.texel[1]}")
    imgui.set_item_tooltip("Column and row in that of the light's tiles which is looked up")
    _row("  stored", _depth(lookup.stored, lookup.stored_distance))
    _row("  compared", _depth(float(lookup.divided[2]), lookup.compared_distance))
    _row("  arrives", f"{lookup.arrives:.3f}")


def _depth(depth: float, distance: float) -> str:
    return f"{depth:.6f}, {distance:.1f} units" if np.isfinite(distance) else "1, nothing there"


def _light(report: PixelReport) -> None:
    _row("visibility", f"{report.visibility:.3f}")
    imgui.set_item_tooltip("Share of the key light that arrives")
    _row("rho", _numbers(report.rho, ".4f"), linear_to_srgb(report.rho.clip(0, 1)))
    _row("E lights", _numbers(report.direct, ".4g"))
    imgui.set_item_tooltip("W/m²")
    _row("E around", _numbers(report.environment, ".4g"))
    imgui.set_item_tooltip("W/m², of the sky's light or of what was baked")
    if report.fog:
        _row("fog", f"{report.fog:.3f}")
        imgui.set_item_tooltip("Share of the light from there that fog holds back")
    _row("L", _numbers(report.radiance, ".4g"))
    imgui.set_item_tooltip(
        "W/(m² sr); rho E / pi where the surface is opaque, no fog before it and no light its own"
    )
    if report.emitted.any():
        _row("L emitted", _numbers(report.emitted, ".4g"))
        imgui.set_item_tooltip("Of that what surfaces shine by themselves")
    _row("L x exposure", _numbers(report.exposed, ".4f"))
    _row("displayed", _numbers(report.displayed, ".0f"), report.displayed / 255)
    imgui.set_item_tooltip("sRGB bytes")


def _numbers(values: Iterable[float], form: str) -> str:
    return ", ".join(format(float(value), form) for value in values)


def _row(label: str, text: str, colour: np.ndarray | None = None) -> None:
    """One line of the table, with a patch of a displayed colour."""
    imgui.table_next_column()
    imgui.text_disabled(label)
    imgui.table_next_column()
    if colour is not None:
        line = imgui.get_text_line_height()
        no_tooltip = imgui.ColorEditFlags_.no_tooltip
        imgui.color_button(f"##{label}", [*colour.tolist(), 1.0], no_tooltip, (line, line))
        imgui.same_line(0, 5)
    imgui.text(text)
