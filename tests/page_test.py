#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The report's page in a browser without a screen: it renders without a word on the console, no text lies over another or
runs out of its picture, nothing is wider than the page, on screen and in a narrow window, it prints, and its figures are
those of results.json and sweeps.json. Faults are planted in copies of the page, and each must be found.
Usage: page_test.py SORTIE FOLDER. Without Chromium: code 77, a skip."""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET

program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
if browser is None:
    print("skipped: no Chromium. Cure: toolchain/install page")
    sys.exit(77)

# What a browser alone knows: where text is. Reads the page, writes one line of JSON at its end.
LOOK = """<script>//<![CDATA[
(function () {
  var found = {overlaps: [], outside: [], wide: [], texts: 0, plots: document.querySelectorAll('svg').length};
  document.querySelectorAll('svg').forEach(function (svg) {
    var frame = svg.getBoundingClientRect();
    var boxes = [];
    svg.querySelectorAll('text').forEach(function (text) {
      var b = text.getBoundingClientRect();
      if (b.width === 0 || !text.textContent.trim()) return;
      found.texts++;
      if (b.left < frame.left - 1 || b.right > frame.right + 1 || b.top < frame.top - 1 || b.bottom > frame.bottom + 1)
        found.outside.push(text.textContent);
      boxes.push({text: text.textContent, b: b});
    });
    boxes.sort(function (p, q) { return p.b.left - q.b.left; });
    for (var i = 0; i < boxes.length; i++) {
      for (var k = i + 1; k < boxes.length && boxes[k].b.left < boxes[i].b.right - 1; k++) {
        var p = boxes[i].b, q = boxes[k].b;
        // A line's box is higher than its letters.
        var up = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top);
        if (up > 0.35 * Math.min(p.height, q.height) && Math.min(p.right, q.right) - Math.max(p.left, q.left) > 1)
          found.overlaps.push(boxes[i].text + ' / ' + boxes[k].text);
      }
    }
  });
  var page = document.documentElement.clientWidth;
  if (document.documentElement.scrollWidth > page + 1) found.wide.push('the page itself');
  document.querySelectorAll('td,th,.tile b,h1,h2').forEach(function (cell) {
    if (cell.scrollWidth > cell.clientWidth + 1 && cell.clientWidth > 0) found.wide.push(cell.textContent);
  });
  var line = document.createElement('pre');
  line.id = 'looked';
  line.textContent = JSON.stringify(found);
  document.body.appendChild(line);
})();
//]]></script>"""


def browse(*arguments):
    return subprocess.run([browser, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars",
                           "--enable-logging=stderr", f"--user-data-dir={folder}/browser", *arguments],
                          capture_output=True, text=True, timeout=300)


def look(page, width=1280):
    """What is wrong with a page to the eye, as a list of sentences."""
    copy = page.with_name("looked.html")
    copy.write_text(page.read_text().replace("</body>", LOOK + "</body>"))
    run = browse(f"--window-size={width},2000", "--virtual-time-budget=20000", "--dump-dom", copy.as_uri())
    faults = [f"console: {line.split('CONSOLE')[1][:200]}" for line in run.stderr.splitlines() if "CONSOLE" in line]
    match = re.search(r'<pre id="looked">(.*?)</pre>', run.stdout, re.S)
    if match is None:
        return faults + ["the browser did not render the page"]
    found = json.loads(match.group(1).replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&"))
    if found["plots"] < 5 or found["texts"] < 50:
        faults.append(f"too little to look at: {found['plots']} plots, {found['texts']} texts")
    for kind in ("overlaps", "outside", "wide"):
        faults += [f"{kind}: {text}" for text in found[kind]]
    return faults


def agrees(text, value):
    """A figure as text, rounded to its own last digit."""
    if value is None:
        return text in ("-", "")
    text = text.replace("\u202f", "").replace("\u2009", "").replace(" ", "").replace(",", "").replace("\u2212", "-")
    try:
        shown = float(text)
    except ValueError:
        return False
    mantissa, _, exponent = text.lower().partition("e")
    digits = len(mantissa.partition(".")[2])
    unit = 10.0 ** ((int(exponent) if exponent else 0) - digits)
    # Four figures and no point: the last digits of a big number may be zeros.
    if digits == 0 and abs(shown) >= 1e4:
        unit = max(unit, 10.0 ** (len(str(int(abs(shown)))) - 4))
    return abs(shown - value) <= 0.51 * unit


def tables(element):
    for table in element.iter("table"):
        head = ["".join(cell.itertext()) for cell in table.findall("./thead/tr/th")]
        for row in table.findall("./tbody/tr"):
            yield head, ["".join(cell.itertext()) for cell in row.findall("td")]


def compare(page, results, sweeps):
    """Figures of the page that are not those of the files, as a list of sentences."""
    text = page.read_text()
    tree = ET.fromstring(re.sub(r'xmlns="[^"]*"', "", text.replace("<!DOCTYPE html>", "")))
    runs = results.get("runs", [results])
    faults, checked = [], 0

    def check(good, what):
        nonlocal checked
        checked += 1
        if not good:
            faults.append(what)

    rows = list(tables(tree))
    tasks = [row for head, row in rows if head[:2] == ["task", "group"]]
    wanted = [task for run in runs for task in run["tasks"]]
    check(len(tasks) == len(wanted), f"{len(tasks)} tasks on the page, {len(wanted)} in the file")
    for row, task in zip(tasks, wanted):
        check(row[0] == task["name"], f"task {row[0]} is {task['name']}")
        for column, key in ((4, "p50_us"), (5, "p99_us"), (6, "p999_us"), (7, "max_us"), (9, "n"), (10, "missed")):
            value = task[key] if key in task else task.get("count")
            check(agrees(row[column], value), f"{task['name']} {key}: {row[column]} is {value}")
    errors = [row for head, row in rows if head and head[0] == "error"]
    for row, (name, value) in zip(errors, ((n, v) for run in runs for n, v in sorted(run.get("errors", {}).items()))):
        check(agrees(row[1], value), f"error {name}: {row[1]} is {value}")
    counters = [("".join(div.find("span").itertext()), "".join(div.find("b").itertext()))
                for box in tree.iter("div") if box.get("class") == "counters" for div in box.findall("div")]
    in_file = [(name, value) for run in runs for name, value in sorted(run["counters"].items())]
    check(len(counters) == len(in_file), f"{len(counters)} counters on the page, {len(in_file)} in the file")
    for (name, shown), (wanted_name, value) in zip(counters, in_file):
        check(name == wanted_name and re.sub(r"\D", "", shown) == str(value), f"counter {name}: {shown} is {wanted_name} {value}")
    for run in runs:
        check(run["digest"] in text, "the digest is not on the page")
    cells = [(head, row) for head, row in rows if "memory MB" in head]
    wanted = [(sweep, cell) for sweep in sweeps for cell in sweep["cells"]]
    check(len(cells) == len(wanted), f"{len(cells)} cells of sweeps on the page, {len(wanted)} in the file")
    for (head, row), (sweep, cell) in zip(cells, wanted):
        check(row[0] == cell["values"][sweep["knobs"][0]], f"cell {row[0]} is {cell['values']}")
        check(agrees(row[[h.startswith("load") for h in head].index(True)], cell["load_us_per_s"]), f"load of {row[0]}")
        if sweep["error"]:
            check(agrees(row[1], cell["errors"].get(sweep["error"])), f"{sweep['error']} of {row[0]}: {row[1]} is {cell['errors'].get(sweep['error'])}")
        check(("*" in row[-1]) == cell["on_front"] and ("<" in row[-1]) == cell["profile_choice"], f"marks of {row[0]}")
    check(checked > 100, f"only {checked} figures compared")
    return faults, checked


failures = []


def expect(good, what):
    print(("ok   " if good else "FAIL ") + what)
    if not good:
        failures.append(what)


def run(*arguments):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    expect(done.returncode == 0, " ".join(map(str, arguments[:6])))
    if done.returncode != 0:
        print(done.stdout[-2000:], done.stderr[-2000:])
        sys.exit(1)


folder.mkdir(parents=True, exist_ok=True)
if "<html" not in browse("--dump-dom", "about:blank").stdout:
    print(f"skipped: {browser} does not start here")
    sys.exit(77)
ugv, uav, out = folder / "ugv.lcm", folder / "uav.lcm", folder / "out"
run("run", "--scene", "ugv_rescue", "--virtual", "--seconds", "12", "--record", ugv)
run("run", "--scene", "uav_rescue", "--virtual", "--seconds", "12", "--record", uav)
run("report", ugv, uav, "--out", out, "--sweep", "map.voxel_m=0.07,0.1,0.2", "--sweep", "attitude.acc_time_constant_s=1,3,10")
page = out / "report.html"
results = json.loads((out / "results.json").read_text())
sweeps = json.loads((out / "sweeps.json").read_text())["sweeps"]
expect(len(sweeps) == 2, "two sweeps")
for width in (1280, 800):
    faults = look(page, width)
    expect(not faults, f"it looks well at {width} pixels: {faults[:12]}")
faults, checked = compare(page, results, sweeps)
expect(not faults, f"{checked} figures are those of the files: {faults[:12]}")
pdf = folder / "page.pdf"
browse(f"--print-to-pdf={pdf}", "--no-pdf-header-footer", page.as_uri())
expect(pdf.exists() and pdf.read_bytes().startswith(b"%PDF") and pdf.stat().st_size > 50_000, "it prints")

# Each planted fault is found.
text = page.read_text()
planted = folder / "planted.html"


def plant(what, old, new, seen):
    assert re.search(old, text), what
    planted.write_text(re.sub(old, new, text, count=1))
    expect(bool(seen(planted)), f"planted: {what}")


labels = re.findall(r"<text [^>]*>[^<]+</text>", text)
plant("a label on another", re.escape(labels[3]), lambda m: labels[3] + labels[3], lambda p: [f for f in look(p) if "overlaps" in f])
plant("a table that is too wide", "</main>", "<div style='width:3000px'>x</div></main>", lambda p: [f for f in look(p) if "wide" in f])
plant("a word on the console", "</main>", "<script>console.error('planted')</script></main>", lambda p: [f for f in look(p) if "console" in f])
digit = re.search(r"<h2>Tasks</h2>.*?<tbody><tr>(<td.*?</td>){4}<td[^>]*>([0-9.]+)</td>", text, re.S)
start, end = digit.span(2)
planted.write_text(text[:start] + str(float(digit.group(2)) * 1.01 + 1) + text[end:])
expect(bool(compare(planted, results, sweeps)[0]), "planted: a figure that is not the file's")
print(f"{len(failures)} failures")
sys.exit(1 if failures else 0)
