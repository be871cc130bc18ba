"""Traced light on pictures: what was traced is what pixels show."""

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest

from followspot.passes.frame import FrameInput
from followspot.present.pixel import inspect_pixel
from followspot.present.renderer import Renderer
from followspot.scene import bounce
from followspot.scene.load import load

pytestmark = pytest.mark.gl


def test_pixels_show_the_light_that_was_traced() -> None:
    """On surfaces with lightmaps and on those without, whatever the settings say of baked light."""
    scene = load("courtyard")
    with scene.archive, Renderer((96, 72)) as renderer:
        light = bounce.trace(scene)
        baked = bounce.bake(scene)
        ratios = []
        for name in ("title", "arcade", "cloister", "stair", "fountain"):
            frame = FrameInput(baked, scene.cameras[name], baked.settings, exposure=1.0)
            renderer.open(baked)
            for x, y in ((20, 40), (48, 36), (76, 50), (30, 66), (60, 20)):
                told = inspect_pixel(renderer, frame, x, y)
                if told.position is None or told.normal is None or told.in_front:
                    continue
                expected = math.pi * light.at(told.position[np.newaxis], told.normal[np.newaxis])[0]
                ratios.append(told.environment / expected)
        found = np.array(ratios)
        assert len(found) > 15
        # Between luxels and vertices light is mixed linearly; the normal is that of the pixel.
        assert np.abs(np.median(found) - 1) < 0.03
        assert np.percentile(np.abs(found - 1), 75) < 0.15
        off = msgspec.structs.replace(baked.settings, sky_light=False)
        dark = renderer.render(baked, "arcade", ["environment"], settings=off, linear=True)
        assert dark["environment"].max() == 0
        flat = renderer.render(scene, "arcade", ["environment"], linear=True)["environment"]
        traced = renderer.render(baked, "arcade", ["environment"], linear=True)["environment"]
        again = replace(baked, level=scene.level)
        assert traced.mean() < 0.5 * flat.mean()
        back = renderer.render(again, "arcade", ["environment"], linear=True)["environment"]
        np.testing.assert_array_equal(back, flat)
