"""What frame times are taken of, and what ``followspot bench`` tells."""

import json
import sys
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from followspot import cli
from followspot.passes.frame import PASSES, FrameInput, FramePipeline
from followspot.present import bench
from followspot.present.renderer import Renderer
from followspot.present.still import Wish
from followspot.present.stopwatch import Steps
from followspot.scene.load import load_figure

pytestmark = pytest.mark.gl

ROBOT = "models/robot/robot.md2"


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[tuple[float, bool]]:
    """Of each frame that is drawn: its time, and whether its passes are timed."""
    frames: list[tuple[float, bool]] = []
    draw = FramePipeline.draw

    def watched(self: FramePipeline, frame: FrameInput, *more: Any, **named: Any) -> Any:
        frames.append((frame.time, len(more) > 1))
        return draw(self, frame, *more, **named)

    monkeypatch.setattr(FramePipeline, "draw", watched)
    return frames


def test_characters_move_on_in_every_frame_that_is_timed(
    renderer: Renderer, drawn: list[tuple[float, bool]]
) -> None:
    scene = load_figure(ROBOT, (), "run")
    renderer.open(scene)
    bench.frame_times(renderer, scene, scene.camera(), 4)
    steps = np.diff([time for time, _ in drawn])
    np.testing.assert_allclose(steps, 1 / bench.FRAME_RATE)
    assert len(drawn) == bench.WARM_UP + 4 and not any(timed for _, timed in drawn)
    drawn.clear()
    times = bench.pass_times(renderer, scene, scene.camera(), 4)
    assert times.keys() == set(PASSES)
    assert [timed for _, timed in drawn] == [False, True, True, True, True]
    np.testing.assert_allclose(np.diff([time for time, _ in drawn]), 1 / bench.FRAME_RATE)


def test_the_first_frame_is_one(
    monkeypatch: pytest.MonkeyPatch, drawn: list[tuple[float, bool]]
) -> None:
    counts = []
    steps = Steps.__call__

    def step(self: Steps, name: str) -> None:
        counts.append((name, len(drawn)))
        steps(self, name)

    monkeypatch.setattr(Steps, "__call__", step)
    bench.run(ROBOT, Wish(size="32x24"), 2, False, lambda _: None)
    assert counts[-2:] == [("upload", 0), ("first frame", 1)]


@pytest.mark.parametrize("sweep", [False, True])
def test_all_figures_for_programs(
    sweep: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    typed = ["bench", "courtyard", "--size", "32x24", "--frames", "3", "--json"]
    monkeypatch.setattr(sys, "argv", ["followspot", *typed, *(["--sweep"] if sweep else [])])
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as done:
        cli.main()
    assert done.value.code == 0
    told = json.loads(capsys.readouterr().out)
    assert told.keys() == {field.name for field in msgspec.structs.fields(bench.Result)}
    assert (told["scene"], told["size"], told["frames"]) == ("courtyard", [32, 24], 3)
    assert {"create context", "upload", "first frame"} < told["load_ms"].keys()
    assert told["load_total_ms"] == pytest.approx(sum(told["load_ms"].values()))
    assert told["redraw_shadows"] is False
    names = [view["camera"] for view in told["views"]]
    assert len(names) == len(set(names)) and (len(names) > 1) is sweep
    for view in told["views"]:
        assert view.keys() == {field.name for field in msgspec.structs.fields(bench.Timing)}
        assert view["pass_ms"].keys() == set(PASSES)
        assert view["submit_ms"] > 0 and view["median_ms"] <= view["p95_ms"] <= view["worst_ms"]
        counts = view["frame"]
        assert counts["draws"] > 0 and 0 < counts["triangles"] <= counts["triangles_in_scene"]
        assert not counts["shadow_redrawn"] and counts["shadow_draws"] == 0
    assert list(tmp_path.iterdir()) == []
