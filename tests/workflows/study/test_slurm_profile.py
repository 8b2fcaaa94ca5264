"""The SLURM profile on a cluster of one node, which this test starts and stops."""

from __future__ import annotations

import os
import re
import secrets
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import xarray as xr

# Of Debian's packages munge, slurmctld, slurmd and slurm-client.
DAEMONS = ("munged", "slurmctld", "slurmd")
CLIENTS = ("sbatch", "srun", "squeue", "sacct", "scontrol", "sinfo", "scancel")
STUDY = """\
name: on_slurm
base:
  name: small
  family: {kind: single_edge, width: 10, height: 20, crack_length: 4, traction: 10}
  material: {E: 210e3, nu: 0.3}
  mesh: {element: T3, size: 2, grading: uniform}
product:
  length: {key: family.crack_length, values: [2, 3, 4, 5]}
batch: 2
"""


def why_not() -> str:
    """Reason why no cluster can be started here; empty if one can."""
    places = os.environ["PATH"] + os.pathsep + "/usr/sbin"
    missing = [name for name in (*DAEMONS, *CLIENTS) if not shutil.which(name, path=places)]
    if missing:
        return f"no {', '.join(missing)}: apt-get install munge slurmctld slurmd slurm-client"
    if os.geteuid() != 0:
        return "slurmd needs root"
    return ""


@pytest.fixture(scope="module")
def cluster() -> Iterator[dict[str, str]]:
    """Start a cluster of one node; return the environment of its users."""
    pytest.importorskip("snakemake_executor_plugin_slurm")
    if reason := why_not():
        pytest.skip(reason)
    # Not pytest's folder, which others cannot enter: munged wants its socket to be reached by all.
    folder = Path(tempfile.mkdtemp(prefix="slurm"))
    folder.chmod(0o755)
    try:
        environment = configured(folder)
        started: list[int] = []
        try:
            for name, *options in (
                (
                    "munged",
                    f"--key-file={folder}/munge.key",
                    f"--socket={folder}/munge.socket",
                    f"--pid-file={folder}/munged.pid",
                    f"--log-file={folder}/munged.log",
                    f"--seed-file={folder}/munge.seed",
                ),
                ("slurmctld", "-c"),
                ("slurmd", "-c"),
            ):
                subprocess.run([name, *options], env=environment, check=True, capture_output=True)
                started.append(int(waited(folder / f"{name}.pid")))
            for _ in range(100):
                said = subprocess.run(
                    ["sinfo", "-h", "-o", "%T"], env=environment, capture_output=True, text=True
                )
                if said.stdout.strip() == "idle":
                    break
                time.sleep(0.2)
            else:
                pytest.fail(said.stdout + said.stderr + (folder / "slurmctld.log").read_text())
            yield environment
        finally:
            for pid in reversed(started):
                os.kill(pid, signal.SIGTERM)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def configured(folder: Path) -> dict[str, str]:
    """Write the configuration of the daemons."""
    key = folder / "munge.key"
    key.write_bytes(secrets.token_bytes(1024))
    key.chmod(0o400)
    host = socket.gethostname().partition(".")[0]
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2**20
    ports = [free_port() for _ in range(2)]
    config = folder / "slurm.conf"
    config.write_text(
        f"ClusterName=test\nSlurmctldHost={host}(127.0.0.1)\nSlurmUser=root\n"
        f"SlurmctldPort={ports[0]}\nSlurmdPort={ports[1]}\n"
        f"AuthType=auth/munge\nCredType=cred/munge\nAuthInfo=socket={folder}/munge.socket\n"
        f"StateSaveLocation={folder}/state\nSlurmdSpoolDir={folder}/spool\n"
        f"SlurmctldPidFile={folder}/slurmctld.pid\nSlurmdPidFile={folder}/slurmd.pid\n"
        f"SlurmctldLogFile={folder}/slurmctld.log\nSlurmdLogFile={folder}/slurmd.log\n"
        "ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nMpiDefault=none\n"
        "JobAcctGatherType=jobacct_gather/none\nReturnToService=2\n"
        "SelectType=select/cons_tres\nSelectTypeParameters=CR_Core_Memory\n"
        f"NodeName={host} NodeAddr=127.0.0.1 CPUs={os.cpu_count()} RealMemory={memory * 9 // 10}\n"
        "PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n"
    )
    (folder / "state").mkdir()
    (folder / "spool").mkdir()
    # A cluster has its configuration in /etc; the plugin takes SLURM_CONF away from its jobs.
    (folder / "bin").mkdir()
    for name in CLIENTS:
        command = folder / "bin" / name
        command.write_text(f'#!/bin/sh\nSLURM_CONF={config} exec {shutil.which(name)} "$@"\n')
        command.chmod(0o755)
    path = f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}{os.pathsep}/usr/sbin"
    return {**os.environ, "PATH": path, "SLURM_CONF": str(config)}


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def waited(path: Path) -> str:
    """Wait until a file has contents, and return them."""
    for _ in range(100):
        if path.exists() and path.read_text().strip():
            return path.read_text().strip()
        time.sleep(0.1)
    raise TimeoutError(path)


@pytest.mark.slow
def test_a_study_on_a_cluster(cluster, snakemake, checkout, tmp_path) -> None:
    study = tmp_path / "study.yaml"
    study.write_text(STUDY)
    # Another test may have warmed up already.
    (checkout / "results/.compiled").unlink(missing_ok=True)
    done = snakemake(
        *("study", "--configfile", str(study), "--profile", "profiles/slurm"),
        # This cluster keeps no accounts, and has no file system to wait for.
        *("--slurm-status-command", "squeue", "--slurm-init-seconds-before-status-checks", "1"),
        *("--seconds-between-status-checks", "1", "--latency-wait", "5"),
        folder=checkout,
        PATH=cluster["PATH"],
        PYTHONPATH=str(checkout),
    )
    said = done.stdout + done.stderr
    with xr.open_dataset(checkout / "results" / "on_slurm" / "study.nc") as dataset:
        assert dataset["status"].values.tolist() == [0] * 4
        assert (dataset["G"].diff("length") > 0).all()

    submitted = re.findall(r"submitted with SLURM jobid (\d+) \(log: (.*?)\)", said)
    asked = {}
    for number, log in submitted:
        rule = re.search(r"/rule_(\w+)/", log)[1]
        told = subprocess.run(
            ["scontrol", "show", "job", number],
            env=cluster,
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        assert "JobState=COMPLETED" in told
        limit = re.search(r"TimeLimit=(\S+)", told)[1]
        cores = re.search(r"NumCPUs=(\d+)", told)[1]
        memory = re.search(r"MinMemory\w+=(\S+)", told)[1]
        asked.setdefault(rule, []).append((cores, memory, limit))
    # As the rules state them.
    assert asked == {
        "warm_up": [("1", "1500M", "00:05:00")],
        "study_batch": [("1", "2000M", "01:00:00")] * 2,
        "study_dataset": [("1", "4000M", "00:30:00")],
    }
