"""followspot: a real-time renderer for real game levels.

    import followspot

    scene = followspot.load("courtyard")
    with followspot.Renderer((640, 480)) as renderer:
        pictures = renderer.render(scene, views=["final", "normals"])

The names below are imported when they are first used, so that reading a level's file loads no
GL library.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from followspot.errors import AssetError, ContextError, FollowspotError, UsageError
    from followspot.passes.view import View
    from followspot.present.renderer import Renderer
    from followspot.scene.bounce import bake
    from followspot.scene.camera import Camera
    from followspot.scene.light import PointLight, SpotLight
    from followspot.scene.load import load
    from followspot.scene.scene import Scene
    from followspot.scene.settings import CullFace, Settings

__version__ = "0.1.0"

_HOMES = {
    "AssetError": "errors",
    "Camera": "scene.camera",
    "ContextError": "errors",
    "CullFace": "scene.settings",
    "FollowspotError": "errors",
    "PointLight": "scene.light",
    "Renderer": "present.renderer",
    "Scene": "scene.scene",
    "Settings": "scene.settings",
    "SpotLight": "scene.light",
    "UsageError": "errors",
    "View": "passes.view",
    "bake": "scene.bounce",
    "load": "scene.load",
}
__all__ = [
    "AssetError",
    "Camera",
    "ContextError",
    "CullFace",
    "FollowspotError",
    "PointLight",
    "Renderer",
    "Scene",
    "Settings",
    "SpotLight",
    "UsageError",
    "View",
    "bake",
    "load",
]


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'followspot' has no attribute {name!r}")
    return getattr(import_module(f"followspot.{_HOMES[name]}"), name)
