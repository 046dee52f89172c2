// A decimated copy of a pose with all that comparing it along its surface needs.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/mesh.h"
#include "register/functional_map.h"
#include "register/geodesics.h"
#include "register/spectral.h"

namespace keypose::registration {

/// Lengths are over the square root of the proxy's area, so shapes of different size compare.
struct IntrinsicShape {
  Mesh proxy;                            ///< P vertices: the largest piece, decimated; scaled to unit area
  double scale = 1;                      ///< input length of one proxy length
  std::vector<int> fine;                 ///< P, vertices of the input mesh
  std::vector<int> proxy_of;             ///< for each input vertex the proxy vertex into which it collapsed, -1 on other pieces
  std::unique_ptr<GeodesicGraph> graph;  ///< of the proxy
  Spectrum spectrum;
  SpectralPoints all;                ///< all proxy vertices
  std::vector<int> samples;          ///< S farthest points
  SpectralPoints sampled;            ///< those
  std::vector<int> sample_of;        ///< P, index of the nearest sample
  Eigen::MatrixXd sample_distances;  ///< S x P
  Eigen::VectorXd mean_distance;     ///< P, to the rest of the surface (AGD), area weighted
  Eigen::MatrixXd descriptors;       ///< P x D, each of the order of 1, alike where the surface looks alike
  std::vector<int> tips;             ///< proxy vertices at limbs' ends: known landmarks first, then peaks of mean_distance
  Eigen::MatrixXd tip_distances;     ///< T x P
};

struct IntrinsicOptions {
  int vertices = 1000, samples = 250, functions = 80, tips = 9;
};

/// @param known  input vertices of landmarks, they become the first tips (those on small pieces are left out: see `known_used`)
/// @throws InputError  no surface
IntrinsicShape MakeIntrinsicShape(const Mesh& mesh, const std::vector<int>& known, const IntrinsicOptions& options);

/// For each row of `at` (proxy vertices) and each pair of the tips chosen: sin of the angle from the way to one tip to the way to the
/// other, about the outward normal. Equal under bending, opposite in a mirror image.
Eigen::MatrixXd TurnsBetweenTips(const IntrinsicShape& shape, const std::vector<int>& tips, const std::vector<int>& at);

}  // namespace keypose::registration
