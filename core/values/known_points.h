// Points of known place, and where somebody clicked them in the pictures of fixed cameras.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace keypose {

struct KnownPoint {
  std::string name;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< in world [m]
};

struct PointClick {
  int point = 0;                                    ///< of the known ones
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< pixel centres at .5
};

/// A camera's picture with its clicks; no point twice.
struct ClickedPicture {
  std::string camera;
  std::string picture;        ///< file, relative to that of the points; empty: not said
  int width = 0, height = 0;  ///< of the picture
  std::vector<PointClick> clicks;
};

struct KnownPoints {
  std::vector<KnownPoint> points;  ///< no name twice
  std::vector<ClickedPicture> cameras;
};

}  // namespace keypose
