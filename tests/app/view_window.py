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
        self.recording = arguments[arguments.index("--record") + 1]
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

    def asked(self, instrument):
        """What the instrument was asked last, as far as the recording has it: place (3), opening, grip, energy, fire."""
        lines = (self.folder / self.recording).read_text().splitlines()
        mine = [line.split(",") for line in lines if line.count(",") == 12 and line.split(",")[1] == str(instrument)]
        return [float(word) for word in mine[-1][2:5] + mine[-1][9:13]] if mine else None

    def wait_until(self, what, instrument, is_so):
        """However slow the machine is: the recording tells when the world has seen it."""
        for _ in range(600):
            now = self.asked(instrument)
            if now is not None and is_so(now):
                return
            if self.program.poll() is not None:
                sys.exit(f"calot view ended while the test waited until {what}: {self.program.stderr.read()}")
            time.sleep(0.1)
        sys.exit(f"the test waited in vain until {what}: {self.asked(instrument)}")

    def move(self, instrument):
        """A little, so that it is certain that the hand holds this one."""
        before = self.asked(instrument)[:3]
        for _ in range(40):  # a motion that comes before the page of keys has gone is the page's
            self.do("mousemove_relative", "--", "2", "1")
            time.sleep(1)
            if self.asked(instrument)[:3] != before:
                return
        sys.exit(f"instrument {instrument} doesn't follow the mouse")

    def close(self, instrument):
        self.do("mousedown", "1")
        self.wait_until(f"instrument {instrument} is closed", instrument, lambda now: now[3] < 0.02)
        time.sleep(1)

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
    viewer.wait_until("the world runs", 0, lambda now: True)
    viewer.move(0)
    viewer.do("mousedown", "1")  # the left hand's grasper closes
    viewer.wait_until("the grasper grips", 0, lambda now: now[4] > 0.5)
    viewer.key("r")  # and its ratchet keeps it closed
    viewer.do("mouseup", "1")
    viewer.key("Tab")  # the other hand, with the clip applier
    viewer.move(1)
    viewer.do("mousedown", "3")
    viewer.wait_until("the applier fires", 1, lambda now: now[6] == 1)
    viewer.do("mouseup", "3")
    viewer.close(1)
    viewer.do("mouseup", "1")
    viewer.key("3")  # takes the scissors
    viewer.move(2)
    viewer.close(2)
    viewer.do("mouseup", "1")
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
    viewer.wait_until("the world runs", 0, lambda now: True)
    viewer.program.send_signal(signal.SIGTERM)
    viewer.ended()
    replayed(calot, folder, "stopped.rec")


def lose_display(calot, folder):
    """The display goes away: the program ends, the recording with it."""
    with Display() as display:
        viewer = Viewer(calot, display, folder, "--record", "lost.rec")
        viewer.key("h")
        viewer.wait_until("the world runs", 0, lambda now: True)
        display.server.kill()
        try:
            viewer.program.communicate(timeout=60)
        except subprocess.TimeoutExpired:
            viewer.program.kill()
            sys.exit("calot view doesn't end when its display does")
    if viewer.program.returncode != 1:
        sys.exit(f"calot view ended with {viewer.program.returncode} when its display went away")
    replayed(calot, folder, "lost.rec")


def main():
    calot = str(pathlib.Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as name, Display() as display:
        folder = pathlib.Path(name)
        (folder / "scene.toml").write_text(SCENE)
        operate(calot, display, folder)
        end_early(calot, display, folder)
        lose_display(calot, folder)


if __name__ == "__main__":
    main()
