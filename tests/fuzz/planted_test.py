# SPDX-License-Identifier: BSD-3-Clause
"""planted_test.py PROGRAM: the driver of the fuzzers' inputs can fail. PROGRAM is planted.cpp with that driver: each
planted fault must end it with an error that names the input, and no other one."""

import pathlib
import subprocess
import sys
import tempfile

FAULTS = {
    "boom": "died",
    "throw": "died",
    "read behind the end": "died",
    "overflow": "died",
    "write to nowhere": "died",
    "deep": "died",
    "allocate": "died",
    "exit": "left by exit()",
    "wait": "out of time",
}


def run(*arguments):
    command = [sys.argv[1], "--seconds", "5", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, errors="replace", check=False, timeout=120)


def expect(fine, what, result):
    if not fine:
        sys.exit(f"{what}: exit code {result.returncode}\n{result.stdout}{result.stderr}")


def main(folder):
    for fault, words in FAULTS.items():
        for name, text in {"a": "fine", "b": fault, "c": "fine"}.items():
            (folder / name).write_text(text)
        result = run(folder)
        named = [line for line in result.stderr.splitlines() if line.startswith("replay_inputs: ")]
        expect(result.returncode != 0 and named == [f"replay_inputs: {words} on input {folder}/b"], fault, result)
    (folder / "b").write_text("fine, too")
    result = run(folder, folder / "a")
    expect(result.returncode == 0 and result.stdout == "4 inputs and the empty one\n", "no fault", result)
    (folder / "none").mkdir()
    for path, words in {"none": "no inputs in", "missing": "no such file or folder"}.items():
        result = run(folder / "a", folder / path)
        expect(result.returncode == 2 and words in result.stderr, path, result)
    result = run()
    expect(result.returncode == 2 and "usage" in result.stderr, "nothing", result)
    print(f"{len(FAULTS)} planted faults found")


with tempfile.TemporaryDirectory() as made:
    main(pathlib.Path(made))
