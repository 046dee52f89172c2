// The light of the set on the character: what a filmed frame shows over what the texture has.
//
// Textures hold the light of the turntable. A filmed frame whose pose and place are known says for
// each vertex that it shows how much brighter it is on the set. One smooth function of the normal
// (spherical harmonics of degree 2, as Ramamoorthi and Hanrahan, SIGGRAPH 2001) explains most of
// it, for all frames of the shot together; what is left belongs to the place on the clay.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::composite {

using Harmonics = Eigen::Matrix<double, 9, 1>;
Harmonics HarmonicsOf(const Eigen::Vector3d& normal);

/// Gains that one filmed frame shows.
struct ObservedGains {
  PointsX3 gains;           ///< V x 3; meaningless where the weight is 0
  Eigen::VectorXd weights;  ///< V, 0: not seen
  PointsX3 normals;         ///< V x 3, in world
};

/// @param filmed   RGB, linear light
/// @param layer    the character rendered with gains of 1: RGBA, premultiplied
/// @param held_out 1 channel: 255 where a prop stands before the character; empty: nowhere
/// @param blur_px  light is compared over this much of the picture, larger than the errors of place
/// Same bits for any thread count.
ObservedGains ObserveGains(const ImageF& filmed, const ImageF& layer, const Image8& held_out,
                           const PointsX3& points, const FacesX3& faces, const RayScene& scene,
                           const View& view, double blur_px);

/// The light of a shot.
struct ShotLight {
  Eigen::Matrix<double, 9, 3> harmonics = Eigen::Matrix<double, 9, 3>::Zero();
  std::vector<PointsX3> rest;  ///< per observed frame, V x 3: factors that the harmonics leave
  std::vector<Eigen::VectorXd> seen;  ///< per observed frame, V: 0 to 1
};

/// @param frames  at least one; without any weight the light is 1 everywhere
/// Same bits for any thread count.
ShotLight FitShotLight(const std::vector<ObservedGains>& frames, const FacesX3& faces);

/// Gains of a shape between two observed frames, a share of the way from one to the other.
/// @param normals  V x 3, in world
PointsX3 GainsBetween(const ShotLight& light, int before, int after, double share,
                      const PointsX3& normals);

}  // namespace keypose::composite
