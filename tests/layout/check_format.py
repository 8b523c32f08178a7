# SPDX-License-Identifier: BSD-3-Clause
"""check_format.py ROOT CLANG_FORMAT: every source is formatted as .clang-format says."""

import re
import subprocess
import sys

import tree


def main(root, program):
    paths = [str(path) for path in tree.files(root, {".hpp", ".cpp"}, (*tree.FOLDERS, "tests", "examples"))]
    command = [program, "--dry-run", "-Werror", "--style=file", *paths]
    result = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    findings = [line for line in result.stderr.splitlines() if re.search(r":\d+:\d+: error", line)]
    if result.returncode != 0 and not findings:
        findings = [result.stderr.strip() or f"{program} failed"]
    tree.finish(findings, len(paths), f"format (cure: {program} -i FILE)")


main(sys.argv[1], sys.argv[2])
