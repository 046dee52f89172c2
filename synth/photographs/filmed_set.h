// The room in which a performance is filmed: a floor, walls, a lamp, and the actor's shadow.
#pragma once

#include <memory>
#include <vector>

#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::synth {

/// The empty set as each camera sees it.
class FilmedSet {
 public:
  explicit FilmedSet(std::vector<View> views);
  const std::vector<View>& views() const { return views_; }
  /// A picture of the set without the actor, with a little sensor noise.
  const Image8& Plate(int view) const { return plates_[view]; }
  /// The point of the floor that a pixel shows; not finite where it shows a wall.
  const std::vector<Eigen::Vector2f>& Floor(int view) const { return floors_[view]; }
  static Eigen::Vector3d ToLamp();  ///< unit

 private:
  std::vector<View> views_;
  std::vector<Image8> plates_;
  std::vector<std::vector<Eigen::Vector2f>> floors_;
};

/// One frame: light on the actor and its shadow on the floor are worked out once for all cameras.
class FilmedFrame {
 public:
  /// @param painted  faces and unlit colours
  /// @param points   of the frame
  FilmedFrame(const FilmedSet& set, const Mesh& painted, const PointsX3& points);
  Image8 Picture(int view, std::uint64_t noise_seed) const;

 private:
  double ShadowAt(const Eigen::Vector2f& floor) const;  // share of the lamp that arrives

  const FilmedSet& set_;
  Mesh lit_;
  std::unique_ptr<RayScene> scene_;
  Eigen::Vector2d grid_low_;
  std::vector<float> shadow_;
};

}  // namespace keypose::synth
