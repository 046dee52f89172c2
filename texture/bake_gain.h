// One gain a view and colour channel that makes the views agree on the surface they share.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "texture/bake_view.h"

namespace keypose::texture {

/// Factors on linear light, one row a view, geometric mean 1 in each channel, each in [0.5, 2]; 1 where a view shares nothing.
///
/// Robust least squares of log colours at points spread over the surface, the colour of the surface eliminated (Goldman's and texrecon's
/// global adjustment; the normal matrix is views x views). A highlight or a wrong mask is an outlier and loses its say. Deterministic; the
/// same bits for any thread count.
std::vector<Eigen::Vector3f> HarmonizeGains(const Mesh& mesh, const std::vector<BakeView>& views, int samples = 6000);

}  // namespace keypose::texture
