#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# `bench all` with programs in place of the benchmarks that print what this test wants to see on the page, and the comparison of
# two runs: what may not change is found to the last bit. Usage: bench_all_test.py PROGRAM
import copy
import json
import math
import shutil
import sys

from sweep_support import check, finish, run, work

program = work / "bin" / "sortie"
program.parent.mkdir()
shutil.copy(sys.argv[1], program)


def stub(name, result):
    path = program.parent / name
    path.write_text("#!/bin/sh\ncat <<'END'\n" + json.dumps(result) + "\nEND\n")
    path.chmod(0o755)


def figure(what, unit, value, ratio=None, **more):
    ours = value if isinstance(value, dict) else {"value": value}
    return {"group": "g", "what": what, "unit": unit, "n": 3, "ours": ours, "peer": "theirs" if ratio else "",
            "theirs": None, "ratio": ratio, **more}


plant = {"figures": [
    figure("end", "mm", 0.1, goal="<= 1 mm", met=True), figure("depth", "mm", 2.5, goal="<= 1 mm", met=False),
    figure("step", "us", {"value": 5, "low": 4, "high": 6}, {"value": 0.5, "low": 0.4, "high": 0.6}, goal="ratio <= 1", met=True),
    figure("alone", "us", {"value": 5, "low": 4, "high": 6})],
    "tables": [], "skipped": [{"what": "ODE", "why": "libode-dev is missing"}], "notes": [], "scenes": [], "step_curves": [],
    "pictures": [], "settings": {}, "load_before": "0.10", "load_after": "0.20"}
stub("sortie-bench-plant", plant)

out = work / "out"
(out / "plant").mkdir(parents=True)
(out / "plant" / "mine.txt").write_text("kept")
ran = run(program, "bench", "all", "--only", "plant", "--out", out, "--passes", "1")
page = (out / "index.md").read_text() if (out / "index.md").exists() else ""
check(ran.returncode == 0 and ran.stdout == page and "part 1 of 1" in ran.stderr, "one part runs", ran)
check("| [plant](plant/) | 2 of 3 | " in page and "- plant: g: depth, <= 1 mm" in page, "goals stand on the page", ran)
check("ODE" in page.split("## Missed")[-1], "what was left out stands on the page", ran)
check((out / "plant" / "mine.txt").read_text() == "kept", "other files stay")

# Two processes of it, the second with another time and another error.
calls = program.parent / "calls"
second = copy.deepcopy(plant)
second["figures"][0]["ours"]["value"] = 0.2
second["figures"][2]["ratio"] = {"value": 0.9, "low": 0.8, "high": 1.5}
for number, result in enumerate((plant, second)):
    (program.parent / f"pass{number}").write_text(json.dumps(result))
(program.parent / "sortie-bench-plant").write_text(f"#!/bin/sh\necho x >> {calls}\ncat {program.parent}/pass$((($(wc -l < {calls}) + 1) % 2))\n")
both = run(program, "bench", "all", "--only", "plant", "--out", out)
kept = json.loads((out / "plant" / "bench-plant.json").read_text())
check(calls.read_text().count("x") == 2 and kept["settings"]["passes"] == 2, "two processes a part", both)
check(kept["figures"][2]["ratio"] == {"value": 0.7, "low": 0.4, "high": 1.5}, "the range holds both passes", both)
check("- plant, not the same in every pass: g: end" in both.stdout, "an error that two processes do not share is named", both)

# A program that is not there: named, and what an earlier run left is not taken for its result.
(program.parent / "sortie-bench-plant").unlink()
gone = run(program, "bench", "all", "--only", "plant", "--only", "uav", "--out", out)
check(gone.returncode == 4 and "| plant | did not run: exit code 4 |" in gone.stdout and
      "| uav | did not run: exit code 4 |" in gone.stdout, "parts that cannot run are named", gone)
check(run(program, "bench", "all", "--only", "plants", "--out", out).returncode == 2, "an unknown part")

# Two runs beside each other.
odometry = {"cells": [{"set": "ramp", "name": "200 Hz", "errors": {"ate_rmse_m": 0.125}, "us_per_s": 3}]}


def write(folder, plant_result, odometry_result):
    for part, name, result in (("plant", "bench-plant", plant_result), ("odometry", "bench-odometry", odometry_result)):
        (folder / part).mkdir(parents=True, exist_ok=True)
        if result is not None:
            (folder / part / f"{name}.json").write_text(json.dumps(result))
    (folder / "index.json").write_text("{}")


def compare(name, plant_result, odometry_result=odometry):
    folder = work / name
    write(folder, plant_result, odometry_result)
    return run(program, "bench", "all", "--out", folder, "--compare", work / "before", "--no-run")


write(work / "before", plant, odometry)
same = compare("same", plant)
check(same.returncode == 0 and "3 errors, 0 changed; 1 ratios, 0 outside; 1 figures" in same.stdout, "the same run", same)
later = copy.deepcopy(plant)
later["figures"][2]["ours"]["value"] = 50
later["figures"][2]["ratio"] = {"value": 0.7, "low": 0.6, "high": 0.8}
later["figures"][3]["ours"]["value"] = 50
check(compare("slower", later).returncode == 0, "times change, and ratios within their spread")
for what, change, says in [
        ("an error", lambda result: result["figures"][0]["ours"].update(value=math.nextafter(0.1, 1)), "CHANGED   plant, g: end"),
        ("a ratio", lambda result: result["figures"][2].update(ratio={"value": 0.7, "low": 0.61, "high": 0.8}),
         "OUTSIDE   plant, g: step, beside theirs")]:
    planted = copy.deepcopy(plant)
    change(planted)
    found = compare(what, planted)
    check(found.returncode == 1 and says in found.stdout, f"{what} that changed is found", found)
drift = copy.deepcopy(odometry)
drift["cells"][0]["errors"]["ate_rmse_m"] = math.nextafter(0.125, 1)
found = compare("drift", plant, drift)
check(found.returncode == 1 and "CHANGED   odometry, ramp, 200 Hz: ate_rmse_m" in found.stdout, "an error of a cell", found)
found = compare("less", plant, None)
check(found.returncode == 1 and "missing   odometry is only in" in found.stdout, "a part that is missing", found)
found = run(program, "bench", "all", "--out", work / "same", "--compare", work / "bin", "--no-run")
check(found.returncode == 3 and "index.json" in found.stderr, "no folder of bench all", found)
finish("bench all: the page and the comparison say what was planted")
