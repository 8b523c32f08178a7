#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# The exact worst case of every task, gated by committed tables: equal to the table to the instruction, and a loop planted
# in one job is found. `repeated` counts three times, once in another place and with another environment.
# Usage: wcet_test.py once|repeated EXPECTED_DIR PROGRAM. With SORTIE_UPDATE_EXPECTED=1 the tables are written anew.
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

REPEATED = sys.argv[1] == "repeated"
EXPECTED = pathlib.Path(sys.argv[2])
PROGRAM = sys.argv[3]
UPDATE = "SORTIE_UPDATE_EXPECTED" in os.environ
# Five seconds of the hall as it is; three with samples that are lost, late and clipped.
DRIVES = {
    "wcet.txt": ["--seconds", "5"],
    "wcet_faults.txt": ["--seconds", "3", "--set", "hil.imu_loss=0.2", "--set", "hil.encoder_loss=0.3", "--set",
                        "hil.imu_saturate=0.1", "--set", "hil.lidar_rows=8", "--set", "hil.lidar_columns=128"],
}
work = pathlib.Path(tempfile.mkdtemp(prefix="sortie-wcet-"))
failures = []


def run(*arguments, **environment):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=300,
                          stdin=subprocess.DEVNULL, env={**os.environ, **environment})


def check(good, what, result):
    if not good:
        failures.append(what)
        print("FAILED", what, "\n  exit", result.returncode, "\n ", result.stdout[-1500:], "\n ", result.stderr[-3000:])


for table, options in DRIVES.items():
    log = work / "drive.lcm"
    made = run("run", "--scene", "ugv_hall", "--virtual", "--lcm-url", "none", "--record", log, *options)
    check(made.returncode == 0, f"{table}: the drive", made)
    first = run("bench", "wcet", log, "--out", work / "first")
    if first.returncode == 4:
        print("skipped:", first.stderr.strip())
        sys.exit(77)
    check(first.returncode == 0, f"{table}: counting", first)
    if failures:
        break
    if REPEATED:
        deep = work / ("a folder with a longer name" * 4)
        deep.mkdir(exist_ok=True)
        shutil.copy(log, deep / "drive.lcm")
        again = run("bench", "wcet", log, "--out", work / "again")
        moved = run("bench", "wcet", deep / "drive.lcm", "--out", work / "moved", LONGER="x" * 3000)
        counts = (work / "first" / "wcet.csv").read_bytes()
        check(counts == (work / "again" / "wcet.csv").read_bytes(), f"{table}: a second run counts otherwise", again)
        check(counts == (work / "moved" / "wcet.csv").read_bytes(),
              f"{table}: another place and environment count otherwise", moved)
    own = work / "first" / "wcet.txt"
    worst = [line.split() for line in own.read_text().splitlines() if line.startswith("odometry ")][0][10]
    for tick in (worst, "1205") if REPEATED else (worst,):
        slower = run("bench", "wcet", log, "--expect", own, "--fault", f"odometry@{tick}")
        check(slower.returncode == 1 and "task odometry" in slower.stderr and "task attitude" not in slower.stderr,
              f"{table}: a loop planted in odometry at tick {tick} is not found", slower)
    if UPDATE:
        shutil.copy(own, EXPECTED / table)
        print("updated:", table)
        continue
    judged = run("bench", "wcet", log, "--expect", EXPECTED / table)
    if "skipped: " in judged.stderr:
        print(judged.stderr.strip())
    check(judged.returncode == 0,
          f"{table}: the worst case has changed. If that is wanted, run this test once with SORTIE_UPDATE_EXPECTED=1 in "
          "the environment and commit tests/expected with the change", judged)

shutil.rmtree(work, ignore_errors=True)
print("failed" if failures else "all counts agree")
sys.exit(1 if failures else 0)
