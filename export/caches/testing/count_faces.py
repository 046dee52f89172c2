"""What Blender finds in an OBJ or FBX: faces by their corners, and the area of the flat ones.

    blender -b --factory-startup --python-exit-code 1 --python count_faces.py -- FILE

Prints name=number: vertices, faces, faces_N of N corners, and faces_list, vertices of all faces.
"""
import collections
import sys

import bpy
import numpy

if "bool" not in vars(numpy):
    numpy.bool = bool

file = sys.argv[-1]
before = set(bpy.data.objects)
if file.endswith(".obj"):
    bpy.ops.wm.obj_import(filepath=file)
else:
    bpy.ops.import_scene.fbx(filepath=file)
(mesh,) = [o.data for o in bpy.data.objects if o not in before and o.type == "MESH"]
counts = collections.Counter(len(face.vertices) for face in mesh.polygons)
print(f"vertices={len(mesh.vertices)} faces={len(mesh.polygons)}")
for corners, count in sorted(counts.items()):
    print(f"faces_{corners}={count}")
corners = [vertex for face in mesh.polygons for vertex in face.vertices]
print("corners:" + ",".join(map(str, corners)) + ";")
uvs = [round(value, 5) for loop in mesh.uv_layers[0].data for value in loop.uv]
print("uvs:" + ",".join(f"{value:g}" for value in uvs) + ";")
