# SPDX-License-Identifier: BSD-3-Clause
"""check_symbols.py freestanding|arithmetic|collision NM ARCHIVE...: what an archive may not ask for from outside.

freestanding: no heap, no exception, no printing, no lock, no clock, no kernel: it links on a bare microcontroller.
arithmetic:   no function of the mathematical library whose last bit differs by processor or version.
collision:    the same, no heap, and of libccd no expanding polytope: it takes heap memory, misjudges shallow contacts,
              and the loop before it calls two bodies apart when it gives up."""

import re
import subprocess
import sys

import tree

MATHS = (
    r"(a?(sin|cos|tan)h?|atan2|sincos|exp2?|expm1|exp10|log(2|10|1p|b)?|pow|cbrt|hypot|erfc?|[tl]gamma|fma|j[01n]|y[01n])[fl]?"
)
FREESTANDING = [
    ("the heap", r"(malloc|calloc|realloc|free|aligned_alloc|posix_memalign|operator (new|delete).*)"),
    ("exceptions", r"(__cxa_(throw|allocate_exception|begin_catch|rethrow).*|std::__throw_.*|_Unwind_.*)"),
    ("guards of static locals", r"__cxa_guard_.*"),
    ("printing", r"(__)?(v?(f|s|sn|as)?printf(_chk)?|puts|putchar|fputs|fwrite|perror)|std::(cout|cerr|clog|ostream.*)"),
    ("locks and threads", r"(pthread_|sem_|mtx_|cnd_|thrd_).*|std::(thread|condition_variable|mutex).*"),
    ("clocks and waiting", r"(clock_|nano|u)?(gettime|sleep|nanosleep)|gettimeofday|time|std::chrono.*"),
    ("the kernel", r"(open|close|read|write|mmap|munmap|ioctl|socket|syscall|abort|exit|getenv)(64)?"),
    ("strings on the heap", r"std::(__cxx11::)?basic_string.*"),
]
RULES = {
    "freestanding": FREESTANDING + [("mathematics that differs by processor", MATHS)],
    "arithmetic": [("mathematics that differs by processor", MATHS)],
    "collision": [
        ("libccd's expanding polytope", r"ccdGJK.*"),
        ("the heap", FREESTANDING[0][1]),
        ("mathematics that differs by processor", MATHS),
    ],
}


def undefined(nm, archive):
    """(object file, symbol) for every name that an object in the archive wants from elsewhere."""
    text = subprocess.run([nm, "-A", "-u", "-C", archive], capture_output=True, text=True, check=True).stdout
    for line in text.splitlines():
        where, _, symbol = line.rpartition(" U ")
        yield where.rstrip(": ").split(":")[-1].strip(), symbol.split("@")[0].strip()


def main(mode, nm, archives):
    findings, checked = [], 0
    for archive in archives:
        for where, symbol in undefined(nm, archive):
            checked += 1
            for name, pattern in RULES[mode]:
                if re.fullmatch(pattern, symbol):
                    findings.append(f"{tree.pathlib.Path(archive).name}({where}) asks for {name}: {symbol}")
    tree.finish(findings, max(checked, len(archives)), f"symbols ({mode})")


main(sys.argv[1], sys.argv[2], sys.argv[3:])
