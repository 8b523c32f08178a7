#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""part_test.py PROGRAM FOLDER: puts the part of docs/part-howto.md into a copy of the tree, builds it as PROGRAM was built, and looks at
what the page promises: four files are touched beside the algorithm, and keys, task, counter, columns, digest and run-time parameter are
there. Exit 1 when something does not hold."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "part-howto.md"
BLOCK = re.compile(r"^```\w+ (?P<kind>file|line)=(?P<path>\S+)(?: after=(?P<after>\w+))?\n(?P<text>.*?)^```$", re.M | re.S)


def run(*words, good=(0,), **more):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, **more)
    if done.returncode not in good:
        sys.exit(f"{' '.join(map(str, words))}: exit {done.returncode}\n{(done.stdout + done.stderr)[-3000:]}")
    return done.stdout


def files_of(tree):
    return {str(path.relative_to(tree)) for path in tree.rglob("*") if path.is_file() and "build" not in path.relative_to(tree).parts}


def copy_of_tree(folder):
    """Tracked files and those that are new; the build folder of a run before stays, so that little is built anew."""
    names = run("git", "-C", ROOT, "ls-files", "-co", "--exclude-standard").splitlines() if (ROOT / ".git").exists() else []
    tree = folder / "tree"
    for name in names:
        source, to = ROOT / name, tree / name
        if not source.is_file():
            continue
        to.parent.mkdir(parents=True, exist_ok=True)
        if not to.exists() or to.read_bytes() != source.read_bytes():
            shutil.copy2(source, to)
    for path in files_of(tree) - set(names):
        (tree / path).unlink()  # of a run before
    if not names:
        sys.exit("skipped: no git, so the tree's files are not known")
    return tree


def add_part(tree):
    touched = []
    for block in BLOCK.finditer(PAGE.read_text()):
        path = tree / block["path"]
        if block["kind"] == "file":
            path.write_text(block["text"])
        else:
            text = path.read_text()
            # A row may take several lines: the next one begins a row.
            place = re.compile(rf"^  (?:part|option)\({block['after']},.*?(?=^  (?:part|option)\()", re.M | re.S)
            assert len(place.findall(text)) == 1, block["after"]
            path.write_text(place.sub(lambda row: row.group() + block["text"], text))
        touched.append(block["path"])
    return touched


def differing(tree):
    names = run("git", "-C", ROOT, "ls-files", "-co", "--exclude-standard").splitlines()
    return sorted(name for name in files_of(tree) | set(names)
                  if (ROOT / name).exists() != (tree / name).exists() or (tree / name).read_bytes() != (ROOT / name).read_bytes())


def build(tree, program):
    cache = pathlib.Path(program).resolve().parent / "CMakeCache.txt"
    kept = re.findall(r"^(CMAKE_BUILD_TYPE|CMAKE_CXX_COMPILER|CMAKE_CXX_FLAGS|SORTIE_JUMBO|SORTIE_DATA_DIR|CMAKE_CXX_COMPILER_LAUNCHER):\w+=(.+)$",
                      cache.read_text(), re.M)
    run("cmake", "-S", tree, "-B", tree / "build" / "part", "-G", "Ninja", *(f"-D{name}={value}" for name, value in kept),
        "-DSORTIE_LONG_TESTS=OFF", "-DSORTIE_TEST_FILES=firmware_like/lean_part_test")
    run("cmake", "--build", tree / "build" / "part", "-j", "2", "--target", "sortie", "sortie_tests_firmware_like")
    return tree / "build" / "part" / "sortie"


def prove(own, tree, folder, program):
    failures = []

    def check(good, what):
        if not good:
            failures.append(what)

    on = ["--set", "tasks.lean.enabled=true", "--set", "lean.most_deg=10"]
    run(tree / "build" / "part" / "tests" / "sortie_tests_firmware_like")
    log = folder / "lean.lcm"
    common = ["--scene", "ugv_ramp", "--virtual", "--seconds", "20", "--lcm-url", "none", "--quiet", "--json"]
    with_part = json.loads(run(own, "run", *common, *on, "--record", log, "--out", folder / "lean"))
    without = json.loads(run(own, "run", *common))
    before = json.loads(run(program, "run", *common))
    check("lean" in [task["name"] for task in with_part["tasks"]], "no task lean")
    check(with_part["counters"].get("lean_times", 0) >= 1, "counter lean_times")
    check(without["digest"] == before["digest"], "a part that is off changes the digest")
    check("lean" in without.get("left_out", []) or "lean" not in [task["name"] for task in without["tasks"]], "the part is not left out")
    check("lean_times" in (folder / "lean" / "report.html").read_text(), "the report has no counter lean_times")
    rows = run(own, "export", "csv", log, "--task", "lean").splitlines()
    check("lean_rad" in rows[0] and len(rows) > 7000, "no rows of task lean")
    run(own, "check", log, "--quiet")
    caught = subprocess.run([str(own), "check", str(log), "--quiet", "--fault", "lean.9@5000"], capture_output=True, text=True)
    check(caught.returncode == 1 and "lean" in caught.stdout + caught.stderr, "check does not notice a fault in lean")
    scene = folder / "lean.toml"
    scene.write_text('[scene]\nbase = "ugv_ramp"\nname = "lean"\n[tasks]\nlean = { enabled = true }\n[lean]\nmost_deg = 12\n')
    keys = {key["key"]: key for key in json.loads(run(own, "scenes", "--keys", scene, "--json"))["keys"]}
    key = keys.get("lean.most_deg", {})
    check(key.get("unit") == "deg" and "12" in str(key.get("value")), "no key lean.most_deg in degrees")
    refused = subprocess.run([str(own), "run", *common, *on, "--set", "lean.most_deg=91"], capture_output=True, text=True)
    check(refused.returncode == 2 and "lean.most_deg" in refused.stderr, "a value out of range is not refused by name")
    scene.write_text(scene.read_text() + '[[script]]\nat_s = 1.0\nset = "lean.most_deg"\nvalue = 80.0\n')
    changed = json.loads(run(own, "run", *[scene if word == "ugv_ramp" else word for word in common]))
    check(changed["counters"].get("parameters_applied") == 1, "lean.most_deg cannot be changed while the robot runs")
    check(changed["counters"].get("lean_times") == 0, "a change of lean.most_deg has no effect")
    return failures


LIVE = """ip link set lo up && ip route add 224.0.0.0/4 dev lo || exit 77
"$0" run --scene "$1" --no-rt --quiet --seconds 60 --set parameters.remote=true --set parameters.without_secret=true & run=$!
"$0" set lean.most_deg=20 --seconds 20 && "$0" spy --values --seconds 2; code=$?
kill -INT $run && wait $run && exit $code"""


def watch(own, folder):
    """A live run in a network of its own: its limit is set, and the spy shows the part."""
    scene = folder / "live.toml"
    scene.write_text('[scene]\nbase = "ugv_stand"\nname = "live"\n[tasks]\nlean = { enabled = true }\n')
    done = subprocess.run(["unshare", "-rn", "sh", "-c", LIVE, own, scene], capture_output=True, text=True, timeout=120)
    shown = done.stdout + done.stderr
    if done.returncode == 77 or "unshare failed" in shown:
        print("not watched live: no network namespace of its own")
        return []
    good = done.returncode == 0 and "SORTIE_FIELDS_lean" in shown and "lean_rad" in shown
    return [] if good else [f"spy and set do not know the part: {done.returncode} {shown[-2000:]}"]


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    tree = copy_of_tree(folder)
    touched = add_part(tree)
    failures = [] if sorted(touched) == differing(tree) else [f"touched {touched}, but these differ: {differing(tree)}"]
    if len(touched) != 4:
        failures.append(f"a part takes {len(touched)} files, not four: {touched}")
    code = [name for name in touched if name.endswith(".cpp")]
    if shutil.which("clang-format") and subprocess.run(["clang-format", "--dry-run", "-Werror", *code], cwd=tree).returncode != 0:
        failures.append("the page's code is not formatted as the tree is")
    layers = subprocess.run([sys.executable, str(tree / "tests/layout/check_layers.py"), str(tree)], capture_output=True, text=True)
    if layers.returncode != 0:
        failures.append(layers.stdout + layers.stderr)
    own = build(tree, program)
    failures += prove(own, tree, folder, program) + watch(own, folder)
    print(f"{len(touched)} files: {', '.join(touched)}")
    for failure in failures:
        print(failure)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    os.environ.pop("SORTIE_UPDATE_EXPECTED", None)
    main()
