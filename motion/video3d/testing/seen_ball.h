// Walls before a camera, and a ball that cameras see.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/pictures/fit_view.h"
#include "core/values/size_of.h"
#include "motion/testing/filmed_ball.h"
#include "motion/video3d/filmed_view.h"
#include "motion/video3d/surface_texels.h"
#include "views/atlas/atlas.h"

namespace keypose::motion {

using Eigen::Vector3d;
using Eigen::Vector3f;

inline View Straight(double distance, int size) {
  View view;
  view.camera_from_world = LookAt({0, -distance, 0}, Vector3d::Zero());
  Camera& c = view.camera;
  c.width = c.height = size;
  c.fx = c.fy = size, c.cx = c.cy = 0.5 * size;
  return view;
}

/// A square across the view at depth y, facing -y.
inline Mesh Wall(double y, double half) {
  Mesh wall;
  wall.points.resize(4, 3);
  wall.points << -half, y, -half, half, y, -half, half, y, half, -half, y, half;
  wall.faces.resize(2, 3);
  wall.faces << 0, 1, 2, 0, 2, 3;
  return wall;
}

inline Mesh Joined(const Mesh& a, const Mesh& b) {
  Mesh both = a;
  both.points.conservativeResize(a.points.rows() + b.points.rows(), 3);
  both.points.bottomRows(b.points.rows()) = b.points;
  both.faces.conservativeResize(a.faces.rows() + b.faces.rows(), 3);
  both.faces.bottomRows(b.faces.rows()) = b.faces.array() + a.vertex_count();
  return both;
}

/// One texel a vertex would do; here each face has some.
struct Ball : ::testing::Test {
  BallWorld world{6};
  Atlas atlas = RasterizeAtlas(world.mesh, 512);
  SurfaceTexels texels = ListTexels(atlas);
  std::vector<Vector3f> even = std::vector<Vector3f>(6, Vector3f::Ones());

  std::vector<FilmedView> Views(int frame, int spoiled = -1) const {
    std::vector<FilmedView> views;
    const PointsX3 points = world.Points(frame);
    for (int v = 0; v < SizeOf(world.views); ++v) {
      Image8 picture = world.Picture(world.views[v], frame);
      if (v == spoiled) std::fill(picture.data.begin(), picture.data.end(), 250);
      views.emplace_back(world.views[v], picture, world.Mask(world.views[v], frame), points,
                         world.mesh.faces, FilmedViewOptions{});
    }
    return views;
  }
  /// Root of the mean square difference of well seen texels [levels].
  double Difference(const TexelColors& a, const TexelColors& b) const {
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < a.sure.size(); ++i) {
      if (a.sure[i] < 255 || b.sure[i] < 255) continue;
      for (int c = 0; c < 3; ++c) sum += std::pow(a.color[3 * i + c] - b.color[3 * i + c], 2.0);
      count += 3;
    }
    return count > 0 ? std::sqrt(sum / count) : 1e9;
  }
};

}  // namespace keypose::motion
