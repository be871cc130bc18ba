"""The film in the page."""

from collections.abc import Iterator
from dataclasses import dataclass

from followspot.present import film, film_plan
from followspot.present.film_plan import FilmWish
from followspot.present.frames import Film, Picture
from followspot.present.interrupt import Interrupt
from followspot.present.report.material import Material
from followspot.present.report.page import fill
from followspot.present.report.pixels import jpeg
from followspot.present.report.section import Section
from followspot.present.still import Wish

FILE, POSTER = "film.mp4", "film.jpg"

CANDIDATES = 9
"""Frames of which one stands in the film's place before it plays."""


@dataclass(frozen=True)
class FilmStep:
    """Makes the film that was wished for; called like any other step."""

    wish: Wish
    film_wish: FilmWish

    def __call__(self, material: Material) -> Section:
        """The film in the report's folder, and what the page says of it."""
        to = film_plan.parse_output(str(material.folder / FILE), self.film_wish)
        scene, planned = film_plan.plan(material.name, self.wish, self.film_wish, to)
        every = -(-planned.frame_count // CANDIDATES)
        candidates: list[bytes] = []

        def watched(pictures: Iterator[Picture]) -> Iterator[Picture]:
            for number, picture in enumerate(pictures):
                if number % every == 0:
                    candidates.append(jpeg(picture))
                material.on_progress(number / planned.frame_count, "film")
                yield picture

        with Interrupt() as interrupt:
            jobs = self.film_wish.jobs
            drawn = film.draw_frames(material.name, scene, self.wish, planned, jobs, interrupt)
            limit = self.film_wish.max_bytes
            written = film.write(to, watched(drawn), planned, limit, interrupt)
        interrupt.again()
        figures = {"frames": written.frames, "bytes": written.bytes, "seconds": _seconds(planned)}
        html = fill(
            "film.html",
            film=planned,
            seconds=_seconds(planned),
            megabytes=written.bytes / 1e6,
            path=self.film_wish.path or next(iter(scene.paths), "auto"),
            name=material.name,
            file=FILE,
            poster=POSTER,
        )
        poster = max(candidates, key=len)  # what shows most takes most bytes, a wall the fewest
        return Section("film", "The film", html, figures, {POSTER: poster})


def _seconds(planned: Film) -> float:
    return planned.frame_count / float(planned.fps)
