#!/usr/bin/env python3
"""Takes a generated stop-motion shot from twelve to twenty-four frames a second, and compares with the truth.

Films a clay character on a set and photographs its key poses on a turntable into --out, makes a project of film
and photographs, runs it, and prints how far the in-betweens are from pictures that were truly rendered. Exit code:
0 if every goal is reached, 6 if one is missed, else that of the failed step.
"""
import argparse
import json
import math
import os
import shlex
import shutil
import subprocess
import sys

SHOWS = "0=rest,4=wave,8=bow"
PSNR_GOAL = 30.0  # dB in the character's box


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", default="build/release/bin", help="folder of the programs")
    parser.add_argument("--out", default="filmed_shot", help="working folder; files of an earlier run are removed")
    parser.add_argument("--width", type=int, default=960, help="of the film [px]")
    parser.add_argument("--views", type=int, default=32, help="photographs of the template")
    parser.add_argument("--few", type=int, default=8, help="photographs of each other pose")
    parser.add_argument("--seed", type=int, default=1, help="character")
    parser.add_argument("--plate", action="store_true", help="give the clean plate instead of making it from the film")
    parser.add_argument("--swing", type=float, default=0, help="turn of a moving camera round the set [deg]")
    parser.add_argument("--dolly", type=float, default=0, help="way of a moving camera towards the set [m]")
    parser.add_argument("--shot", default="", metavar="ARGUMENTS",
                        help="further ones of `keypose synth shot`, as in '--focal 35 --distance 0.6'")
    parser.add_argument("--no-follow", action="store_true",
                        help="leave the animation as it is, also where it passes beside what was filmed")
    parser.add_argument("--keep", action="store_true", help="keep and use existing film, photographs and results")
    return parser.parse_args()


class Shot:
    def __init__(self, args):
        self.args = args
        self.world = os.path.abspath(args.out)
        self.project = os.path.join(self.world, "project")

    def run(self, name, *arguments, quiet=False):
        """Runs a program. If it fails, ends with its exit code."""
        command = [os.path.join(os.path.abspath(self.args.bin), name), *arguments]
        print("\n$ " + " ".join([name, *arguments]), flush=True)
        result = subprocess.run(command, stdout=subprocess.PIPE if quiet else None, text=True)
        if result.returncode != 0:
            print(f"filmed_shot: `{' '.join(command)}` ended with exit code {result.returncode}", file=sys.stderr)
            sys.exit(result.returncode if result.returncode > 0 else 1)
        return result.stdout

    def film(self):
        few = ",".join(f"{pose}={self.args.few}" for pose in ("wave", "bow"))
        self.run("keypose-synth", "shot", "--output", self.world, "--shows", SHOWS, "--width", str(self.args.width),
                 "--views", str(self.args.views), "--photo-width", "900", "--few", few, "--clean-plate",
                 "--seed", str(self.args.seed), "--swing", str(self.args.swing), "--dolly", str(self.args.dolly),
                 *shlex.split(self.args.shot))

    def make(self):
        poses = [word for pose in ("rest", "wave", "bow")
                 for word in ("--pose", f"{pose}={os.path.join(self.world, 'photos', pose)}")]
        moves = self.args.swing != 0 or self.args.dolly != 0
        plate = ["--plate", os.path.join(self.world, "plates" if moves else "plate.png")]
        plate = plate if self.args.plate or moves else []
        if not os.path.exists(self.project):
            self.run("keypose", "init", self.project, *poses, "--film", os.path.join(self.world, "film"),
                     "--shows", SHOWS, "--film-fps", "12", *plate)
        follow = [] if self.args.no_follow else ["--set", "composite.follow=true"]
        moving = ["--set", "locate.camera=moving"] if moves else []
        self.run("keypose", "run", "-C", self.project, *follow, *moving)

    def score(self):
        pictures = os.path.join(self.project, "out/shot/pictures")
        sheet = os.path.join(self.world, "made_true_difference.png")
        text = self.run("keypose-synth", "score-shot", "--shot", self.world, "--pictures", pictures,
                        "--sheet", sheet, quiet=True)
        with open(os.path.join(pictures, "composite.json"), encoding="utf-8") as file:
            return json.loads(text), json.load(file)["joins"]

    def cameras(self):
        """The shot as it was located, and as it was filmed."""
        shots = []
        for path in (os.path.join(self.project, "out/shot/shot.json"), os.path.join(self.world, "truth/shot/shot.json")):
            with open(path, encoding="utf-8") as file:
                shots.append(json.load(file))
        return shots


def turn_between(first, second):
    """The unit quaternion (w, x, y, z) that turns a camera from the first place to the second."""
    a, b = second["camera_from_world"]["rotation"], first["camera_from_world"]["rotation"]
    w, v, u, t = a[0], a[1:], b[0], [-x for x in b[1:]]
    cross = [v[1] * t[2] - v[2] * t[1], v[2] * t[0] - v[0] * t[2], v[0] * t[1] - v[1] * t[0]]
    return [w * u - sum(x * y for x, y in zip(v, t))] + [w * t[k] + u * v[k] + cross[k] for k in range(3)]


def camera_score(found, true):
    """What a moving camera's lens and turn are off by: focal lengths [px], and the largest error of its turn since the
    first frame [deg]. The size and the place of the world are the character's, so that they are not compared."""
    worst = 0.0
    true_frames = {frame["frame"]: frame for frame in true["frames"]}
    for frame in found["frames"]:
        first, mine = true_frames[found["frames"][0]["frame"]], turn_between(found["frames"][0], frame)
        exact = turn_between(first, true_frames[frame["frame"]])
        cosine = abs(sum(x * y for x, y in zip(mine, exact)))
        worst = max(worst, math.degrees(2 * math.acos(min(1.0, cosine))))
    return found["camera"]["fx"], true["camera"]["fx"], worst


def main():
    args = arguments()
    shot = Shot(args)
    if not args.keep and os.path.exists(shot.world):
        shutil.rmtree(shot.world)
    if not os.path.exists(os.path.join(shot.world, "film")):
        shot.film()
    shot.make()
    score, joins = shot.score()
    print("\n| picture | PSNR in the character's box | on the character | of the picture |\n|---|---|---|---|")
    for picture in score["pictures"]:
        print(f"| {picture['picture']} | {picture['psnr_db']:.1f} dB | {picture['psnr_on_character_db']:.1f} dB | "
              f"{picture['psnr_all_db']:.1f} dB |")
    print("\n| key | PSNR of render and filmed frame | outlines | colour |\n|---|---|---|---|")
    for join in joins:
        print(f"| {join['picture']} {join['pose']} | {join['psnr_db']:.1f} dB | {join['edge_px']:.2f} px | "
              f"{join['colour_levels']:.1f} levels |")
    if args.swing != 0 or args.dolly != 0:
        focal, true_focal, turn = camera_score(*shot.cameras())
        print(f"\nfocal length {focal:.0f} px (true: {true_focal:.0f}); the camera's turn is off by {turn:.2f} degrees at most")
    unchanged = score["filmed_unchanged"] == score["filmed"]
    print(f"\nworst in-between {score['worst_psnr_db']:.1f} dB (asked: {PSNR_GOAL:.0f}); "
          f"{score['filmed_unchanged']} of {score['filmed']} filmed frames unchanged")
    return 0 if unchanged and score["worst_psnr_db"] >= PSNR_GOAL else 6


if __name__ == "__main__":
    sys.exit(main())
