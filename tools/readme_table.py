#!/usr/bin/env python3
"""Writes README's table of measured numbers from docs/measured/*.json, which `./dev bench --readme` leaves there.

    python3 tools/readme_table.py           renews the table between its markers
    python3 tools/readme_table.py --check   fails if it is not what the measurements say
"""
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"


def number(value, unit=""):
    if value is None:
        return ""
    text = f"{value:.3g}" if 1e-3 <= abs(value) < 1e4 or value == 0 else f"{value:.1e}"
    return f"{text} {unit}" if unit and unit != "1" else text


def met(row):
    value = row["p99"] if row["p99"] is not None else row["value"]
    if row["goal"] is None and row["goal_ratio"] is None:
        return ""
    good = row["goal"] is None or value <= row["goal"]
    if row["goal_ratio"] is not None:
        good = good and row["ratio"] is not None and row["ratio"] <= row["goal_ratio"]
    return "yes" if good else "**no**"


def table_line(row):
    value = row["p99"] if row["p99"] is not None else row["value"]
    goals = [f"≤ {number(row['goal'], row['unit'])}"] if row["goal"] is not None else []
    if row["goal_ratio"] is not None:
        goals.append(f"ratio ≤ {number(row['goal_ratio'])}")
    measured = number(value, row["unit"]) + (" (p99)" if row["p99"] is not None else "")
    ratio = f"{number(row['ratio'])} of {row['baseline']}" if row["ratio"] is not None else ""
    return f"| `{row['name']}` | {measured} | {ratio} | {', '.join(goals)} | {met(row)} |"


def table(folder):
    reports = [json.loads(path.read_text()) for path in sorted(folder.glob("*.json"))]
    if not reports:
        return "Not measured yet: `./dev bench --readme` fills this in."
    lines = ["| what | measured | beside, in the same run | goal | met |", "|---|---|---|---|---|"]
    # README shows what was promised and what the paper did; the rest is in docs/measured.
    shown = ("cut.rewrite_reload", "figure4.severed.paper.max", "figure4.severed.exact.max", "figure5.2442.exact")
    promised = lambda row: row["goal"] is not None or row["goal_ratio"] is not None or row["name"] in shown
    lines += [table_line(row) for report in reports for row in report["rows"] if promised(row)]
    machines = {
        f"{m['processor']}, {m['cores']} cores, {m['threads']} threads; {m['blas']}; {m['compiler']}"
        for m in (report["machine"] for report in reports)
    }
    return "\n".join(lines + ["", "Measured on: " + " / ".join(sorted(machines)) + "."])


def main():
    readme = ROOT / "README.md"
    text = readme.read_text()
    if text.count(BEGIN) != 1 or text.count(END) != 1:
        sys.exit("README.md: the markers of the measured table are gone")
    head, rest = text.split(BEGIN)
    tail = rest.split(END)[1]
    wanted = f"{head}{BEGIN}\n{table(ROOT / 'docs/measured')}\n{END}{tail}"
    if "--check" in sys.argv:
        if wanted != text:
            sys.exit("README.md: the table differs from docs/measured; run tools/readme_table.py")
    elif wanted != text:
        readme.write_text(wanted)


main()
