#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# A sweep on a cluster of one node, this machine: Slurm from Debian on loopback, with ports, key and files of its own. An array
# runs 54 cells, one task is killed, merging names its cell and resubmits it, and the table is that of a local run.
# Usage: sweep_slurm_test.py PROGRAM. Ends with 77 where Slurm is missing or may not be started (it wants root).
import os
import re
import shutil
import socket
import subprocess
import sys
import time

from sweep_support import check, cells, drives, finish, run, table, work

PROGRAM = os.path.abspath(sys.argv[1])
for needed in ("slurmctld", "slurmd", "sbatch", "squeue", "scancel", "munged"):
    if shutil.which(needed) is None:
        print("skipped:", needed, "is missing; toolchain/install cluster")
        sys.exit(77)
if os.geteuid() != 0:
    print("skipped: slurmd starts jobs of others, so this test wants root")
    sys.exit(77)

state = work / "slurm"
(state / "ctld").mkdir(parents=True)
(state / "d").mkdir()
os.chmod(work, 0o755)
host = socket.gethostname().split(".")[0]


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


(state / "key").write_bytes(os.urandom(1024))
os.chmod(state / "key", 0o400)
(state / "slurm.conf").write_text(f"""ClusterName=sweep
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
AuthType=auth/munge
AuthInfo=socket={state}/munge.socket
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation={state}/ctld
SlurmdSpoolDir={state}/d
SlurmctldPidFile={state}/ctld.pid
SlurmdPidFile={state}/d.pid
SlurmctldLogFile={state}/ctld.log
SlurmdLogFile={state}/d.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
ReturnToService=2
MinJobAge=600
KillWait=2
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=1000 State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
""")
environment = {**os.environ, "SLURM_CONF": str(state / "slurm.conf")}
servers = []


def serve(*command):
    log = open(state / (os.path.basename(command[0]) + ".out"), "wb")
    servers.append(subprocess.Popen([str(word) for word in command], stdout=log, stderr=log, stdin=subprocess.DEVNULL,
                                    env=environment))


def slurm(*command):
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=60, env=environment)


def wait_for(what, is_so, seconds):
    end = time.monotonic() + seconds
    while not is_so():
        if time.monotonic() > end or any(server.poll() is not None for server in servers):
            check(False, f"waited for {what}")
            return False
        time.sleep(0.1)
    return True


def queue():
    return [line.split() for line in slurm("squeue", "--noheader", "--array", "--format=%A %F %K %t").stdout.splitlines()]


def main():
    logs = drives(PROGRAM, 3, 2)
    knobs = ["--sweep", "map.voxel_m=0.1,0.15,0.2,0.25,0.3,0.4", "--sweep", "map.max_range_m=5,15,25", "--repeat", 2]
    local = run(PROGRAM, "bench", *logs, *knobs, "--jobs", 2, "--quiet", "--out", work / "local")
    if not check(local.returncode == 0 and cells(work / "local") == list(range(54)), "54 cells run here", local):
        return
    folder = work / "cluster"
    planned = run(PROGRAM, "bench", *logs, *knobs, "--slurm", work / "sweep.sh", "--out", folder)
    check(planned.returncode == 0, "an array script", planned)

    serve("munged", "--foreground", "--force", "--key-file", state / "key", "--socket", state / "munge.socket",
          "--pid-file", state / "munge.pid", "--log-file", state / "munge.log", "--seed-file", state / "munge.seed")
    if not wait_for("munge", (state / "munge.socket").exists, 20):
        return
    serve("slurmctld", "-D")
    serve("slurmd", "-D")
    if not wait_for("an idle node", lambda: "idle" in slurm("sinfo", "--noheader", "--format=%t").stdout, 60):
        return
    submitted = slurm("sbatch", work / "sweep.sh")
    print(submitted.stdout.strip(), flush=True)
    job = re.search(r"\d+", submitted.stdout)
    if not check(submitted.returncode == 0 and job, "sbatch", submitted):
        return

    # One running task is killed; where it was done before the blow fell, the next one is.
    killed = []

    def kill_one():
        for number, array, task, how in queue():
            if how != "R" or int(task) in cells(folder):
                continue
            slurm("scancel", "--signal=KILL", "--full", f"{array}_{task}")
            wait_for("the killed task", lambda: all(row[0] != number or row[3] != "R" for row in queue()), 30)
            if int(task) not in cells(folder):
                killed.append(int(task))
            return bool(killed)
        return False

    if not wait_for("a task to kill", kill_one, 300):
        return
    if not wait_for("the array", lambda: not any(row[3] in ("R", "PD", "CG", "CF") for row in queue()), 600):
        return
    print("array done, task", killed[0], "was killed,", len(cells(folder)), "cells are there", flush=True)
    check(cells(folder) == [cell for cell in range(54) if cell != killed[0]], "all cells but the killed one")
    missing = run(PROGRAM, "merge", folder, "--out", folder)
    print(missing.stderr.strip(), flush=True)
    check(missing.returncode == 1 and f"missing cell {killed[0]}: " in missing.stderr and
          "1 of 54 cells are missing" in missing.stderr, "merging names the missing cell", missing)
    again = run(PROGRAM, "merge", folder, "--resubmit", env=environment)
    print(again.stderr.strip().splitlines()[-1], "->", again.stdout.strip(), flush=True)
    check(again.returncode == 1 and "Submitted batch job" in again.stdout, "merging resubmits it", again)
    if not wait_for("the cell", lambda: len(cells(folder)) == 54, 120):
        return
    merged = run(PROGRAM, "merge", folder, "--out", folder)
    check(merged.returncode == 0, "then nothing is missing", merged)
    check(table(folder) == table(work / "local"), "the table of the cluster is the local one")


try:
    main()
finally:
    for server in reversed(servers):
        server.terminate()
    for server in servers:
        server.wait(timeout=30)
finish("a sweep on a cluster: 54 cells, one killed and run again, the table of the local run")
