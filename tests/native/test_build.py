"""What `canwire native` tells a build, and what CMake and pkg-config find."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from canwire.native import cmake_directory, pkg_config_directory
from tests.hubs import status_of
from tests.missing import find_program
from tests.native.conftest import Native


def test_options_for_a_compiler(native: Native, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert status_of("native", "vcinpl2", "--cflags", "--libs") == 0
    words = capsys.readouterr().out.split()
    made = tmp_path / "flat"
    subprocess.run(
        [find_program("gcc"), "-DFD", str(native.home / "flat.c"), *words, "-o", str(made)], check=True
    )
    assert os.access(made, os.X_OK)


def test_options_for_windows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ("native", "vcinpl2", "--windows", "--cflags", "--libs")
    monkeypatch.setattr("canwire.native._HERE", str(tmp_path))
    assert status_of(*asked) != 0
    assert "bash .ci/dlls" in capsys.readouterr().err
    made = tmp_path / "lib" / "windows"
    made.mkdir(parents=True)
    (made / "vciapi.dll").touch()
    assert status_of(*asked) == 0
    told = capsys.readouterr().out
    assert status_of("native", "candrv", "--windows", "--libs") != 0
    assert "Linux alone" in capsys.readouterr().err
    assert f"-idirafter {tmp_path}/include -L{made} -lvcinpl2 -luuid" in told


def test_nothing_asked_for_is_a_mistake(capsys: pytest.CaptureFixture[str]) -> None:
    assert status_of("native") == 2
    assert "say what to print" in capsys.readouterr().err


def test_pkg_config(native: Native) -> None:
    for name in ("vciapi", "vcinpl", "vcinpl2", "candrv", "acan"):
        told = subprocess.run(
            [find_program("pkg-config"), "--cflags", "--libs", name],
            env={**os.environ, "PKG_CONFIG_PATH": pkg_config_directory()},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        assert f"-l{name}" in told
        assert "-lcanwire" in told


def test_cmake(native: Native, tmp_path: Path) -> None:
    find_program("g++")
    (tmp_path / "driver.c").write_text('#include "canbusio.h"\nint main(void) { return !CloseHandle(0); }\n')
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.13)\nproject(sample C CXX)\nfind_package(canwire REQUIRED)\n"
        f"add_executable(sample {native.home}/errors.cpp)\ntarget_link_libraries(sample canwire::vciapi)\n"
        "add_executable(driver driver.c)\ntarget_link_libraries(driver canwire::candrv)\n"
    )
    cmake = find_program("cmake")
    subprocess.run(
        [cmake, f"-Dcanwire_DIR={cmake_directory()}", "."], cwd=tmp_path, check=True, capture_output=True
    )
    subprocess.run([cmake, "--build", "."], cwd=tmp_path, check=True, capture_output=True)
    assert os.access(tmp_path / "sample", os.X_OK)
