#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# `bench all` with programs in place of the benchmarks that print what this test wants to see on the page. Usage: bench_all_test.py PROGRAM
import copy
import json
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

finish("bench all: the page says what was planted")
