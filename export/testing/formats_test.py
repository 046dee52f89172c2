#!/usr/bin/env python3
"""Exports an animation in every format, reads each with a program that is not ours, and compares
every frame that shows.

    formats_test.py --bin BIN_DIR [--all] [--only FORMAT,...] [--markdown FILE] [--work FOLDER]

The animation: a clay figure of about 1,500 vertices that is held, bends its limbs, and straightens
them on twos, with a texture for each pose; the first and the last frame are held by the export.
Programs: Blender, three.js, the Khronos validator, and
Autodesk's FBX reader in FBX2glTF. A corner may be 1e-5 of the diagonal away from
its place in the frames; in `vat` half a step of its 16 bits more, in `glb` 1e-4, in `glb-few` the
bound that the export claims. --all: a format that keypose-export does not offer is a failure, else it is skipped
by name. --markdown writes the table. Needs Python with numpy.
"""
import argparse
import json
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
FORMATS = ["glb", "glb-full", "glb-few", "obj", "ply", "fbx", "pc2", "mdd", "vat", "usda", "video", "blender"]
NO_MESH = {"sheet"}  # a page for people
PROGRAMS = {
    "glb": ["Khronos validator", "Blender", "three.js"],
    "glb-full": ["Khronos validator", "Blender", "three.js"],
    "glb-few": ["Khronos validator", "Blender", "three.js"],
    "obj": ["Blender"],
    "ply": ["Blender"],
    "fbx": ["Blender", "FBX2glTF"],
    "pc2": ["Blender"],
    "mdd": ["Blender", "three.js"],
    "vat": ["Khronos validator", "three.js"],
    "usda": ["three.js"],
    "video": ["Blender"],
    "blender": ["Blender"],
}
ENDINGS = {
    "glb": ".glb",
    "glb-full": ".glb",
    "glb-few": ".glb",
    "fbx": ".fbx",
    "pc2": ".pc2",
    "mdd": ".mdd",
    "vat": ".glb",
    "usda": ".usda",
    "video": ".mp4",
}
TEXTURED = {
    ("glb", "Blender"),
    ("glb", "three.js"),
    ("glb-full", "Blender"),
    ("glb-full", "three.js"),
    ("glb-few", "Blender"),
    ("glb-few", "three.js"),
    ("obj", "Blender"),
    ("fbx", "Blender"),
    ("fbx", "FBX2glTF"),
    ("pc2", "Blender"),
    ("mdd", "Blender"),
    ("vat", "three.js"),
    ("blender", "Blender"),
}
LIGHT_TOLERANCE = 1.01e-4  # the default of glb_error, and single precision
TOLERANCE = 1e-5  # of the diagonal; single precision has 6e-8
UV_TOLERANCE = 1e-6
FPS, HOLD = 24, 2
POSES = ["rest", "bent", "rest"]
TIMELINE = {
    "schema": 2,
    "fps": FPS,
    "keys": [
        {"pose": "rest", "time": 0, "hold": 0.125},
        {"pose": "bent", "time": 0.5, "step": 2},
        {"pose": "rest", "time": 0.875},
    ],
}


class Failure(Exception):
    """A claim that does not hold."""


def run(command, seconds=300):
    words = [str(word) for word in command]
    if shutil.which(words[0]) is None:
        raise Failure(f"{words[0]} is not installed; ./dev setup installs what the tests need")
    done = subprocess.run(words, capture_output=True, text=True, timeout=seconds, cwd=ROOT)
    if done.returncode != 0:
        raise Failure(
            f"{words[0]} ended with {done.returncode}:\n{(done.stdout + done.stderr)[-3000:]}"
        )
    return done.stdout + done.stderr


def repeated(flag, values):
    return [word for value in values for word in (flag, value)]


# ---- The animation -------------------------------------------------------------------------------


def read_ply(path):
    """Positions, faces and texture coordinates of one of Keypose's PLY files with triangles."""
    head, body = path.read_bytes().split(b"end_header\n", 1)
    lines = head.decode().splitlines()
    vertex_count = next(int(line.split()[2]) for line in lines if line.startswith("element vertex"))
    face_count = next(int(line.split()[2]) for line in lines if line.startswith("element face"))
    vertex = [("p", "<f8", 3)] + ([("n", "<f4", 3)] if "property float nx" in lines else [])
    face = [("three", "u1"), ("corners", "<i4", 3)]
    if "property list uchar double texcoord" in lines:
        face += [("six", "u1"), ("uv", "<f8", 6)]
    vertices = numpy.frombuffer(body, numpy.dtype(vertex), vertex_count)
    faces = numpy.frombuffer(body, numpy.dtype(face), face_count, vertices.nbytes)
    if (faces["three"] != 3).any():
        raise Failure(f"{path} has faces that are no triangles")
    return vertices["p"], faces["corners"], faces["uv"].reshape(-1, 2) if len(face) > 2 else None


def write_png(path, color, size=64):
    """A checkerboard of a colour, so that a texture is not the same everywhere."""
    rows = numpy.zeros((size, 1 + 3 * size), numpy.uint8)
    board = (numpy.indices((size, size)).sum(axis=0) // 8) % 2
    rows[:, 1:] = (
        (numpy.array(color) * (1 - 0.4 * board[..., None])).astype(numpy.uint8).reshape(size, -1)
    )

    def part(kind, data):
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    head = struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + part(b"IHDR", head)
        + part(b"IDAT", zlib.compress(rows.tobytes()))
        + part(b"IEND", b"")
    )


def with_points(obj_text, points):
    """An OBJ with other positions."""
    rows = iter(points)
    lines = [
        "v {:.17g} {:.17g} {:.17g}".format(*next(rows)) if line.startswith("v ") else line
        for line in obj_text.splitlines()
    ]
    return "\n".join(lines) + "\n"


def make_frames(bin_dir, work):
    """Frames of a figure whose limbs bend by 120 degrees."""
    run(
        [
            bin_dir / "keypose-synth",
            "pair",
            "--output",
            work / "pair",
            "--shape",
            "character",
            "--vertices",
            "1500",
            "--bend",
            "120",
        ]
    )
    run(
        [
            bin_dir / "keypose-unwrap",
            "--clean",
            work / "pair/source.ply",
            "--unwrapped",
            work / "rest.obj",
            "--texture_size",
            "256",
            "--effort",
            "0",
        ]
    )
    rest = (work / "rest.obj").read_text()
    (work / "bent.obj").write_text(with_points(rest, read_ply(work / "pair/truth.ply")[0]))
    (work / "timeline.json").write_text(json.dumps(TIMELINE))
    run(
        [
            bin_dir / "keypose-interpolate",
            *repeated("--keys", [work / f"{pose}.obj" for pose in POSES]),
            "--timeline",
            work / "timeline.json",
            "--frames",
            work / "frames",
        ]
    )
    write_png(work / "rest.png", (220, 120, 60))
    write_png(work / "bent.png", (60, 120, 220))


def make_truth(work):
    """What a player must show, from the frames alone: all of them, one after the other, with the
    ends held."""
    read = [read_ply(path) for path in sorted((work / "frames").glob("frame_*.ply"))]
    frames = numpy.stack([points for points, _, _ in read])
    _, faces, uvs = read[0]
    order = [0] * HOLD + list(range(len(frames))) + [len(frames) - 1] * HOLD
    shown = frames[order]
    diagonal = numpy.linalg.norm(numpy.ptp(frames[0], axis=0))
    standing = sum((a == b).all() for a, b in zip(frames, frames[1:]))
    if standing < 5 or standing > len(frames) - 5:
        raise Failure(
            f"{standing} of {len(frames)} frames stand; the animation needs holds, steps and blends"
        )
    numpy.savez(
        work / "truth.npz",
        shown=shown,
        frames=frames,
        faces=faces,
        uvs=uvs.astype(numpy.float32),
        fps=FPS,
        diagonal=diagonal,
    )
    head = {
        "shown": len(shown),
        "vertices": len(frames[0]),
        "faceCount": len(faces),
        "fps": FPS,
        "diagonal": diagonal,
    }
    (work / "truth.json").write_text(json.dumps(head))
    parts = (shown.astype("<f8"), faces.astype("<i4"), uvs.astype("<f4"))
    (work / "truth.bin").write_bytes(b"".join(part.tobytes() for part in parts))
    return head


# ---- Export and re-import ------------------------------------------------------------------------


def offered_formats(bin_dir):
    described = json.loads(run([bin_dir / "keypose-export", "--describe"]))
    option = next((option for option in described["options"] if option["name"] == "formats"), None)
    return [word.strip() for word in option["help"].split(":")[-1].split(",")] if option else []


def export(bin_dir, work, formats):
    run(
        [
            bin_dir / "keypose-export",
            "--frames",
            work / "frames",
            "--animation",
            work / "animation",
            *repeated("--textures", [work / f"{pose}.png" for pose in POSES]),
            "--poses",
            ",".join(POSES),
            "--fps",
            FPS,
            "--hold",
            HOLD,
            "--formats",
            ",".join(formats),
            "--video_width",
            320,
            "--video_height",
            240,
        ]
    )
    notes = json.loads((work / "animation/animation.json").read_text())["formats"]
    return {note["format"]: note for note in notes}


def main_file(name, note, work):
    """The file that a person opens; a folder of numbered files is found by its format."""
    files = [file for file in note["files"] if file.endswith(ENDINGS.get(name, ""))]
    require(files, f"the export wrote no file for {name}: {note['files']}")
    return work / "animation" / files[0]


def convert_fbx(file, work):
    """The GLB that Autodesk's reader makes of an FBX file, its animation sampled at 24 frames a
    second. npm unpacks the program without the right to run it, so a copy of it is run, on a copy of
    the file, since it puts textures beside that."""
    program, source = work / "FBX2glTF", work / "fbx2gltf.fbx"
    shutil.copy(file, source)
    shutil.copy(ROOT / "node_modules/fbx2gltf/bin/Linux/FBX2glTF", program)
    program.chmod(0o755)
    converted = work / "fbx2gltf.glb"
    run([program, "--binary", "--anim-framerate", "bake24", "-i", source, "-o", converted])
    return converted


def read_back(program, name, note, work):
    result = work / f"{name}-{program.split()[0]}.json"
    file = main_file(name, note, work)
    if program == "Khronos validator":
        report = run(["node", ROOT / "tests/validate_gltf.mjs", file])
        if "0 errors, 0 warnings" not in report:
            raise Failure(report)
        return {}
    if program == "Blender":
        run(
            [
                "blender",
                "-b",
                "--factory-startup",
                "--python-exit-code",
                "1",
                "--python",
                HERE / "read_in_blender.py",
                "--",
                name,
                file,
                work / "truth.npz",
                result,
            ]
        )
    elif program == "FBX2glTF":
        converted = convert_fbx(file, work)
        run(["node", HERE / "read_in_three.mjs", "fbx2gltf", converted, work / "truth", result])
    else:
        run(["node", HERE / "read_in_three.mjs", name, file, work / "truth", result])
    return json.loads(result.read_text())


def require(holds, text):
    if not holds:
        raise Failure(text)


def allowed_error(name, note, found):
    if name == "vat":
        require(found["worst_exr"] <= TOLERANCE, f"the EXR is {found['worst_exr']:.2g} away")
        return TOLERANCE + found["quantum"]
    if name == "glb":
        return LIGHT_TOLERANCE
    if name == "glb-few":
        require(
            found.get("targets", 0) <= 8,
            f"{found.get('targets')} morph targets, but at most 8 are allowed",
        )
        return TOLERANCE + note["error_over_diagonal"]
    return TOLERANCE


def check(name, program, note, found, truth):
    """Raises Failure if a program found something else than was exported."""
    if program == "Khronos validator":
        return
    frames = found["frames"]
    require(frames == truth["shown"], f"{frames} frames, but {truth['shown']} show")
    require(
        abs(found.get("fps", FPS) - FPS) < 1e-3,
        f"{found.get('fps')} frames per second instead of {FPS}",
    )
    # The last picture may have a keyframe where its own time ends.
    last = found.get("last", truth["shown"] - 1)
    require(
        truth["shown"] - 1.001 < last < truth["shown"] + 0.001,
        f"the last keyframe is at {last:.3f} frames",
    )
    for film, seconds in found.get("seconds", {}).items():
        about = truth["shown"] / FPS
        require(
            abs(seconds - about) < 0.5 / FPS,
            f"{film} lasts {seconds:.3f} s, but {about:.3f} s show",
        )
    if "worst" not in found:
        return
    require(found["worst"] is not None, "a position is not a number")
    allowed = allowed_error(name, note, found)
    require(
        found["worst"] <= allowed,
        f"a corner is {found['worst']:.3g} of the diagonal away; {allowed:.3g} is allowed",
    )
    if note.get("error_over_diagonal") is not None and name != "glb-few":
        claimed = note["error_over_diagonal"]
        require(
            claimed <= TOLERANCE or name in ("vat", "glb"),
            f"the export itself claims an error of {claimed:.3g}",
        )
    if found.get("uv") is not None:
        require(found["uv"] <= UV_TOLERANCE, f"a texture coordinate is {found['uv']:.3g} off")
    if (name, program) in TEXTURED:
        require(found["texture"], "the texture does not show")
    if "markers" in found:
        wanted = [["rest", 0], ["bent", HOLD + 12], ["rest", HOLD + 21]]
        require(
            sorted(found["markers"], key=lambda mark: mark[1]) == wanted,
            f"markers {found['markers']}, not {wanted}",
        )


# ---- Table ---------------------------------------------------------------------------------------


def row(name, program, note, found):
    worst = (
        f"{found['worst']:.1e}"
        if "worst" in found
        else ("0 errors, 0 warnings" if not found else "no vertices")
    )
    return [name, program, str(found.get("frames", "")), worst, f"{note['bytes'] / 1e6:.2f} MB"]


def table(rows):
    lines = [["format", "program", "frames", "worst error / diagonal", "size"], ["---"] * 5] + rows
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def document(rows, truth):
    blender = run(["blender", "--version"]).splitlines()[0]
    lock = json.loads((ROOT / "package-lock.json").read_text())["packages"]
    three, validator, fbx = (
        lock[f"node_modules/{name}"]["version"] for name in ("three", "gltf-validator", "fbx2gltf")
    )
    return f"""# Formats, read by other programs

`export/testing/formats_test.py --markdown`: a figure of {truth['vertices']} vertices and
{truth['faceCount']} faces that is held, bends, and straightens on twos, at {FPS} frames a second;
{truth['shown']} frames show. Every corner of every face is compared in every frame that shows,
after the axes and the unit of the program: {blender}, three.js {three}, Khronos validator
{validator}, FBX2glTF {fbx} with Autodesk's reader. Corner k of face f is compared with corner k of face f; the texture coordinates of all
corners agree to {UV_TOLERANCE:g}. Frame rates agree wherever a file or a program has one.

{table(rows)}
`ply` keeps the frames' axes; all are read by the program's own settings. three.js reads the points
of one time of a USD file: each time sample is given to it in their place. Debian's Blender reads no
USD.

Allowed are {TOLERANCE:g} of the diagonal, for `vat` half a step of its 16 bits more, for `glb`
1e-4, for `glb-few` what `animation.json` claims.
"""


def check_format(name, note, truth, work):
    """@return rows of the table, and faults"""
    rows, faults = [], []
    for program in PROGRAMS[name]:
        try:
            found = read_back(program, name, note, work)
            check(name, program, note, found, truth)
            rows.append(row(name, program, note, found))
        except (Failure, subprocess.TimeoutExpired) as error:
            faults.append(f"{name} in {program}: {error}")
    return rows, faults


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--only", default=",".join(FORMATS))
    parser.add_argument("--markdown", type=pathlib.Path)
    parser.add_argument("--work", type=pathlib.Path)
    options = parser.parse_args()
    work = options.work or pathlib.Path(tempfile.mkdtemp(prefix="keypose_formats_"))
    work.mkdir(exist_ok=True)
    bin_dir = options.bin.absolute()
    wanted, offered = options.only.split(","), offered_formats(bin_dir)
    skipped = [name for name in wanted if name not in offered]
    unknown = [name for name in offered if name not in FORMATS and name not in NO_MESH]
    rows, faults = [], [f"nothing reads the format {name} here" for name in unknown]
    faults += [f"keypose-export does not offer {name}" for name in skipped if options.all]
    make_frames(bin_dir, work)
    truth = make_truth(work)
    names = [name for name in wanted if name in offered]
    notes = export(bin_dir, work, names)
    for name in names:
        more_rows, more_faults = check_format(name, notes[name], truth, work)
        rows, faults = rows + more_rows, faults + more_faults
    print(table(rows))
    for name in skipped:
        print(f"skipped: {name}: keypose-export does not offer it")
    for fault in faults:
        print(f"FAILED: {fault}")
    if options.markdown and not faults:
        options.markdown.write_text(document(rows, truth))
    if not options.work:
        shutil.rmtree(work)
    print(f"{len(rows)} passed, {len(faults)} failed")
    return 1 if faults or not rows else 0


if __name__ == "__main__":
    sys.exit(main())
