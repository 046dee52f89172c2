// An animation whose template has quads and polygons.
#pragma once

#include <string>
#include <vector>

#include "export/animation/scene.h"

namespace keypose::exporting {

/// The template as an artist's program writes it: a lantern of 6 sides (quads, with a pentagon and
/// a triangle among them, floor and lid of 6 corners) and an arrow of two concave polygons of 7
/// corners with quads between them. 23 quads, 1 triangle, 1 pentagon, 2 polygons of 6 and 2 of 7
/// corners. Every second face counts backwards, each corner has texture coordinates of its own, and
/// the last vertex has no face.
std::string LanternObj();

/// The faces that an OBJ's text names, in its order, found without the code under test.
struct NamedFaces {
  std::vector<int> sizes, vertices;  ///< vertices from 0
  std::vector<double> uvs;           ///< u and v of each corner
};
NamedFaces FacesOfObj(const std::string& text);

/// Blender's faces of an OBJ or FBX file: counts, vertices and coordinates of all corners.
struct BlenderFaces {
  int faces = 0, triangles = 0, quads = 0, pentagons = 0, hexagons = 0, heptagons = 0;
  std::vector<int> vertices;
  std::vector<double> uvs;
};
/// @throws std::runtime_error  Blender could not read it; has what it said
BlenderFaces ReadInBlender(const std::string& path);

/// The lantern upright and leaning, with its polygons.
Scene LanternScene();

}  // namespace keypose::exporting
