from __future__ import annotations

import builtins
import subprocess
import sys

import gmsh
import pytest
from meshing_scenes import plate

from cfmpm.errors import MeshError
from cfmpm.meshing import triangulate
from cfmpm.meshing.session import gmsh_session


def test_importing_the_package_does_not_load_gmsh():
    code = "import sys, cfmpm.meshing; sys.exit('gmsh' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


def test_a_missing_system_library_names_the_packages(monkeypatch):
    real = builtins.__import__

    def failing(name, *args, **kwargs):
        if name == "gmsh":
            raise OSError("libGLU.so.1: cannot open shared object file")
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", failing)
    with pytest.raises(MeshError, match=r"libGLU\.so\.1.*apt-get install .*libglu1-mesa") as caught:
        triangulate(plate())
    assert "\n" not in str(caught.value)


def test_gmsh_is_stopped_also_after_an_error():
    def fail():
        with gmsh_session():
            assert gmsh.isInitialized()
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert not gmsh.isInitialized()


def test_the_gmsh_session_of_someone_else_is_left_alone():
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        with pytest.raises(MeshError, match="gmsh is in use"):
            triangulate(plate())
        assert gmsh.isInitialized()
    finally:
        gmsh.finalize()


def test_a_failure_of_gmsh_says_what_to_change(monkeypatch):
    def failing(dim):
        raise Exception("PLC Error")

    monkeypatch.setattr(gmsh.model.mesh, "generate", failing)
    with pytest.raises(MeshError, match=r"PLC Error.*mesh\.size"):
        triangulate(plate())


def test_meshing_is_silent(capfd):
    triangulate(plate())
    assert capfd.readouterr() == ("", "")


def test_a_reader_that_goes_away_does_not_end_the_process():
    code = (
        "import os\n"
        "from cfmpm.meshing.session import gmsh_session\n"
        "with gmsh_session():\n"
        "    pass\n"
        "reader, writer = os.pipe()\n"
        "os.close(reader)\n"
        "try:\n"
        "    os.write(writer, b'x')\n"
        "except BrokenPipeError:\n"
        "    print('told')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "told\n")
