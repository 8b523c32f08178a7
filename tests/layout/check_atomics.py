# SPDX-License-Identifier: BSD-3-Clause
"""check_atomics.py ROOT: no 64-bit atomic in the freestanding part of rt: a Cortex-M has none, and would call a library."""

import re
import sys

import tree

# Time and tick types are 64 bits wide; std::size_t and pointers are as wide as the processor's word.
WIDE = re.compile(r"\b[Aa]tomic(_ref)?<\s*(?:std::)?(u?int64_t|u?int_(?:least|fast)64_t|u?intmax_t|(?:unsigned )?long long|double|Tick|Nanoseconds)\s*>")


def main(root):
    findings, checked = [], 0
    for path in tree.files(root, {".hpp", ".cpp"}, ("rt",)):
        if path.parts[1] == "posix":
            continue
        checked += 1
        for number, line in enumerate((tree.pathlib.Path(root) / path).read_text().splitlines(), 1):
            match = WIDE.search(line.split("//")[0])
            if match:
                findings.append(f"{path}:{number}: {match[0]}: 32 bits and a defined wrap or top (rt/saturating_count.hpp)")
    tree.finish(findings, checked, "atomics")


main(sys.argv[1])
