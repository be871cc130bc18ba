"""Frames of a film drawn by several processes, handed on in the order of their numbers.

Process j of n draws the frames j, j + n, j + 2n, ... and writes their bytes to a pipe. A pipe holds
about a frame, so that no process runs far ahead. It is a plain command with a job on stdin:
``python -m followspot.present.workers``. A byte before each picture says that it is one; before the
text of an error that a user caused stands another.
"""

import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from io import FileIO
from select import select

import numpy as np

from followspot.errors import FollowspotError, UsageError
from followspot.present.frames import Film, FilmCamera, Picture, lit_along
from followspot.present.still import Wish, open_scene

_PIPE_BYTES = 1 << 20
_PICTURE, _ERROR = 0, 1
_PATIENCE = 0.1  # seconds between looks at whether somebody wants to stop


@dataclass(frozen=True)
class Job:
    """What one process draws; everything that it needs to know."""

    scene: str
    wish: Wish
    film: Film
    numbers: range


def pictures(
    scene: str, wish: Wish, film: Film, jobs: int, stopped: Callable[[], bool]
) -> Iterator[Picture]:
    """All frames of a film, in order, until somebody wants to stop.

    Args:
        scene: Name of the scene that the film is of; each process opens it anew.
        wish: What was typed about it.
        film: What to draw.
        jobs: How many processes draw it.
        stopped: Whether to stop waiting for the next frame.

    Raises:
        FollowspotError: a process could not start, or ended before its frames did.
    """
    workers: list[subprocess.Popen[bytes]] = []
    try:
        for j in range(min(jobs, film.frame_count)):
            workers.append(_start())
            _give(workers[-1], Job(scene, wish, film, range(j, film.frame_count, jobs)))
        for number in range(film.frame_count):
            picture = _receive(workers[number % len(workers)], film.size, stopped)
            if picture is None:
                return
            yield picture
    finally:
        for worker in workers:
            worker.kill()
            with worker:  # closes its pipe and waits for it
                pass


def _start() -> "subprocess.Popen[bytes]":
    try:
        return subprocess.Popen(
            [sys.executable, "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            bufsize=0,
            pipesize=_PIPE_BYTES if sys.platform == "linux" else -1,
            process_group=0,  # Ctrl-C in a terminal is for us, who then end it
        )
    except OSError as error:
        raise UsageError(f"--jobs: no more processes can start here: {error.strerror}") from None


def _give(worker: "subprocess.Popen[bytes]", job: Job) -> None:
    assert worker.stdin is not None
    try:
        worker.stdin.write(pickle.dumps(job))
    except BrokenPipeError:
        raise _ended_early(worker) from None
    worker.stdin.close()


def _ended_early(worker: "subprocess.Popen[bytes]") -> FollowspotError:
    code = worker.wait()
    return FollowspotError(f"a process that drew frames ended early, with code {code}")


def _receive(
    worker: "subprocess.Popen[bytes]", size: tuple[int, int], stopped: Callable[[], bool]
) -> Picture | None:
    """The next picture of a process; none if somebody wants to stop before it is here."""
    sent = np.empty(1 + size[0] * size[1] * 3, np.uint8)
    missing = sent.data
    assert worker.stdout is not None
    while missing:
        if stopped():
            return None
        if select([worker.stdout], [], [], _PATIENCE)[0]:
            count = os.readv(worker.stdout.fileno(), [missing])
            if not count:
                break
            missing = missing[count:]
    come = len(sent) - len(missing)
    if come and sent[0] == _ERROR:
        raise FollowspotError((sent[1:come].tobytes() + worker.stdout.read()).decode())
    if missing:
        raise _ended_early(worker)
    return sent[1:].reshape(*size[::-1], 3)


def main() -> None:
    """Be one of the processes: a pickled `Job` on stdin, pictures or an error to stdout."""
    out = os.dup(1)
    os.dup2(2, 1)  # what anybody prints must not get among the pixels
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # nobody reads any more: end
    job: Job = pickle.load(sys.stdin.buffer)
    with open(out, "wb", buffering=0) as pipe:  # noqa: PTH123
        try:
            scene, _ = open_scene(job.scene, job.wish)
            scene = lit_along(scene, job.film.path, bake=job.wish.bake)
            with FilmCamera(scene, job.film) as camera:
                for picture in camera.pictures(job.numbers):
                    _send(pipe, _PICTURE, np.ascontiguousarray(picture).data.cast("B"))
        except FollowspotError as error:
            _send(pipe, _ERROR, memoryview(str(error).encode(errors="backslashreplace")))
            sys.exit(2)


def _send(pipe: FileIO, kind: int, what: memoryview) -> None:
    pipe.write(bytes([kind]))
    while what:
        what = what[pipe.write(what) :]


if __name__ == "__main__":
    main()
