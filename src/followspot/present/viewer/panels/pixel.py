"""One pixel, value by value down the pipeline."""

from collections.abc import Iterable
from dataclasses import replace

from imgui_bundle import imgui

from followspot.present.pixel import PixelReport, ShadowLookup, Surface
from followspot.present.viewer.state import Seen, State

_THUMB = 40.0


def show(state: State, seen: Seen) -> State:
    """Draw the panel."""
    report = seen.found.pixel
    if report is None:
        imgui.text_wrapped(
            "Click into the picture with the middle button to see how a pixel is made."
        )
        return state
    changed, follows = imgui.checkbox("follow as things move", state.asked.follows)
    asked = replace(state.asked, thumbnails=True)
    state = replace(state, asked=replace(asked, follows=follows) if changed else asked)
    flags = imgui.TableFlags_.row_bg | imgui.TableFlags_.sizing_fixed_fit
    if imgui.begin_table("values", 2, flags):
        _table(report, seen)
        imgui.end_table()
    return state


def _table(report: PixelReport, seen: Seen) -> None:
    _row("pixel", f"{report.x}, {report.y}")
    if report.surface is None:
        _row("surface", "the sky")
    else:
        _row("surface", _named(report.surface))
        texture = seen.found.thumbnails.get(report.surface.texture)
        _label("texture")
        if texture is not None:
            imgui.image(imgui.ImTextureRef(texture.glo), (_THUMB, _THUMB))
        imgui.text_wrapped(report.surface.texture or "none: white")
    for surface in report.in_front:
        _row("in front", _named(surface))
    if report.position is not None and report.normal is not None:
        _row("position, units", _numbers(report.position, ".1f"))
        _row("depth, units", f"{report.depth:.2f}")
        _row("normal", _numbers(report.normal, ".3f"))
    for lookup in report.shadows:
        _shadow(lookup)
    _row("visibility", f"{report.visibility:.3f}")
    _row("rho", _numbers(report.rho, ".4f"))
    _row("E lights, W/m2", _numbers(report.direct, ".4g"))
    _row("E sky, W/m2", _numbers(report.environment, ".4g"))
    _row("L, W/(m2 sr)", _numbers(report.radiance, ".4g"))
    _row("L x exposure", _numbers(report.exposed, ".4f"))
    _label("displayed")
    color = [*(report.displayed / 255.0).tolist(), 1.0]
    imgui.color_button("##displayed", color, imgui.ColorEditFlags_.no_alpha)
    imgui.same_line()
    imgui.text(_numbers(report.displayed, "d"))


def _shadow(lookup: ShadowLookup) -> None:
    name = lookup.light
    _row(f"{name}: in the map", _numbers(lookup.light_space, ".1f"))
    _row("  divided", _numbers(lookup.divided, ".5f"))
    if not lookup.is_lit:
        _row("  compared", "not: turned away, or outside the cone")
        return
    _row("  texel", f"{lookup.texel[0]}, {lookup.texel[1]}")
    _row("  stored", f"{lookup.stored:.6f} ({lookup.stored_distance:.1f} units)")
    _row("  compared", f"{lookup.divided[2]:.6f} ({lookup.compared_distance:.1f} units)")
    _row("  arrives", f"{lookup.arrives:.3f}")


def _named(surface: Surface) -> str:
    place = surface.character or (f"face {surface.face}" if surface.face is not None else "")
    return f"{surface.material} ({place})" if place else surface.material


def _numbers(values: Iterable[float], form: str) -> str:
    return ", ".join(format(int(v) if form == "d" else float(v), form) for v in values)


def _label(label: str) -> None:
    imgui.table_next_column()
    imgui.text_disabled(label)
    imgui.table_next_column()


def _row(label: str, text: str) -> None:
    _label(label)
    imgui.text_wrapped(text)
