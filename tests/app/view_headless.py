#!/usr/bin/env python3
"""`calot view --headless` from outside: the same pictures twice, a film with sound, pictures of a recording, and calls that
are wrong.

    python3 view_headless.py CALOT
"""
import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile

SCENE = """
title = "A block under a hook"
length_unit = "mm"
seconds = 1.0
[[block]]
region = "liver"
centre = [0, 0, 0]
size = [30, 30, 10]
element_size = 5.0
fixed = ["z-"]
[[instrument]]
name = "hook"
kind = "hook"
port = [30.0, -60.0, 110.0]
keyframes = [
  { time = 0.0, tip = [-5.0, 0.0, 12.0] },
  { time = 0.3, tip = [-5.0, 0.0, 5.0], energy = true },
  { time = 1.0, tip = [6.0, 0.0, 5.0] },
]
"""


class Tester:
    def __init__(self, calot, folder):
        self.calot, self.folder = calot, folder
        self.environment = {name: value for name, value in os.environ.items()
                            if name not in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")}

    def call(self, *words):
        return subprocess.run([self.calot, *words], cwd=self.folder, env=self.environment, capture_output=True, text=True)

    def good(self, *words):
        done = self.call(*words)
        if done.returncode != 0:
            sys.exit(f"{words}: {done.returncode} {done.stderr}")
        return done.stdout

    def bad(self, code, says, *words):
        done = self.call(*words)
        lines = [line for line in done.stderr.splitlines() if line]
        if done.returncode != code or len(lines) != 1 or says not in lines[0]:
            sys.exit(f"{words}: wanted {code} and \"{says}\" on one line, got {done.returncode}: {done.stderr}")

    def pictures(self, name):
        return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in (self.folder / name).iterdir()}


def look_at_pictures(tester):
    view = ("view", "scene.toml", "--headless", "--size", "320x180", "--quality")
    for name in ("first", "second"):
        tester.good(*view, "lite", "--png", name, "--every", "30")
    first = tester.pictures("first")
    if sorted(first) != ["step_000000.png", "step_000030.png", "step_000060.png"]:
        sys.exit(f"other pictures than were asked for: {sorted(first)}")
    if len(set(first.values())) != 3:
        sys.exit("nothing moves in the pictures")
    if first != tester.pictures("second"):
        sys.exit("the same scene gave other pictures")
    tester.good("simulate", "scene.toml", "--record", "run.rec")
    tester.good(*view, "lite", "--png", "replayed", "--at", "30", "--replay", "run.rec")
    if tester.pictures("replayed") != {"step_000030.png": first["step_000030.png"]}:
        sys.exit("a recording looks otherwise than what was recorded")


def look_at_film(tester):
    tester.good("view", "scene.toml", "--headless", "--size", "320x180", "--quality", "lite", "--video", "film.mp4")
    told = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_streams", "-of", "json", "film.mp4"],
                          cwd=tester.folder, capture_output=True, text=True, check=True)
    streams = {stream["codec_type"]: stream for stream in json.loads(told.stdout)["streams"]}
    video, audio = streams["video"], streams.get("audio")
    if (video["width"], video["height"], video["nb_read_frames"], video["avg_frame_rate"]) != (320, 180, "31", "30/1"):
        sys.exit(f"the film is another one: {video}")
    if audio is None or abs(float(audio["duration"]) - 1) > 0.1:
        sys.exit(f"the film's sound is missing or of another length: {audio}")
    left = [path.name for path in tester.folder.iterdir() if "part" in path.name]
    if left:
        sys.exit(f"left behind: {left}")


def call_wrongly(tester):
    tester.bad(1, "no display", "view", "scene.toml")
    tester.bad(2, "--png", "view", "scene.toml", "--headless")
    tester.bad(2, "--headless", "view", "scene.toml", "--png", "somewhere")
    tester.bad(2, "--size", "view", "scene.toml", "--headless", "--png", "a", "--size", "huge")
    tester.bad(2, "full, lite or none", "view", "scene.toml", "--headless", "--png", "a", "--quality", "best")
    tester.bad(2, "holds something", "view", "scene.toml", "--headless", "--png", "first")
    tester.bad(2, "--at", "view", "scene.toml", "--headless", "--png", "b", "--at", "99")
    tester.bad(2, ".mp4", "view", "scene.toml", "--headless", "--video", "film.doc")
    tester.bad(2, "even", "view", "scene.toml", "--headless", "--video", "odd.mp4", "--size", "321x180")
    tester.bad(2, "SCENE", "view")
    (tester.folder / "other.toml").write_text(SCENE.replace("5.0\nfixed", "6.0\nfixed"))
    tester.bad(2, "another scene", "view", "other.toml", "--headless", "--png", "c", "--replay", "run.rec")


def main():
    with tempfile.TemporaryDirectory() as name:
        tester = Tester(str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(name))
        (tester.folder / "scene.toml").write_text(SCENE)
        look_at_pictures(tester)
        look_at_film(tester)
        call_wrongly(tester)


if __name__ == "__main__":
    main()
