"""What the report consists of, in the page's order."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from followspot.present import arguments
from followspot.present.film_plan import FilmWish
from followspot.present.report import (
    bias_answer,
    environment_answer,
    interpolation_answer,
    lights_answer,
)
from followspot.present.report.film_step import FilmStep
from followspot.present.report.frame_time import frame_time
from followspot.present.report.material import Material
from followspot.present.report.section import Section
from followspot.present.report.stages import stages, title
from followspot.present.still import Wish


@dataclass(frozen=True)
class Step:
    """One thing to make: a section of the page, with its pictures and numbers.

    Attributes:
        anchor: Its section's.
        title: What it is called where it is told of; its section's too, if there is none.
        make: Draws, measures and writes.
    """

    anchor: str
    title: str
    make: Callable[[Material], Section]


def all_steps(wish: Wish, film_wish: FilmWish | None) -> tuple[Step, ...]:
    """Every step of a report.

    Args:
        wish: Camera, size, lights and settings, for the film.
        film_wish: What film is wanted, if one is.
    """
    width, height = arguments.parse_size(wish.size)
    even = f"{width + width % 2}x{height + height % 2}"  # a film has a colour every 2 x 2 pixels
    film = []
    if film_wish is not None:
        film = [Step("film", "The film", FilmStep(replace(wish, size=even), film_wish))]
    return (
        Step("title", "The title picture", title),
        *film,
        Step("stages", "One picture, stage by stage", stages),
        Step("frame-time", "Where a frame's time goes", frame_time),
        Step("environment", "Six directions for a whole sky", environment_answer.section),
        Step("bias", "Why the shadow map holds back faces", bias_answer.section),
        Step("lights", "Handling many lights", lights_answer.section),
        Step("interpolation", "The shadow matrix and interpolation", interpolation_answer.section),
    )
