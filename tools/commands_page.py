#!/usr/bin/env python3
"""Writes docs/commands.md from the program's own help.

    python3 tools/commands_page.py PROGRAM           renews the page
    python3 tools/commands_page.py PROGRAM --check   fails if it is not what the program says
"""
import pathlib
import re
import subprocess
import sys

PAGE = pathlib.Path(__file__).resolve().parent.parent / "docs/commands.md"


def help_of(program, *command):
    text = subprocess.run([program, *command, "--help"], capture_output=True, text=True, check=True).stdout
    return "\n".join(line.rstrip() for line in text.strip().splitlines())


def page(program):
    overview = help_of(program)
    listed = overview.split("Subcommands:")[1]
    commands = re.findall(r"^  ([a-z]\w*)\s", listed, re.MULTILINE)
    parts = ["# The commands", "", "What `--help` says; this page is written by `./dev docs`.", "", "```", overview, "```"]
    for command in commands:
        parts += ["", f"## calot {command}", "", "```", help_of(program, command), "```"]
    return "\n".join(parts) + "\n"


def main():
    wanted = page(sys.argv[1])
    if "--check" in sys.argv:
        if not PAGE.exists() or PAGE.read_text() != wanted:
            sys.exit("docs/commands.md is not what the program's help says; run ./dev docs")
    else:
        PAGE.write_text(wanted)


main()
