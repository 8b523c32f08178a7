# SPDX-License-Identifier: BSD-3-Clause
"""check_headers.py ROOT COMPILE_COMMANDS: every header is the first thing that some compiled file includes, so that the
build shows that it needs nothing before it. That file is the header's own .cpp, unless it is compiled in a batch with
others; then it is one of those that tests/layout/CMakeLists.txt makes."""

import json
import re
import sys

import tree

INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)


def first_include(path):
    found = INCLUDE.search(path.read_text(errors="replace"))
    return found[1] if found else None


def main(root, commands):
    compiled = [tree.pathlib.Path(entry["file"]) for entry in json.loads(tree.pathlib.Path(commands).read_text())]
    first = {first_include(path) for path in compiled if path.exists() and "Unity" not in path.parts}
    findings, checked = [], 0
    for header in tree.files(root, {".hpp"}, tree.FOLDERS):
        checked += 1
        if header.as_posix() in first:
            continue
        own = header.with_suffix(".cpp")
        cure = f"{own} must include it first" if (tree.pathlib.Path(root) / own).exists() else "configure the build again"
        findings.append(f"{header}: nothing compiles it alone: {cure}")
    tree.finish(findings, checked, "headers")


main(sys.argv[1], sys.argv[2])
