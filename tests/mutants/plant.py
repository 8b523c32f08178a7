#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""plant.py [--page FILE] [WORD...]: faults that sanitizers, compilers, layers and pages are there for; run.py has those that a
test case is there for. Plants one after another in this tree, builds what the short test run would build of it, runs what the
short run would run, and sees the fault caught. Every file is put back. Needs the build trees of a finished `toolchain/test`;
refuses a tree with changes. WORD picks faults by name. Exit code 1: a fault was not caught."""

import argparse
import pathlib
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
BINARY = "build/{preset}/tests/sortie_tests_{folder}"


def tests(preset, folder, says):
    return preset, f"sortie_tests_{folder}", [BINARY.format(preset=preset, folder=folder), "~[heavy]~[model]"], says


# name, file, what stands there, what is put there, (preset, target, command, what its output says)
FAULTS = [
    ("a race: an element is seen before it is written", "rt/spsc_protocol.hpp",
     "    write_.store(next, std::memory_order_release);\n    return true;\n  }\n\n  bool try_pop",
     "    write_.store(next, std::memory_order_relaxed);\n    return true;\n  }\n\n  bool try_pop", tests("tsan", "rt", "data race")),
    ("an overflow: a frame takes a hundred bytes too many", "drivers/candump_parse.cpp", "if (digits.size() > 2 * most)",
     "if (digits.size() > 2 * most + 200)",
     ("debug", "candump_fuzz_inputs", ["build/debug/tests/fuzz/candump_fuzz_inputs", "build/debug/tests/fuzz/corpus/candump_fuzz"],
      "died on input")),
    ("a use after free: a text is asked when it is gone", "firmware_like/scene/json.cpp",
     "  if (kind_ == Kind::text) delete value_.text;",
     "  if (kind_ == Kind::text) {\n    std::string* volatile text = value_.text;\n    delete text;\n    if (text->size() == 77) kind_ = Kind::null;\n  }",
     ("debug", "sortie_tests_firmware_like", [BINARY.format(preset="debug", folder="firmware_like"), "*JSON*"], "heap-use-after-free")),
    ("a header needs what others included", "rt/stamp_gate.hpp", "#pragma once\n", "#pragma once\nnamespace planted { std::vector<int> all(); }\n",
     ("release", "sortie_headers", [], "vector")),
    ("the planner includes the program", "planner/mission.cpp", '#include "planner/mission.hpp"\n',
     '#include "planner/mission.hpp"\n#include "firmware_like/scene/profile.hpp"\n',
     ("", "", ["python3", "-B", "tests/layout/check_layers.py", "."], "planner may not include firmware_like")),
    ("64-bit ARM calculates otherwise", "rt/math_trigonometric.cpp", "  const double z = r * r;\n  return r + (r * (z * sin_tail(z))",
     "#ifdef __aarch64__\n  const double z = r * r * (1 + 1e-9);\n#else\n  const double z = r * r;\n#endif\n  return r + (r * (z * sin_tail(z))",
     ("aarch64", "sortie_tests_rt", ["build/aarch64/run", "build/aarch64/tests/sortie_tests_rt"], "FAILED")),
    ("a page lies", "docs/profiles.md", "27.10 MB", "17.10 MB",
     ("", "", ["ctest", "--test-dir", "build/release", "-R", "docs/the page", "--output-on-failure"], "Failed")),
]


def run(words):
    result = subprocess.run(words, cwd=ROOT, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", check=False)
    return result.returncode, result.stdout + result.stderr


def caught(preset, target, command, says):
    """How the fault was caught, or an empty text."""
    if target:
        code, output = run(["cmake", "--build", f"build/{preset}", "-j", "2", "--target", target])
        if code != 0:
            return f"`{target}` of `{preset}` does not build" if says in output or "error" in output else ""
    if not command:
        return ""
    code, output = run(command)
    return f"`{' '.join(command)}`" if code != 0 and says in output else ""


def plant(fault):
    name, file, was, now, check = fault
    path = ROOT / file
    text = path.read_text()
    if text.count(was) != 1:
        return f"NOT PLANTED: {file} does not hold it once", 0
    begin = time.monotonic()
    path.write_text(text.replace(was, now))
    try:
        how = caught(*check)
    finally:
        path.write_text(text)
    return how or "NOT CAUGHT", time.monotonic() - begin


def main():
    parser = argparse.ArgumentParser(description="plants faults and sees them caught")
    parser.add_argument("--page")
    parser.add_argument("word", nargs="*")
    options = parser.parse_args()
    if run(["git", "status", "--porcelain", "--untracked-files=no"])[1].strip():
        print("plant.py: this tree has changes; commit them first", file=sys.stderr)
        return 2
    rows, missed = [], 0
    for fault in FAULTS:
        if options.word and not any(word in fault[0] for word in options.word):
            continue
        how, seconds = plant(fault)
        missed += how.startswith("NOT")
        rows.append(f"| {fault[0]} | `{fault[1]}` | {how} | {seconds:.0f} |")
        print(f"{fault[0]}: {how} ({seconds:.0f} s)", flush=True)
    if options.page:
        head = ["# Planted faults", "", "`tests/mutants/plant.py --page` plants each of these in turn and sees it caught by what the short test run builds and runs;",
                "seconds are those of building and running that part alone. Faults of one line in every folder, a damaged log that counts as whole among",
                "them, are in [faults of one line](mutants.md).", "", "| fault | file | caught by | s |", "|---|---|---|---:|"]
        pathlib.Path(options.page).write_text("\n".join([*head, *rows, ""]))
    print(f"{len(rows) - missed} caught, {missed} not")
    return 1 if missed or not rows else 0


sys.exit(main())
