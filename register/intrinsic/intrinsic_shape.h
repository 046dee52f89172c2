// A decimated copy of a pose with all that comparing it along its surface needs.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/mesh.h"
#include "deform/levels/geodesics.h"
#include "register/intrinsic/functional_map.h"
#include "register/intrinsic/spectral.h"

namespace keypose::registration {

/// Lengths are over the square root of the proxy's area, so shapes of different size compare.
struct IntrinsicShape {
  Mesh proxy;                 ///< P vertices: the largest piece, decimated; scaled to unit area
  double scale = 1;           ///< input length of one proxy length
  std::vector<int> fine;      ///< P, vertices of the input mesh
  std::vector<int> proxy_of;  ///< for each input vertex the proxy vertex into which it collapsed,
                              ///< -1 on other pieces
  std::unique_ptr<GeodesicGraph> graph;  ///< of the proxy
  Spectrum spectrum;
  SpectralPoints all;                ///< all proxy vertices
  std::vector<int> samples;          ///< S farthest points
  SpectralPoints sampled;            ///< those
  std::vector<int> sample_of;        ///< P, index of the nearest sample
  Eigen::MatrixXd sample_distances;  ///< S x P
  Eigen::VectorXd mean_distance;     ///< P, to the rest of the surface (AGD), area weighted
  /// P x D, each of the order of 1, alike where the surface looks alike
  Eigen::MatrixXd descriptors;
  int known = 0;  ///< landmarks among the tips
  /// proxy vertices at limbs' ends: known landmarks first, then peaks of mean_distance
  std::vector<int> tips;
  Eigen::MatrixXd tip_distances;  ///< T x P
};

struct IntrinsicOptions {
  int vertices = 1000, samples = 250, functions = 80;
};

/// All but the tips.
/// @throws InputError  no surface
IntrinsicShape MakeIntrinsicShape(const Mesh& mesh, const IntrinsicOptions& options);

/// Fills tips and tip_distances; nearness to each landmark becomes a descriptor.
/// @param known  proxy vertices of landmarks; they become the first tips
/// @param most   further tips at most
void FindTips(const std::vector<int>& known, int most, IntrinsicShape& shape);

/// Adds the colours of the input's vertices to the descriptors; to be called for both shapes or for
/// neither.
void AddColors(const ColorsX3& colors, IntrinsicShape& shape);

/// For each row of `distances` (R x P, to some place) the unit tangent along which it rises at each
/// sample (S x 3, zero where there is none). Two such directions and the outward normal tell a
/// surface from its mirror image.
std::vector<PointsX3> RisesAtSamples(const IntrinsicShape& shape, const Eigen::MatrixXd& distances);

}  // namespace keypose::registration
