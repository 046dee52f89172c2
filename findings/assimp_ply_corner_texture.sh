#!/usr/bin/env bash
# Assimp 5.2.5 reads a PLY's texture coordinates of corners as if they belonged to vertices: at seams the face that
# comes last in the file overwrites the others.
#
# Seen with: Debian 12's assimp-utils 5.2.5~ds0-1+b1 (it calls itself 5.2.0).
# Input: a square of two triangles, whose faces have "property list uchar float texcoord" with six numbers, the layout in
# which MeshLab and many tools of photogrammetry write texture coordinates. The two triangles lie in different charts.
# Output: an OBJ with four texture coordinates for six different corners. The second triangle is right. Two of the
# first one's three corners lie in the second one's chart. Nothing is said.
# Why it matters: a textured scan, which is full of seams, comes out with smeared stripes along each of them, as if its
# texture had been baked badly.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p debs/partial root
apt-get -qq -y --no-install-recommends --reinstall --download-only -o Debug::NoLocking=1 \
  -o Dir::Cache::archives="$work/debs" install assimp-utils=5.2.5~ds0-1+b1 libassimp5=5.2.5~ds0-1+b1 \
  >apt.log 2>&1 || { cat apt.log; exit 2; }
for deb in debs/*.deb; do dpkg-deb -x "$deb" root; done
cat >square.ply <<'PLY'
ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 2
property list uchar int vertex_indices
property list uchar float texcoord
end_header
0 0 0
1 0 0
1 1 0
0 1 0
3 0 1 2 6 0 0 0.25 0 0.25 0.25
3 0 2 3 6 0.5 0.5 0.75 0.75 0.5 0.75
PLY
LD_LIBRARY_PATH="$work/root/usr/lib/x86_64-linux-gnu" root/usr/bin/assimp export square.ply square.obj >assimp.log 2>&1
python3 - <<'PY'
import sys

wanted = [[(0, 0), (0.25, 0), (0.25, 0.25)], [(0.5, 0.5), (0.75, 0.75), (0.5, 0.75)]]
places, faces = [], []
for line in open("square.obj"):
    words = line.split()
    if words[:1] == ["vt"]:
        places.append((float(words[1]), float(words[2])))
    elif words[:1] == ["f"]:
        faces.append([places[int(corner.split("/")[1]) - 1] for corner in words[1:]])
for face, (is_so, should) in enumerate(zip(faces, wanted)):
    print(f"triangle {face}: in the file {should}, by Assimp {is_so}")
print(f"{len(places)} texture coordinates for 6 corners")
expected = [[(0.5, 0.5), (0.25, 0), (0.75, 0.75)], wanted[1]]
print("as before" if faces == expected else "CHANGED")
sys.exit(0 if faces == expected else 1)
PY
