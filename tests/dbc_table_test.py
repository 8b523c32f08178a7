#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# What toolchain/dbc-table says of files that it cannot use: the line, the reason and the cure; and what it makes of others' files.
# Usage: dbc_table_test.py DBC_TABLE DATA
import pathlib
import subprocess
import sys
import tempfile

TABLE, DATA = map(pathlib.Path, sys.argv[1:3])
GOOD = 'BO_ 5 speed: 4 Robot\n SG_ left : 0|16@1- (0.001,0) [-30|30] "m/s" Drive\n SG_ right : 16|16@1- (0.001,0) [-30|30] "m/s" Drive\n'
failures = []


def run(text, *messages):
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "some.dbc"
        file.write_text(text)
        done = subprocess.run([TABLE, file, "some", *messages], capture_output=True, text=True)
        return done.returncode, done.stdout, done.stderr.replace(str(file), "some.dbc")


def refuses(what, text, line, *says):
    code, out, error = run(text)
    if code != 1 or out or not error.startswith(f"some.dbc:{line}: ") or not all(word in error for word in says) or error.count("\n") != 1:
        failures.append(what)
        print("FAILED", what, code, out[:200], error)


def check(good, what, *shown):
    if not good:
        failures.append(what)
        print("FAILED", what, *shown)


code, out, error = run(GOOD)
check(code == 0 and not error and '{"right", 16, 16, false, CanValue::signed_whole, 0.001, 0.0, -30.0, 30.0, "m/s"' in out, "a good file", code, out, error)
check(run(GOOD)[1] == out, "the same every time")
refuses("no message", "VERSION \"\"\n", 1, "no message")
refuses("a message without bytes", GOOD + "BO_ 6 rest Robot\n", 4, "BO_ NUMBER NAME: BYTES")
refuses("a signal without a range", GOOD.replace(" [-30|30]", "", 1), 2, "SG_ speed :")
refuses("a signal beyond the message", GOOD.replace("16|16@1-", "17|16@1-"), 3, "speed.right", "4 bytes", "make the message longer")
refuses("a Motorola signal beyond the message", GOOD.replace("16|16@1-", "16|16@0-"), 3, "speed.right", "4 bytes")
refuses("too many bits", GOOD.replace("0|16@1-", "0|65@1-", 1), 2, "65 bits")
refuses("no bits", GOOD.replace("0|16@1-", "0|0@1-", 1), 2, "0 bits")
refuses("scale 0", GOOD.replace("(0.001,0)", "(0,0)", 1), 2, "scale 0")
refuses("an empty range", GOOD.replace("[-30|30]", "[30|-30]", 1), 2, "exchange")
refuses("two signals of a name", GOOD.replace("right", "left"), 2, "rename")
refuses("two messages of a number", GOOD + GOOD.replace("speed", "other"), 4, "number of speed")
refuses("two messages of a name", GOOD + GOOD.replace("BO_ 5", "BO_ 6"), 4, "rename")
refuses("an identifier that is none", GOOD.replace("BO_ 5", "BO_ 2048"), 1, "2147483648")
refuses("a signal before any message", GOOD.split("\n", 1)[1], 1, "put BO_ above")
refuses("a float of 16 bits", GOOD + "SIG_VALTYPE_ 5 left : 1;\n", 2, "float32 of 16 bits")
refuses("a float of no signal", GOOD + "SIG_VALTYPE_ 5 middle : 1;\n", 4, "names no signal")
refuses("multiplexed without a multiplexer", GOOD.replace("left :", "left m0 :"), 1, "mark it with M")
refuses("two multiplexers", GOOD.replace("left :", "left M :").replace("right :", "right M :"), 1, "more than one multiplexer")
refuses("an open quote", GOOD + 'CM_ BO_ 5 "no end;\n', 4, "closing quote")
refuses("another file", GOOD + "hello world = 3\n", 4, "'hello'")
code, out, error = run(GOOD.replace("16|16@1-", "8|16@1-"))
check(code == 0 and "lies over left" in error, "signals over each other are told", code, error)
code, out, error = run(GOOD + "BO_ 6 page: 20 Robot\n")
check(code == 0 and "page has 20 bytes and is left out" in error and "page" not in out, "a message for a transport protocol is told", code, error)
code, out, error = run(GOOD + GOOD.replace("BO_ 5 speed", "BO_ 6 other"), "other")
check(code == 0 and "kOther" in out and "kSpeed" not in out, "only the messages that were asked for", code, out)
check(run(GOOD, "missing")[0] == 1, "a message that is not there")
others = DATA / "can_bus/test_frame_decoding.dbc"
if others.exists():
    done = subprocess.run([TABLE, others, "others"], capture_output=True, text=True)
    check(done.returncode == 0 and done.stdout.count("inline constexpr CanMessage k") >= 5, "somebody else's file", done.stderr)
    check('{"floatSignal1", 32, 32, true' in done.stdout, "its Motorola signal at 7|32", done.stdout[:2000])
else:
    print(f"{others} is not there: other people's files were left out")
sys.exit(1 if failures else 0)
