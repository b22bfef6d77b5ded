#!/usr/bin/env python3
"""Opens `calot view` on a display of its own and works it with mouse and keys: grasps, clips and cuts a duct, looks at
what the picture shows, and leaves. The recording, run again, must say that all of it happened.

    python3 view_window.py CALOT
"""
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

SCENE = """
title = "A duct to be grasped, clipped and cut"
length_unit = "mm"
rayleigh_mass = 5.0
gravity = [0.0, 0.0, 0.0]
[[tube]]
points = [[0, 0, 0], [42, 0, 0]]
radius = 1.5
region = "cystic duct"
rings = 2
fixed = ["first", "last"]
[[instrument]]
name = "grasper"
kind = "bowel grasper"
port = [55.0, -60.0, 120.0]
keyframes = [{ time = 0.0, tip = [34.0, 2.0, -6.0], opening = 55.0 }]
[[instrument]]
name = "clip applier"
kind = "clip applier"
port = [14.0, 60.0, 120.0]
keyframes = [{ time = 0.0, tip = [6.0, -1.5, -3.0], opening = 25.0 }]
[[instrument]]
name = "scissors"
kind = "scissors"
port = [30.0, -60.0, 120.0]
keyframes = [{ time = 0.0, tip = [17.5, 3.4, -7.0], opening = 45.0 }]
"""


class Display:
    """A display without a screen, on a number that is free."""

    def __init__(self):
        read, write = os.pipe()
        self.server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "1024x640x24", "-nolisten", "tcp"],
                                       pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as lines:
            self.name = ":" + lines.readline().strip()
        if self.name == ":":
            sys.exit("Xvfb has not started")

    def __enter__(self):
        return self

    def __exit__(self, *ignored):
        self.server.terminate()
        self.server.wait()


class Viewer:
    """The program in a window."""

    def __init__(self, calot, display, folder, *arguments):
        self.folder = folder
        environment = dict(os.environ, DISPLAY=display.name, ALSOFT_LOGLEVEL="0", SDL_VIDEODRIVER="x11")
        self.display = dict(os.environ, DISPLAY=display.name)
        self.program = subprocess.Popen([calot, "view", "scene.toml", "--size", "640x400", "--quality", "lite", *arguments],
                                        cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.window = self.wait_for_window()
        self.do("windowfocus", "--sync", self.window)

    def wait_for_window(self):
        for _ in range(300):
            if self.program.poll() is not None:
                sys.exit("calot view ended: " + self.program.stderr.read())
            found = subprocess.run(["xdotool", "search", "--name", "Calot"], env=self.display, capture_output=True, text=True)
            if found.stdout.strip():
                time.sleep(3)  # the first pictures compile their shaders
                return found.stdout.split()[0]
            time.sleep(0.2)
        sys.exit("no window has come")

    def do(self, *words):
        subprocess.run(["xdotool", *words], env=self.display, check=True)

    def key(self, name, wait=1.0):
        self.do("keydown", name)
        time.sleep(0.3)
        self.do("keyup", name)
        time.sleep(wait)

    def hold(self, button, seconds, wait=0.7):
        self.do("mousedown", button)
        time.sleep(seconds)
        self.do("mouseup", button)
        time.sleep(wait)

    def leave(self):
        self.key("F10")  # to the pause
        self.key("F10", 0)
        return self.ended()

    def ended(self):
        try:
            out, error = self.program.communicate(timeout=60)
        except subprocess.TimeoutExpired:
            self.program.kill()
            sys.exit("calot view doesn't end")
        if self.program.returncode != 0:
            sys.exit(f"calot view ended with {self.program.returncode}: {error}")
        return out


def replayed(calot, folder, recording):
    run = subprocess.run([calot, "simulate", "scene.toml", "--replay", recording, "--json"], cwd=folder, capture_output=True,
                         text=True)
    if run.returncode != 0:
        sys.exit("the recording can't be run again: " + run.stderr)
    result = json.loads(run.stdout)
    if not (result["replay"]["same"] and result["replay"]["end_compared"]):
        sys.exit("the recording ends in another state, or has no end")
    return [event["kind"] for event in result["events"]]


def operate(calot, display, folder):
    viewer = Viewer(calot, display, folder, "--record", "hands.rec")
    viewer.key("h")  # closes the page of keys
    viewer.do("mousedown", "1")  # the left hand's grasper closes
    time.sleep(2)
    viewer.key("r")  # and its ratchet keeps it closed
    viewer.do("mouseup", "1")
    time.sleep(0.5)
    viewer.key("Tab")  # the other hand, with the clip applier
    viewer.hold("3", 0.7)  # fires
    viewer.hold("1", 2)  # closes
    viewer.key("3")  # takes the scissors
    viewer.do("mousemove_relative", "--", "3", "2")
    viewer.hold("1", 3)
    viewer.key("p")  # saves a picture
    viewer.key("f")  # looks from outside
    words = viewer.leave()
    kinds = replayed(calot, folder, "hands.rec")
    for wanted in ("grasped", "clip placed", "cut"):
        if wanted not in kinds:
            sys.exit(f"nothing was \"{wanted}\": {kinds}")
    if not re.search(r"\d+ steps, .* \d+ pictures", words):
        sys.exit("what the window did isn't told: " + words)
    pictures = list(folder.glob("calot_*.png"))
    if len(pictures) != 1 or pictures[0].stat().st_size < 10_000:
        sys.exit(f"the picture was not saved: {pictures}")


def end_early(calot, display, folder):
    """Told to stop from outside, it ends well, and what was recorded can be run again."""
    viewer = Viewer(calot, display, folder, "--record", "stopped.rec")
    viewer.key("h")
    viewer.hold("1", 1)
    viewer.program.send_signal(signal.SIGTERM)
    viewer.ended()
    replayed(calot, folder, "stopped.rec")


def main():
    calot = str(pathlib.Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as name, Display() as display:
        folder = pathlib.Path(name)
        (folder / "scene.toml").write_text(SCENE)
        operate(calot, display, folder)
        end_early(calot, display, folder)


if __name__ == "__main__":
    main()
