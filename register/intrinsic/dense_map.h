// Extends a map between proxies to the full meshes, and measures its confidence.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/mesh.h"
#include "register/intrinsic/functional_map.h"
#include "register/intrinsic/intrinsic_shape.h"

namespace keypose::registration {

/// One point on the proxy's faces for each input vertex.
struct OnProxy {
  std::vector<int> face;  ///< V, -1 for vertices of other pieces
  PointsX3 barycentric;   ///< V x 3
};
/// For each input vertex, the closest point on the faces around the proxy vertex it collapsed into.
/// Only these faces are searched, so that limbs that touch are not confused.
OnProxy FootOnProxy(const Mesh& mesh, const IntrinsicShape& shape);

/// For each input vertex of the source, a point on the target's proxy: the nearest point in the
/// embedding, on the faces around the images of its proxy face's corners.
///
/// @param maps  between all proxy vertices
OnProxy PreciseMap(const IntrinsicShape& source, const OnProxy& source_feet,
                   const IntrinsicShape& target, const PointMaps& maps,
                   const JointEmbedding& joint);

/// For each mapped point, a nearby input vertex of the target: the nearest of those that collapsed
/// into the corners of its proxy face. -1 where there is none.
std::vector<int> NearestVertices(const Mesh& target_mesh, const IntrinsicShape& target,
                                 const OnProxy& mapped);

/// Confidence of each proxy vertex of the source, 0 to 1. It is high where mapping forward and back
/// returns to the vertex, and where distances to samples and edge lengths are preserved.
Eigen::VectorXd MapConfidence(const IntrinsicShape& source, const IntrinsicShape& target,
                              const PointMaps& maps);

/// Share of the mapped area whose normal agrees with the target's: each source face is mapped by
/// its corners and weighted by its area on the target.
double OrientationShare(const IntrinsicShape& source, const IntrinsicShape& target,
                        const std::vector<int>& map);

}  // namespace keypose::registration
