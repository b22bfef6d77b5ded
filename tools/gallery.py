#!/usr/bin/env python3
"""Makes the pictures of docs/gallery.md, and the page: every shot from a scene of examples/scenes, full and lite.

    ./dev gallery            or, with a program that is built:   python3 tools/gallery.py CALOT [SHOT …]
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENES = ROOT / "examples/scenes"
OUT = ROOT / "docs/gallery"
SIZE = "640x360"

FROM_BELOW = ((40, -20, -130), (48, 45, -20), (0, 1, 0))  # the field as a scope from below sees it, further off than usual

# Name, what is seen, scene, step, further words of the command, and the camera instead of the scene's (eye, target, up).
SHOTS = [
    ("field", "The whole field: liver, gallbladder, fat in Calot's triangle, bile duct, artery", "gallbladder", 0, [], FROM_BELOW),
    ("grasped", "The gallbladder grasped", "gallbladder", 105, [], FROM_BELOW),
    ("lifted", "The liver's edge lifted by a retractor", "gallbladder", 270, [], FROM_BELOW),
    ("triangle", "Calot's triangle with the liver lifted, as the patient's own laparoscope sees it", "gallbladder", 270, [], None),
    ("duct", "A duct before anything is done to it", "clip_and_cut", 170, [], None),
    ("clipped", "The same duct with three clips", "clip_and_cut", 545, [], None),
    ("divided", "And cut between the second and the third, then parted", "clip_and_cut", 900, [], None),
    ("cut_face", "The cut face close up", "clip_and_cut", 900, [], ((6, -16, 16), (19, 0, 0.5), (0, 0, 1))),
    ("burning", "Cautery, and its smoke", "burn", 170, [], None),
    ("burnt", "What it leaves", "burn", 400, [], None),
    ("bleeding", "An artery that was cut without a clip", "bleeding", 470, [], None),
    ("bile", "A duct that was cut without clips", "bile_leak", 420, [], None),
]


def run(*words, folder):
    done = subprocess.run([str(word) for word in words], cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(str(word) for word in words)}\n{done.stderr}")
    return done.stdout


def make_patient(calot, folder):
    run(calot, "phantom", "-o", "phantom7", "--seed", "7", "--voxel", "1.0", folder=folder)
    run(calot, "patient", "phantom7/ct.nii.gz", "phantom7/labels.nii.gz", "--ducts", "phantom7/ducts.mrk.json", "-o", "patient7",
        folder=folder)


def scene_for(name, camera, scenes):
    """The scene, with another camera where one is wanted."""
    if camera is None:
        return scenes / f"{name}.toml"
    text = re.sub(r"\n\[camera\][^\[]*(\[[^\]]*\][^\[]*)*$", "\n", (scenes / f"{name}.toml").read_text())
    eye, target, up = (", ".join(f"{float(x)}" for x in point) for point in camera)
    path = scenes / f"{name}_closer.toml"
    path.write_text(f"{text}\n[camera]\neye = [{eye}]\ntarget = [{target}]\nup = [{up}]\n")
    return path


def page():
    lines = ["# Gallery", "",
             "Pictures that `calot view --headless` makes of the example scenes on a processor that draws by itself, without",
             "a graphics card; on the left the tier `full`, on the right `lite`. `./dev gallery` makes them anew.", ""]
    for name, words, scene, step, more, _ in SHOTS:
        lines += [f"## {words}", "", f"`examples/scenes/{scene}.toml`, step {step}", "",
                  f"![{words}, full](gallery/{name}_full.png) ![{words}, lite](gallery/{name}_lite.png)", ""]
    return "\n".join(lines)


def main():
    calot = pathlib.Path(sys.argv[1]).resolve()
    wanted = [shot for shot in SHOTS if not sys.argv[2:] or shot[0] in sys.argv[2:]]
    OUT.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        scenes = folder / "examples/scenes"
        shutil.copytree(SCENES, scenes)
        if any(shot[2] == "gallbladder" for shot in wanted):
            make_patient(calot, folder)
        for shot, words, scene, step, more, camera in wanted:
            for tier in ("full", "lite"):
                pictures = folder / f"{shot}_{tier}"
                print(run(calot, "view", scene_for(scene, camera, scenes), "--headless", "--png", pictures, "--at", step,
                          "--steps", max(step, 1), "--size", SIZE, "--quality", tier, *more, folder=folder).splitlines()[-1], flush=True)
                shutil.copy(pictures / f"step_{step:06}.png", OUT / f"{shot}_{tier}.png")
    (ROOT / "docs/gallery.md").write_text(page())


if __name__ == "__main__":
    main()
