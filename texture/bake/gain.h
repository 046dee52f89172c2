// One gain a view and colour channel that makes the views agree on the surface they share.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "texture/bake/bake_view.h"

namespace keypose::texture {

/// Factors on linear light, one row a view, each in [1/3, 3]; their mean (of the logarithms, by how
/// much each view shows) is 1, so that the texture is exposed like the typical photograph of the
/// set. Views that share nothing with others are left nearly as they are.
///
/// Robust least squares of log colours at points spread over the surface, the colour of the surface
/// eliminated (as in Waechter et al., ECCV 2014; the normal matrix is views x views). A highlight
/// or a wrong mask is an outlier and loses its weight. Deterministic; the same bits for any thread
/// count.
///
/// @param used  one a view; 0: its photograph is not looked at and its factor is 1
std::vector<Eigen::Vector3f> HarmonizeGains(const Mesh& mesh, const std::vector<BakeView>& views,
                                            const std::vector<char>& used, int samples = 6000);

}  // namespace keypose::texture
