from __future__ import annotations

import builtins
import os
import resource
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import gmsh
import pytest
from meshing_scenes import plate

from cfmpm.errors import MeshError
from cfmpm.interruption import terminated_as_interrupted
from cfmpm.meshing import triangulate
from cfmpm.meshing.session import gmsh_session, in_child


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


class TestChild:
    """Meshing that would delay signals runs in a child process."""

    def test_results_and_errors_come_back(self):
        assert in_child(lambda: {"pid": 3}) == {"pid": 3}
        pid = in_child(os.getpid)
        assert pid != os.getpid()
        with pytest.raises(MeshError, match="as it was raised"):
            in_child(lambda: raising(MeshError("as it was raised")))

    @pytest.mark.parametrize("number", [signal.SIGSEGV, signal.SIGKILL])
    def test_a_crash_is_told(self, number):
        with pytest.raises(MeshError, match=f"gmsh has ended with {number.name}"):
            in_child(lambda: os.kill(os.getpid(), number))

    def test_a_child_without_a_result_is_told(self):
        with pytest.raises(MeshError, match="gmsh has ended with status 3"):
            in_child(lambda: os._exit(3))

    def test_interrupts_end_the_child(self, tmp_path):
        def work():
            (tmp_path / "pid").write_text(str(os.getpid()))
            os.kill(os.getppid(), signal.SIGTERM)
            time.sleep(60)
            (tmp_path / "left").touch()

        with terminated_as_interrupted(), pytest.raises(KeyboardInterrupt):
            in_child(work)
        assert not (tmp_path / "left").exists()
        with pytest.raises(ProcessLookupError):
            os.kill(int((tmp_path / "pid").read_text()), 0)

    def test_in_a_thread_work_is_done_in_place(self):
        found = []
        thread = threading.Thread(target=lambda: found.append(in_child(os.getpid)))
        thread.start()
        thread.join()
        assert found == [os.getpid()]


def raising(error):
    raise error


FINE = """\
name: fine
geometry: {outline: [[0, 0], [10, 0], [10, 10], [0, 10]], cracks: [{points: [[0, 5], [3, 5]]}]}
material: {E: 210e3, nu: 0.3}
loads: [{edge: edge_1, displacement: {x: 0, y: 0}}, {edge: edge_3, traction: [0, 1]}]
mesh: {element: T3, size: 0.006, grading: uniform}
"""


def time_of(pid):
    """Time that the processor has spent on a process and its children so far [s]."""
    found = subprocess.run(["pgrep", "-P", str(pid)], capture_output=True, text=True).stdout
    total = 0
    for one in (pid, *found.split()):
        after_name = Path(f"/proc/{one}/stat").read_text().rpartition(")")[2].split()
        total += sum(map(int, after_name[11:15]))  # its own, and of its children that have ended
    return total / os.sysconf("SC_CLK_TCK")


def time_of_ended():
    """Time that the processor has spent on children of this process that have ended [s]."""
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_command_that_meshes_ends_when_it_is_asked_to(number, tmp_path):
    (tmp_path / "fine.yaml").write_text(FINE)
    command = [sys.executable, "-m", "cfmpm", "run", "fine.yaml"]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        assert "meshing about" in process.stderr.readline()
        while not subprocess.run(["pgrep", "-P", str(process.pid)], capture_output=True).stdout:
            time.sleep(0.1)
        time.sleep(1.0)  # well inside gmsh
        before = time_of(process.pid)
        ended = time_of_ended()
        process.send_signal(number)
        said = process.stderr.read()
        assert process.wait(120) == 128 + number
    # Not the time that passes, in which the machine may do other work. Gmsh takes half a minute.
    assert time_of_ended() - ended - before < 2.0
    assert said.endswith("cfmpm: interrupted\n")


def test_meshing_is_silent(capfd):
    triangulate(plate())
    assert capfd.readouterr() == ("", "")


@pytest.mark.slow
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
