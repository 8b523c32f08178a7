# SPDX-License-Identifier: BSD-3-Clause
"""check_headers.py ROOT JOBS FLAGS_FILE COMPILER: every header compiles alone, without what others included before it.
FLAGS_FILE: one compiler flag a line."""

import concurrent.futures
import subprocess
import sys

import tree


def compile_alone(root, command, header):
    line = [*command, "-fsyntax-only", "-x", "c++", "-include", header, "/dev/null"]
    result = subprocess.run(line, cwd=root, capture_output=True, text=True, check=False)
    errors = [text for text in result.stderr.splitlines() if "error" in text]
    return None if result.returncode == 0 else f"{header}: does not compile alone: {' | '.join(errors[:3])}"


def main(root, jobs, command):
    headers = [str(path) for path in tree.files(root, {".hpp"}, tree.FOLDERS)]
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        results = list(pool.map(lambda header: compile_alone(root, command, header), headers))
    tree.finish([result for result in results if result], len(headers), "headers")


FLAGS = [line for line in tree.pathlib.Path(sys.argv[3]).read_text().splitlines() if line]
main(sys.argv[1], int(sys.argv[2]), [sys.argv[4], *FLAGS])
