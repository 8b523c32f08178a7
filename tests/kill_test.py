#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Kills live runs at random moments of their start and their life. Whatever is left, the next start works, every log opens,
# and what stood there before is gone only where a run with a job stands in its place.
# Usage: kill_test.py KILLS PROGRAM [SEED]
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

KILLS, PROGRAM = int(sys.argv[1]), os.path.abspath(sys.argv[2])
SEED = int(sys.argv[3]) if len(sys.argv) > 3 else random.SystemRandom().randrange(1 << 32)
draw = random.Random(SEED)
memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
work = pathlib.Path(tempfile.mkdtemp(prefix="sortie-kill-"))
rings = pathlib.Path(tempfile.mkdtemp(prefix="sortie-kill-", dir=memory))
os.chdir(work)
LOG, RING = pathlib.Path("run.lcm"), rings / "robot.ring"
KEPT = pathlib.Path("run.lcm.previous")
RUN = [PROGRAM, "run", "--scene", "ugv_circle", "--no-rt", "--lcm-url", "none", "--quiet", "--set", "limits.voxels=1024",
       "--flight-ticks", "1000", "--record", str(LOG), "--flight-ring", str(RING)]
failures = []
print(f"{KILLS} kills, seed {SEED}", flush=True)


def check(good, what, *shown):
    if good:
        return
    failures.append(what)
    print("FAILED", what, *shown, flush=True)


def identity(path):
    try:
        return os.stat(path).st_ino
    except FileNotFoundError:
        return None


def opens(path, where):
    """The log replays to what it recorded, as far as it goes."""
    result = subprocess.run([PROGRAM, "check", path, "--accept-damage", "--json"], capture_output=True, text=True, timeout=120)
    check(result.returncode == 0, f"{where}: {path} does not open", result.stdout[-300:], result.stderr)
    if result.returncode == 0:
        check(json.loads(result.stdout)["ticks"] > 0, f"{where}: {path} holds no job")


def whole_run(where, seconds="0.03"):
    result = subprocess.run(RUN + ["--seconds", seconds], capture_output=True, text=True, timeout=120)
    check(result.returncode == 0, f"{where}: the next start fails", result.returncode, result.stderr)


began = time.monotonic()
whole_run("first", "0.2")
length_s = time.monotonic() - began
counts = {"in the start": 0, "in the run": 0, "over": 0}
for kill in range(KILLS):
    how = draw.choice([signal.SIGKILL] * 7 + [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
    # Most that can go wrong does so in the first milliseconds, and around the first job.
    moment_s = draw.uniform(0, 0.03) if draw.random() < 0.4 else draw.uniform(0, length_s)
    where = f"kill {kill}, {how.name} after {moment_s:.4f} s"
    before, kept_before = identity(LOG), identity(KEPT)
    child = subprocess.Popen(RUN + ["--seconds", "0.2"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                             stderr=subprocess.PIPE, text=True)
    time.sleep(moment_s)
    child.send_signal(how)
    words = child.communicate(timeout=120)[1]
    after = identity(LOG)
    check(child.returncode in (0, -how), f"{where}: it ends with {child.returncode}", words)
    counts["over" if child.returncode == 0 else "in the start" if after == before else "in the run"] += 1
    check(after is not None, f"{where}: there is no log")
    if after == before:
        check(identity(KEPT) == kept_before or identity(KEPT) == before, f"{where}: the older log is lost")
    else:
        check(identity(KEPT) == before, f"{where}: the former log is lost")
        opens(LOG, where)
    if kill % 2:
        whole_run(where)
        opens(LOG, where)
        check(not list(work.glob("*.part")) and not list(rings.glob("*.part")), f"{where}: parts stay",
              os.listdir(work), os.listdir(rings))
    if len(failures) > 5:
        break
print(", ".join(f"{count} {what}" for what, count in counts.items()), f"({time.monotonic() - began:.0f} s)")
check(KILLS < 30 or (counts["in the start"] > 0 and counts["in the run"] > 0), "every kill came at the same time")
shutil.rmtree(work, ignore_errors=True)
shutil.rmtree(rings, ignore_errors=True)
if failures:
    print(f"{len(failures)} failures; again: tests/kill_test.py {KILLS} PROGRAM {SEED}")
sys.exit(1 if failures else 0)
