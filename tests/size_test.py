#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# What scenes take in memory and programs in bytes, beside a committed table: growth by more than 2 % is a decision, not an accident.
# Usage: size_test.py PROGRAM ARM_PROGRAM BUILD EXPECTED PAGE. With SORTIE_UPDATE_EXPECTED=1 table and page are written anew.
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

program, arm, build, expected, page = map(pathlib.Path, sys.argv[1:6])
MOST_GROWTH = 0.02
failures, absent = [], []


def output(*words):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, check=True).stdout


def sections(path):
    """Bytes of (code and constants, initialised data, zeroed data)."""
    return map(int, output("size", path).splitlines()[1].split()[:3])


def measure():
    scenes = {scene["scene"]: scene["bytes"] for scene in json.loads(output(program, "scenes", "--json"))["scenes"]}
    programs = {}
    boards = [(f"{name}, {what}", build / folder / "firmware_like/bare_metal" / image)
              for name, folder in (("Cortex-M7", "cortex-m7"), ("Cortex-M4F", "cortex-m4f"))
              for what, image in (("flight", "sortie_bare_uav"), ("odometry", "sortie_bare_ugv"))]
    for name, path in (("x86-64, sortie", program), ("aarch64, sortie", arm), *boards):
        if not path.exists():
            absent.append(name)
            continue
        text, data, zeroed = sections(path)
        programs[name] = {"program": text + data, "static memory": data + zeroed}
    return {"scenes": scenes, "programs": programs}


def compare(now, was):
    """Yields what has grown too much, and what the table does not know or has in vain."""
    for scene in sorted(set(now["scenes"]) | set(was["scenes"])):
        if scene not in was["scenes"] or scene not in now["scenes"]:
            yield f"scene {scene} is in one of program and table only"
        elif now["scenes"][scene] > was["scenes"][scene] * (1 + MOST_GROWTH):
            yield f"scene {scene} takes {now['scenes'][scene]} B, the table says {was['scenes'][scene]} B"
    for name, sizes in now["programs"].items():
        for what, size in sizes.items():
            known = was["programs"].get(name, {}).get(what, 0)
            if size > known * (1 + MOST_GROWTH):
                yield f"{name}: {what} {size} B, the table says {known} B"


def render(table):
    lines = ["# What scenes and programs take", "",
             "Memory of a scene is what its pools, queues and tables take at start-up; nothing is taken later. Programs hold every scene; static memory is",
             "what they have before that. The x86-64 program is that of the preset `release`, the others those of `aarch64`, `cortex-m7` and `cortex-m4f`.", "",
             "`tests/size_test.py` compares: more than 2 % above this table is a failure. `SORTIE_UPDATE_EXPECTED=1 ctest --preset release -R size` writes it.", "",
             "| program | bytes | static memory |", "|---|---:|---:|"]
    lines += [f"| {name} | {s['program']:,} | {s['static memory']:,} |" for name, s in table["programs"].items()]
    lines += ["", "| scene | memory in bytes |", "|---|---:|"]
    lines += [f"| `{name}` | {size:,} |" for name, size in table["scenes"].items()]
    return "\n".join(lines) + "\n"


if shutil.which("size") is None:
    print("skipped: size is missing (toolchain/install base)")
    sys.exit(77)
now = measure()
if "SORTIE_UPDATE_EXPECTED" in os.environ:
    if expected.exists():  # what was not built keeps its row
        now["programs"] = {**json.loads(expected.read_text())["programs"], **now["programs"]}
    expected.write_text(json.dumps(now, indent=1) + "\n")
    page.write_text(render(now))
was = json.loads(expected.read_text())
failures = list(compare(now, was))
if page.read_text() != render(was):
    failures.append(f"{page.name} does not show the table")
# A comparison that cannot fail is none: every entry, grown by 3 %, must be found.
grown = json.loads(re.sub(r": (\d+)", lambda m: f": {int(int(m[1]) * 1.03) + 1}", json.dumps(now)))
entries = len(now["scenes"]) + 2 * len(now["programs"])
if not failures and sum(1 for _ in compare(grown, now)) != entries:
    failures.append("growth by 3 % is not found everywhere")
for name in absent:
    print(f"not built, not compared: {name}")
for failure in failures:
    print("FAILED", failure)
sys.exit(1 if failures else 0)
