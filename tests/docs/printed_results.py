#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""printed_results.py PROGRAM DATA: runs what README.md and docs/command-line.md say was run, and compares each figure that they print
and that does not depend on the machine: errors, jobs, chains, pools, counters, digests; and the bytes of programs of one scene with
docs/results/scene-builds.md. What was made from recorded data is compared where DATA has it, and named where not. Then it plants one
fault after the other in a copy of the pages and wants each found.

printed_results.py --table OUTPUT PAGE: compares the one table in PAGE with what a program printed into OUTPUT.

A digest in these pages that no comparison here asks for is a fault, too: who prints one adds what makes it."""

import importlib.machinery
import importlib.util
import json
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
README, COMMANDS, BUILDS = "README.md", "docs/command-line.md", "docs/results/scene-builds.md"
DIGEST = re.compile(r"\b(?=[0-9]*[a-f])[0-9a-f]{16}\b")
# Of these the machine, its clock or its load decides.
OF_MACHINE = {"log_bytes", "over_budget"}
FIGURE = re.compile(r"(\S+) (\S.*)")


def figures(table):
    """What a table of results says, name to text, without times of the machine."""
    found, section, chain = {}, "", ""
    for line in table.splitlines():
        words = line.split()
        if not words:
            continue
        if not line.startswith(" "):
            section = words[0] if words[0] in ("scene", "errors", "pools", "counters", "doctor", "release", "causes", "digest", "passed",
                                               "live") or words[0] in ("task", "chain") else section
            if section in ("task", "chain") and words[0] == section:
                continue
        if section == "task":
            name, group, period, budget, *_, jobs, missed = words
            found[f"task {name}"] = f"{group} {period} {budget} {jobs} {missed}"
        elif section == "chain":
            if words[0] != "age":
                chain = words.pop(0)
            found[f"chain {chain} {words[0]}"] = " ".join(words[1:])
        elif section == "digest":
            found["digest"] = words[1]
        elif section == "passed":
            found["passed"] = line
        elif section in ("scene", "errors", "pools", "counters"):
            text = line if section == "scene" else line.removeprefix(section)
            for item in re.split(r"\s{3,}", text.strip()):
                if "x real time" in item or item.startswith("and "):
                    continue
                match = FIGURE.match(re.sub(r"\s+", " ", item))
                name, value = match.groups() if match else (item, "")
                if section == "counters" and name in OF_MACHINE:
                    continue
                found[f"{section} {name}" if match else f"{section} {item}"] = value
    return found


def blocks(page, first):
    """Fenced blocks of a page whose first line begins with a text."""
    return [block for block in re.findall(r"```[a-z]*\n(.*?)```", page, re.S) if block.startswith(first)]


def differences(where, printed, given, counters=None):
    """Each figure that differs. Of the counters a table shows some: `counters` has all that the program counted."""
    problems = []
    for name in sorted(printed.keys() | given.keys()):
        kind, _, short = name.partition(" ")
        now = given.get(name)
        if kind == "counters":
            if counters is not None and name in printed:
                now = f"{counters[short]:,}" if short in counters else None
            elif name not in printed:
                continue
        if printed.get(name) != now:
            problems.append(f"{where}: {name}: the page says {printed.get(name)}, the program {now}")
    return problems


class Given:
    """What the program gives: run once, compared with as many pages as wanted."""

    def __init__(self, program, data, folder):
        self.program, self.folder = program, folder
        builds = importlib.machinery.SourceFileLoader("scene_builds", str(ROOT / "toolchain" / "scene-builds"))
        self.builds = importlib.util.module_from_spec(importlib.util.spec_from_loader("scene_builds", builds))
        builds.exec_module(self.builds)
        self.data = data if data.is_dir() else None
        self.hall, self.hall_counters = self.run_hall()
        self.part = self.run_part()
        self.husky = self.run_husky()
        self.scenes = {}

    def call(self, *words):
        done = subprocess.run([self.program, *map(str, words)], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"{' '.join(map(str, words))}: exit {done.returncode}\n{done.stdout}{done.stderr}")
        return done.stdout

    def run_hall(self):
        log, out = self.folder / "hall.lcm", self.folder / "hall"
        table = self.call("run", "--scene", "ugv_hall", "--virtual", "--seconds", "20", "--lcm-url", "none", "--record", log, "--out", out)
        passed = [line for line in self.call("check", log).splitlines() if line.startswith("passed")]
        return figures(table + "\n".join(passed)), json.loads((out / "results.json").read_text())["counters"]

    def run_part(self):
        """README's log of 60 s: the digest up to 31.3 s needs no more of it than that."""
        log = self.folder / "part.lcm"
        self.call("run", "--scene", "ugv_hall", "--virtual", "--seconds", "31.5", "--lcm-url", "none", "--quiet", "--record", log)
        self.call("index", log)
        table = self.call("check", log, "--from", "@31200", "--to", "@31300")
        return [line for line in table.splitlines() if line.startswith("passed")][0]

    def run_husky(self):
        if self.data is None or not (self.data / "husky_skid").is_dir():
            return None
        log = self.folder / "husky.lcm"
        self.call("import", "husky", self.data / "husky_skid", "-o", log)
        return figures(self.call("replay", log, "--scene", "skid_outdoor", "--align", "se2"))

    def scene(self, name, kind):
        """Digest of a row of the scenes' table; None without the recording that it is made from."""
        recorded = self.builds.RECORDED.get(name)
        if kind == "recorded" and (self.data is None or not (self.data / recorded[1]).exists()):
            return None
        if name not in self.scenes:
            log, source = self.builds.log_of(self.program, name, self.data, self.folder)
            self.scenes[name] = f"{self.builds.digest(self.program, name, log)} from a {source} log"
        return self.scenes[name]


def scene_rows(page):
    return {match[1]: match[0] for match in re.finditer(r"^\| `(\w+)` \| [0-9,]+ \| \d+ % \|.*$", page, re.M)}


def compare(pages, given):
    """Problems, and what could not be compared."""
    problems, left, asked = [], [], set()
    halls = blocks(pages[README], "scene     ugv_hall")
    huskies = blocks(pages[README], "scene     skid_outdoor")
    parts = re.findall(r"^passed .*\(30000 to .*$", pages[COMMANDS], re.M)
    gates = re.findall(r"^digest = \"([0-9a-f]+)\"", pages[COMMANDS], re.M)
    rows = scene_rows(pages[README])
    for name, found in (("ugv_hall's table", halls), ("the Husky table", huskies), ("the part that is checked", parts), ("the gate", gates)):
        if len(found) != 1:
            problems.append(f"{name} is there {len(found)} times, not once")
    for block in halls:
        problems += differences(README, figures(block), given.hall, given.hall_counters)
        asked.update(DIGEST.findall(block))
    for block in huskies:
        asked.update(DIGEST.findall(block))
        if given.husky is None:
            left.append("the Husky table")
        else:
            problems += differences(README, figures(block), given.husky)
    for line in parts:
        asked.update(DIGEST.findall(line))
        if line != given.part:
            problems.append(f"{COMMANDS}: the page says {line}, the program {given.part}")
    for digest in gates:
        asked.add(digest)
        if digest != given.hall["digest"]:
            problems.append(f"{COMMANDS}: the gate wants {digest}, the README's run gives {given.hall['digest']}")
    if not rows or rows != scene_rows(pages[BUILDS]):
        problems.append(f"{README}: the scenes' table is not that of {BUILDS}")
    for name, row in rows.items():
        cells = [cell.strip() for cell in row.strip("|").split("|")]
        asked.add(cells[4])
        now = given.scene(name, cells[5])
        if now is None:
            left.append(f"the row of {name}")
        elif now != f"{cells[4]} from a {cells[5]} log":
            problems.append(f"{README}: {name}: the page says {cells[4]} from a {cells[5]} log, the program {now}")
    for page in (README, COMMANDS):
        problems += [f"{page}: nothing here compares {digest}" for digest in DIGEST.findall(pages[page]) if digest not in asked]
    return problems, left


def other(text):
    """Another digit in the place of the last one."""
    at = max(i for i, c in enumerate(text) if c.isdigit())
    return text[:at] + str((int(text[at]) + 1) % 10) + text[at + 1:]


def plants(pages, given):
    """Pages with one fault each, and its name."""
    hall = blocks(pages[README], "scene     ugv_hall")[0]
    planted = [(README, text) for text in re.findall(
        r"ate_rmse_m [\d.]+|ate_n \d+|20,000 ticks|voxels [\d,]+|imu_used [\d,]+|digest    \w+|passed  \d+ jobs|\d+ +0\nodometry", hall)]
    planted += [(README, re.search(r"age +11000 +\d+", hall)[0])]
    planted += [(COMMANDS, re.search(r"^passed .* digest \w+", pages[COMMANDS], re.M)[0]), (COMMANDS, re.search(r"^digest = \"\w+", pages[COMMANDS], re.M)[0])]
    planted += [(BUILDS, re.search(r"`ugv_hall` \| [\d,]+", pages[BUILDS])[0]), (README, re.search(r"`ugv_hall` \| [\d,]+", pages[README])[0])]
    for name, row in scene_rows(pages[README]).items():
        if given.scene(name, row.strip("| ").rsplit("|", 1)[1].strip()) is not None:
            planted.append((README, re.search(r"\w{16} \| \w+ \|$", row)[0]))
    if given.husky is not None:
        planted += [(README, text) for text in re.findall(r"ate_max_m [\d.]+|track_used [\d,]+|^digest +\w+", blocks(pages[README], "scene     skid_outdoor")[0], re.M)]
    for page, text in planted:
        assert text in pages[page], text
        yield f"{page}: {text!r}", pages | {page: pages[page].replace(text, other(text), 1)}
    yield "a digest that nobody compares", pages | {COMMANDS: pages[COMMANDS] + "\n0123456789abcdef\n"}
    yield "a table that is gone", pages | {README: pages[README].replace(hall, "", 1)}


def compare_table(output, page):
    text = page.read_text()
    tables = blocks(text, "scene ")
    if len(tables) != 1 or DIGEST.findall(text) != DIGEST.findall(tables[0]):
        return [f"{page}: one table and no digest beside it is what can be compared"]
    given = figures(output.read_text())
    problems = differences(page.name, figures(tables[0]), given)
    if not differences(page.name, figures(tables[0].replace("digest    ", "digest    0")), given):
        problems.append("a planted digest was not found")
    return problems


def main():
    if len(sys.argv) == 4 and sys.argv[1] == "--table":
        problems = compare_table(pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3]))
        print("\n".join(problems))
        return 1 if problems else 0
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    pages = {page: (ROOT / page).read_text() for page in (README, COMMANDS, BUILDS)}
    with tempfile.TemporaryDirectory() as folder:
        given = Given(sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(folder))
        problems, left = compare(pages, given)
        if not problems:
            count = 0
            for name, planted in plants(pages, given):
                count += 1
                if not compare(planted, given)[0]:
                    problems.append(f"planted and not found: {name}")
            print(f"{count} planted faults, {count - len(problems)} found")
    if left:
        print("not compared, no recorded data: " + ", ".join(left))
    print("\n".join(problems))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
