#include "core/testing/spots.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "core/surfaces/shapes.h"

namespace keypose {

Mesh SpottedLump() {
  Mesh mesh = MakeIcosphere(4);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Eigen::Vector3d p = mesh.points.row(v);
    const double bump = std::exp(-4 * (p - Eigen::Vector3d(0.8, 0.5, 0.3)).squaredNorm());
    mesh.points.row(v) =
        (1 + 0.6 * bump) * p.transpose().array() * Eigen::Array3d(1, 0.7, 1.2).transpose();
  }
  const Mesh ball = MakeIcosphere(4);
  mesh.uvs.resize(3 * mesh.face_count(), 2);
  mesh.uv_faces.resize(mesh.face_count(), 3);
  for (int f = 0; f < mesh.face_count(); ++f) {
    const double first =
        std::atan2(ball.points(ball.faces(f, 0), 1), ball.points(ball.faces(f, 0), 0));
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d p = ball.points.row(ball.faces(f, k));
      double turn = std::atan2(p.y(), p.x());
      turn -= 2 * M_PI * std::round((turn - first) / (2 * M_PI));  // no face spans the seam
      mesh.uvs.row(3 * f + k) << std::clamp((turn + M_PI) / (2 * M_PI), 0.0, 1.0),
          std::asin(std::clamp(p.z(), -1.0, 1.0)) / M_PI + 0.5;
      mesh.uv_faces(f, k) = 3 * f + k;
    }
  }
  return mesh;
}

Image8 Spots() {
  Image8 texture(1024, 512, 3);
  for (std::uint8_t& value : texture.data) value = 128;
  std::mt19937 random(4);
  for (int i = 0; i < 3000; ++i) {
    const int cx = random() % 1024, cy = random() % 512, r = 2 + random() % 9;
    const auto shade = static_cast<std::uint8_t>(random() % 256);
    for (int y = std::max(0, cy - r); y < std::min(512, cy + r); ++y)
      for (int x = std::max(0, cx - r); x < std::min(1024, cx + r); ++x)
        if ((x - cx) * (x - cx) + (y - cy) * (y - cy) < r * r)
          for (int c = 0; c < 3; ++c) texture.at(x, y)[c] = shade;
  }
  return texture;
}

}  // namespace keypose
