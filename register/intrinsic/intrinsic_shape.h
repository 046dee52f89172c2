// A decimated copy of a pose, with the data needed to compare it with another pose along the
// surface.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/values/mesh.h"
#include "deform/levels/geodesics.h"
#include "register/intrinsic/functional_map.h"
#include "register/intrinsic/spectral.h"

namespace keypose::registration {

/// Lengths are divided by the square root of the proxy's area, so that shapes of different size can
/// be compared.
struct IntrinsicShape {
  Mesh proxy;                 ///< P vertices: the largest piece, decimated; scaled to unit area
  double scale = 1;           ///< length in the input over length in the proxy
  std::vector<int> fine;      ///< P, the input vertex of each proxy vertex
  std::vector<int> proxy_of;  ///< for each input vertex the proxy vertex it collapsed into, -1 on
                              ///< other pieces
  std::unique_ptr<GeodesicGraph> graph;  ///< of the proxy
  Spectrum spectrum;
  SpectralPoints all;                ///< all proxy vertices
  std::vector<int> samples;          ///< S proxy vertices, by farthest point sampling
  SpectralPoints sampled;            ///< the samples
  std::vector<int> sample_of;        ///< P, index of the nearest sample
  Eigen::MatrixXd sample_distances;  ///< S x P
  Eigen::VectorXd mean_distance;     ///< P, average geodesic distance (AGD), weighted by area
  /// P x D, values of the order of 1; similar where the surface looks similar
  Eigen::MatrixXd descriptors;
  int known = 0;  ///< number of landmarks among the tips
  /// Proxy vertices at the ends of limbs: known landmarks first, then peaks of mean_distance
  std::vector<int> tips;
  Eigen::MatrixXd tip_distances;  ///< T x P
};

struct IntrinsicOptions {
  int vertices = 1000, samples = 250, functions = 80;
};

/// Builds all members except the tips.
/// @throws InputError  no area, or fewer than 4 vertices
IntrinsicShape MakeIntrinsicShape(const Mesh& mesh, const IntrinsicOptions& options);

/// Fills tips and tip_distances. Adds one descriptor for each landmark: how near it is.
/// @param known  proxy vertices of landmarks; they become the first tips
/// @param most   largest number of further tips
void FindTips(const std::vector<int>& known, int most, IntrinsicShape& shape);

/// Adds the colours of the input's vertices to the descriptors. Call it for both shapes or for
/// neither.
void AddColors(const ColorsX3& colors, IntrinsicShape& shape);

/// For each row of `distances` (R x P), the direction of steepest rise at each sample: a unit
/// tangent (S x 3, zero where there is none). Two such directions and the outward normal
/// distinguish a surface from its mirror image.
std::vector<PointsX3> RisesAtSamples(const IntrinsicShape& shape, const Eigen::MatrixXd& distances);

}  // namespace keypose::registration
