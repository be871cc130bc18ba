"""One renderer for the whole session, since a context is dear and one can be current at a time."""

import signal
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

import synthetic
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.scene.camera import Camera
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings

Draw = Callable[..., NDArray[np.float64]]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-golden",
        action="store_true",
        help="write the golden pictures anew, then look at them",
    )


@pytest.fixture
def heard_hang_up() -> Iterator[None]:
    """The end of the terminal, which nohup makes tests and what they start deaf to."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.fixture(scope="session")
def renderer() -> Iterator[Renderer]:
    with Renderer(synthetic.SIZE) as made:
        yield made


@pytest.fixture
def draw(renderer: Renderer) -> Draw:
    """Draw one view in linear float32; returned as float64, for NumPy to compare with."""

    def draw_linear(
        scene: Scene,
        camera: Camera,
        view: View | str,
        settings: Settings | None = None,
        time: float = 0.0,
        **changes: Any,
    ) -> NDArray[np.float64]:
        view = View(view)
        given = Settings() if settings is None else settings
        settings = msgspec.structs.replace(given, exposure=1.0, **changes)
        picture = renderer.render(scene, camera, [view], settings=settings, time=time, linear=True)[
            view
        ]
        return picture.astype(np.float64)

    return draw_linear
