"""The renderer's sizes, and whose context it is."""

import pytest

from followspot.errors import UsageError
from followspot.gpu.context import create_context
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from synthetic import camera, floor, make_scene

pytestmark = pytest.mark.gl

WRONG = [(0, 5), (5, -1), (20000, 5), (5, 10**9)]


@pytest.mark.parametrize("size", WRONG)
def test_sizes_that_cannot_be_drawn(size: tuple[int, int]) -> None:
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
