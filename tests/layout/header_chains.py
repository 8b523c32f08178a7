# SPDX-License-Identifier: BSD-3-Clause
"""header_chains.py ROOT FOLDER, names of headers on standard input: writes files that show that each header compiles alone.
A header that another one includes stands before it in the same file: what it brings the other brings itself, so it
hides nothing, and is read once for both. Prints the files."""

import functools
import pathlib
import re
import sys

LINE = re.compile(r'^[ \t]*#[ \t]*(if|endif|include)\w*\b(?:[ \t]*[<"]([^>"]+)[>"])?', re.MULTILINE)


@functools.lru_cache(None)
def includes(path):
    """What a file includes, in order; not what stands between #if and #endif."""
    found, depth = [], 0
    for word, name in LINE.findall(path.read_text(errors="replace")):
        depth += {"if": 1, "endif": -1}.get(word, 0)
        if word == "include" and depth == 0:
            found.append(name)
    return found


@functools.lru_cache(None)
def reach(root, name):
    """All that a header includes, and what that includes."""
    found, ahead = set(), [name]
    while ahead:
        path = root / ahead.pop()
        more = set(includes(path)) - found if path.is_file() else set()
        found |= more
        ahead += more
    return found


def chains(root, headers):
    """The headers in lists, each of which begins with a header and goes on with one that includes all before it."""
    size = {header: len(reach(root, header)) for header in headers}
    left = set(headers)
    for last in sorted(headers, key=lambda header: (-size[header], header)):
        if last not in left:
            continue
        chain = []
        while last:
            left.remove(last)
            chain.insert(0, last)
            # One that includes itself by way of others has nothing before it: then it stands first.
            before = left & reach(root, last) if last not in reach(root, last) else ()
            last = max(before, key=lambda header: (size[header], header), default=None)
        yield chain


def main(root, folder):
    root, folder = pathlib.Path(root), pathlib.Path(folder)
    files = {folder / f"{chain[-1]}.cpp": "".join(f'#include "{header}"\n' for header in chain)
             for chain in chains(root, sys.stdin.read().split())}
    for old in set(folder.rglob("*.cpp")) - set(files):
        old.unlink()
    for path, text in files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_text() != text:
            path.write_text(text)
        print(path)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
