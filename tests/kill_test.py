#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Starts that are refused, then live runs that are killed at random moments of their start and their life. Whatever is left,
# the next start works, every log opens, and what stood there before is gone only where a run with a job stands in its place.
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
# A refused start leaves everything as it was; so does one that wants what a living run writes.
RING_KEPT = pathlib.Path(str(RING) + ".previous")
RING.write_bytes(b"")  # as a start leaves it that was killed before its first word


def standing():
    return [(identity(path), path.read_bytes()[:1 << 16] if path.exists() else None) for path in (LOG, KEPT, RING, RING_KEPT)]


def refused(code, says, *arguments, log=LOG, ring=RING):
    line = [{str(LOG): str(log), str(RING): str(ring)}.get(word, word) for word in RUN]
    stood = standing()
    result = subprocess.run([*line, "--seconds", "0.1", *arguments], capture_output=True, text=True, timeout=120)
    check(result.returncode == code and says in result.stderr, f"refused: {arguments}", result.returncode, result.stderr)
    check(standing() == stood, f"a refused start touched files: {arguments} {log} {ring}")
    check(not list(work.glob("*.part")) and not list(rings.glob("*.part")), f"refused, parts stay: {arguments}")


refused(2, "--can nosuch0", "--can", "nosuch0")
refused(2, "--plant", "--plant", "nowhere")
refused(2, "leave out --plant", "--plant", "own", "--virtual")
refused(3, "no/such/folder", log="no/such/folder/a.lcm")
refused(3, "no/such/folder", ring="no/such/folder/a.ring")
old = identity(LOG)
whole_run("after refused starts", "0.1")
check(identity(KEPT) == old and identity(LOG) != old, "the former log has the name .previous")
living = subprocess.Popen(RUN + ["--seconds", "60"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
old = identity(LOG)
while identity(LOG) == old and living.poll() is None:
    time.sleep(0.02)
for options in ({"ring": "none"}, {"log": "other.lcm"}):
    result = subprocess.run([{str(LOG): options.get("log", str(LOG)), str(RING): options.get("ring", str(RING))}.get(word, word)
                             for word in RUN] + ["--seconds", "0.1"], capture_output=True, text=True, timeout=120)
    check(result.returncode == 3 and "still going" in result.stderr, f"what a living run writes: {options}", result.stderr)
living.terminate()
check(living.wait(60) == 0, "the living run ends well")
opens(LOG, "beside a start that was refused")

# What no rename may replace is written itself: nobody wants a file where /dev/null was.
os.mkfifo("pipe")
reader = subprocess.Popen("exec timeout 10 cat pipe > piped.keyframes", shell=True)
subprocess.run([PROGRAM, "index", LOG, "-o", "pipe"], capture_output=True, timeout=120)
reader.wait(60)
check(pathlib.Path("pipe").is_fifo(), "a pipe is still a pipe")
check(pathlib.Path("piped.keyframes").stat().st_size > 100, "keyframes through a pipe")

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
