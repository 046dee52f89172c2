// From a map between proxies to one between the meshes themselves, and how far to believe it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh.h"
#include "register/intrinsic/functional_map.h"
#include "register/intrinsic/intrinsic_shape.h"

namespace keypose::registration {

/// A point of each input vertex on the proxy's faces.
struct OnProxy {
  std::vector<int> face;  ///< -1 for vertices of other pieces
  PointsX3 barycentric;   ///< V x 3
};
/// The closest point among the faces around the proxy vertex into which each vertex collapsed, so
/// that limbs that touch stay apart.
OnProxy FootOnProxy(const Mesh& mesh, const IntrinsicShape& shape);

/// For each input vertex of the source a point of the target's proxy, by nearest point of its faces
/// in the embedding.
///
/// @param maps  between all proxy vertices
OnProxy PreciseMap(const IntrinsicShape& source, const OnProxy& source_feet,
                   const IntrinsicShape& target, const PointMaps& maps,
                   const JointEmbedding& joint);

/// The input vertex of the target nearest to each mapped point, -1 where there is none.
std::vector<int> NearestVertices(const Mesh& target_mesh, const IntrinsicShape& target,
                                 const OnProxy& mapped);

/// For each proxy vertex of the source, 0 to 1: does it come back when mapped there and back, do
/// its distances to samples stay, do its edges keep their length?
Eigen::VectorXd MapConfidence(const IntrinsicShape& source, const IntrinsicShape& target,
                              const PointMaps& maps);

/// Share of the source proxy's area whose image's normal agrees with the target's.
double OrientationShare(const IntrinsicShape& source, const IntrinsicShape& target,
                        const std::vector<int>& map);

}  // namespace keypose::registration
