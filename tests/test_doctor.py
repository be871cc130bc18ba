import sys
from pathlib import Path

import pytest

from followspot.errors import ContextError
from followspot.gpu.context import HEADLESS_PACKAGES, backends, create_context, is_software
from followspot.present import doctor
from followspot.present.doctor import Trial
from followspot.present.renderer import Renderer

LLVMPIPE = Trial(
    "EGL device 1", "4.5 (Core Profile) Mesa 22.3.6", "llvmpipe (LLVM 15.0.6, 256 bits)"
)
GPU = Trial("EGL device 0", "4.6 (Core Profile) Mesa 25.0.7", "AMD Radeon 780M (radeonsi)")
BROKEN = Trial("EGL device 0", problem="eglInitialize failed (0x3001)")


@pytest.fixture
def no_driver(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A machine with EGL's dispatcher, but nothing behind it, and no display."""
    monkeypatch.setenv("__EGL_VENDOR_LIBRARY_DIRS", str(tmp_path))
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("GLCONTEXT_DEVICE_INDEX", raising=False)


def pretend_python(monkeypatch: pytest.MonkeyPatch, folder: Path, line: str) -> None:
    script = folder / "python"
    script.write_text(f"#!/bin/sh\n{line}\n")
    script.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(script))


@pytest.mark.gl
def test_the_first_way_that_works_is_the_one_the_renderer_uses(renderer: Renderer) -> None:
    trials = doctor.examine()
    used = next(trial for trial in trials if trial.works)
    assert [trial.way for trial in trials] == list(backends())
    assert used.renderer == renderer.gl_renderer
    assert int(used.version[0]) >= 3
    assert f"draws with {used.way}" in doctor.verdict(trials)


@pytest.mark.gl
def test_exit_code_0_and_no_failure_over_a_game_folder_that_is_not_there(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("FOLLOWSPOT_ASSETS", "/no/such/folder")
    assert doctor.print_report() == 0
    printed = capsys.readouterr().out
    assert "/no/such/folder" in printed
    assert "moderngl" in printed
    assert "hypothesis" not in printed  # only what is needed at run time


@pytest.mark.gl
@pytest.mark.usefixtures("no_driver")
def test_exit_code_2_and_what_to_install_without_a_driver(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert doctor.print_report() == 2
    printed = " ".join(capsys.readouterr().out.split())
    assert f"apt-get install {HEADLESS_PACKAGES}" in printed


@pytest.mark.gl
def test_a_device_that_is_not_there_is_a_problem_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setenv("GLCONTEXT_DEVICE_INDEX", "99")
    (trial,) = doctor.examine()
    assert trial.way == "EGL device 99"
    assert "99" in trial.problem
    with pytest.raises(ContextError, match=r"EGL device 99: .*apt-get install.*followspot doctor"):
        create_context()


def test_without_libraries_the_error_names_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr("followspot.gpu.context._EGL", "libEGL-not-there.so.1")
    with pytest.raises(ContextError, match=r"EGL device 0: libEGL-not-there\.so\.1 not "):
        create_context()


def test_a_driver_that_crashes_is_a_problem_told(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    pretend_python(monkeypatch, tmp_path, "kill -SEGV $$")
    assert doctor.try_way("EGL device 0").problem == "the driver crashed (SIGSEGV)"
    (trial,) = doctor.examine()
    assert not trial.works


def test_a_driver_that_hangs_is_given_up(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pretend_python(monkeypatch, tmp_path, "exec sleep 100")
    monkeypatch.setattr(doctor, "_TIMEOUT", 0.1)
    assert doctor.try_way("EGL device 0").problem == "no answer within 0.1 s"


@pytest.mark.parametrize(
    ("trials", "sentence"),
    [
        ([BROKEN, LLVMPIPE], "with EGL device 1, in software"),
        ([GPU, LLVMPIPE], "with EGL device 0, on the GPU."),
        (
            [LLVMPIPE, Trial("GLX on display :0", "4.6", "NVIDIA")],
            "There is a GPU on GLX on display :0",
        ),
        ([BROKEN], "Nothing can be drawn"),
        ([], "Nothing can be drawn"),
    ],
)
def test_verdict(trials: list[Trial], sentence: str) -> None:
    assert sentence in doctor.verdict(trials)


@pytest.mark.parametrize(
    ("renderer", "software"),
    [
        ("llvmpipe (LLVM 15.0.6, 256 bits)", True),
        ("softpipe", True),
        ("zink Vulkan 1.3 (llvmpipe (LLVM 19.1.7, 256 bits) (MESA_LLVMPIPE))", True),
        ("Google SwiftShader", True),
        ("Apple Software Renderer", True),
        ("NVIDIA H100 80GB HBM3/PCIe/SSE2", False),
        ("Mesa Intel(R) UHD Graphics 620 (KBL GT2)", False),
        ("D3D12 (AMD Radeon RX 6800)", False),
    ],
)
def test_software_is_told_from_a_gpu(renderer: str, software: bool) -> None:
    assert is_software(renderer) is software


@pytest.mark.skipif(
    "not sys.platform.startswith('linux')", reason="other systems load GL by framework"
)
def test_libraries_are_named_as_run_time_packages_install_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("DISPLAY", ":0")
    names = {
        value
        for arguments in backends().values()
        for key, value in arguments.items()
        if key.startswith("lib")
    }
    assert names == {"libEGL.so.1", "libGL.so.1", "libX11.so.6"}
