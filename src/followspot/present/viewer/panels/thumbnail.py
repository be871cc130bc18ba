"""A material's thumbnail in a panel."""

from imgui_bundle import imgui

from followspot.present.viewer.asking import Found
from followspot.scene.material import Material


def show(material: Material | None, edge: float, found: Found) -> None:
    """Draw it, in its image's shape, in a square; that stays empty until there is one."""
    corner = imgui.get_cursor_screen_pos()
    imgui.dummy((edge, edge))
    thumbnail = None if material is None else found.thumbnails.get(material)
    if thumbnail is None:
        return
    longest = max(thumbnail.size)
    width, height = (edge * each / longest for each in thumbnail.size)
    x, y = corner.x + (edge - width) / 2, corner.y + (edge - height) / 2
    sheet = imgui.ImTextureRef(found.sheet.glo)
    corners = (x, y), (x + width, y + height), thumbnail.top_left, thumbnail.bottom_right
    imgui.get_window_draw_list().add_image(sheet, *corners)
