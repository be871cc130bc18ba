"""The renderer's sizes, and whose context it is."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from followspot.errors import UsageError
from followspot.gpu.context import create_context
from followspot.passes.frame import FrameInput
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from synthetic import camera, floor, make_scene

pytestmark = pytest.mark.gl

WRONG: list[Any] = [(0, 5), (5, -1), (20000, 5), (5, 10**9), (6.5, 5), ("6", 5), (6,), (6, 5, 4)]


@pytest.mark.parametrize("size", WRONG)
def test_sizes_that_cannot_be_drawn(size: Any) -> None:
    scene = make_scene([floor()])
    with pytest.raises(UsageError, match="edges are 1 to "):
        Renderer(size)
    with Renderer((8, 6)) as renderer:
        with pytest.raises(UsageError, match="edges are 1 to "):
            renderer.resize(size)
        drawn = renderer.render(scene, camera((0, 0, 9)), [View.NORMALS])[View.NORMALS]
        assert drawn.shape == (6, 8, 3), "it goes on as it was"


def test_a_context_that_was_lent_stays_open() -> None:
    context = create_context()
    try:
        with pytest.raises(UsageError):
            Renderer((0, 0), context)
        with Renderer((8, 6), context) as renderer:
            renderer.open(make_scene([floor()]))
        assert context.buffer(b"still there").read() == b"still there"
    finally:
        context.release()


def test_a_size_may_be_numpys() -> None:
    with Renderer(tuple(np.array([8, 6]))) as renderer:
        drawn = renderer.render(make_scene([floor()]), camera((0, 0, 9)), [View.NORMALS])
    assert drawn["normals"].shape == (6, 8, 3)


@pytest.mark.parametrize(
    "use",
    [
        lambda r, scene, view: r.render(scene, view),
        lambda r, scene, view: r.open(scene),
        lambda r, scene, view: r.exposure(scene, view),
        lambda r, scene, view: r.draw(FrameInput(scene, view, scene.settings, 1.0)),
        lambda r, scene, view: r.pass_times(FrameInput(scene, view, scene.settings, 1.0)),
        lambda r, scene, view: r.resize((9, 9)),
        lambda r, scene, view: r.target(),
        lambda r, scene, view: r.finish(),
        lambda r, scene, view: r.shadow_map_texture(),
        lambda r, scene, view: r.gl_renderer,
    ],
)
def test_a_closed_renderer_says_so(use: Callable[..., object]) -> None:
    scene, view = make_scene([floor()]), camera((0, 0, 9))
    with Renderer((8, 6)) as renderer:
        renderer.render(scene, view)
    renderer.close()
    with pytest.raises(UsageError, match="the renderer is closed"):
        use(renderer, scene, view)
