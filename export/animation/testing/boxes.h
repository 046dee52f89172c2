// Unwrapped boxes that stretch.
#pragma once

#include <string>
#include <vector>

#include "core/surfaces/shapes.h"
#include "export/animation/animated_mesh.h"

namespace keypose::exporting {

// A unit box. Each face has its own patch of the texture, so the eight corners become 24 or more
// split vertices.
inline Mesh UnwrappedBox() {
  Mesh box = MakeBox(1, 2, 3);
  box.uvs.resize(3 * box.face_count(), 2);
  box.uv_faces.resize(box.face_count(), 3);
  for (int f = 0; f < box.face_count(); ++f) {
    for (int k = 0; k < 3; ++k) {
      box.uv_faces(f, k) = 3 * f + k;
      box.uvs.row(3 * f + k) << (f + (k == 1)) / 13.0, (k == 2) * 0.75;
    }
  }
  return box;
}

inline std::vector<Mesh> StretchingBox(int count) {
  std::vector<Mesh> frames(count, UnwrappedBox());
  for (int i = 1; i < count; ++i) frames[i].points.col(2) *= 1 + 0.25 * i;
  return frames;
}

inline std::vector<std::string> Names(std::size_t count) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i) names.push_back("frame_000" + std::to_string(i));
  return names;
}

/// Frames of a box with these heights; equal heights give equal pictures.
inline AnimatedMesh Boxes(const std::vector<int>& heights) {
  std::vector<Mesh> frames(heights.size(), UnwrappedBox());
  for (std::size_t i = 0; i < heights.size(); ++i) frames[i].points.col(2) *= 1 + 0.25 * heights[i];
  return MakeAnimatedMesh(frames, Names(frames.size()));
}

}  // namespace keypose::exporting
