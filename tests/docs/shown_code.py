#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""shown_code.py ROOT: code that a page shows as that of a file (a block that begins with ```cpp of=PATH) stands there as it is, and the
build compiles it. Then it changes a character of each block in turn, and wants that found."""

import pathlib
import re
import sys

BLOCK = re.compile(r"^```\w+ of=(?P<path>\S+)\n(?P<text>.*?)^```$", re.M | re.S)


def problems(root, name, page):
    for match in BLOCK.finditer(page):
        line = page.count("\n", 0, match.start()) + 1
        file = root / match["path"]
        if not file.exists():
            yield f"{name}:{line}: there is no {match['path']}"
        elif match["text"] not in file.read_text():
            yield f"{name}:{line}: this is not how {match['path']} has it"


def plants(page):
    """The page with another character in the middle of each block, and with another file."""
    for match in BLOCK.finditer(page):
        middle = (match.start("text") + match.end("text")) // 2
        yield page[:middle] + ("a" if page[middle] != "a" else "b") + page[middle + 1:]
        yield page[:match.end("path")] + "x" + page[match.end("path"):]


def main(root):
    found, blocks, missed = [], 0, 0
    for file in sorted((root / "docs").glob("*.md")):
        page = file.read_text()
        found += problems(root, file.name, page)
        blocks += len(BLOCK.findall(page))
        missed += sum(not list(problems(root, file.name, planted)) for planted in plants(page))
    print("\n".join(found + [f"{blocks} blocks of code, {len(found)} differ; {2 * blocks} planted faults, {missed} not found"]))
    return 1 if found or missed or blocks == 0 else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
