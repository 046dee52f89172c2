// One gain per view and colour channel, for equal colours on the surface that views share.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "texture/bake/bake_view.h"

namespace keypose::texture {

/// Factors on linear light, one row per view, each in [1/3, 3]. Their mean (of the logarithms,
/// weighted by how much each view shows) is 1, so that the texture has the exposure of the typical
/// photograph. Views without shared surface stay nearly unchanged.
///
/// Robust least squares of log colours at points spread over the surface, with the surface's colour
/// eliminated (as in Waechter et al., ECCV 2014; the normal matrix is views x views). A highlight
/// or a wrong mask is an outlier and loses its weight. Deterministic; the same bits for any thread
/// count.
///
/// @param used  one per view: with 0 its photograph is ignored and its factor is 1
std::vector<Eigen::Vector3f> HarmonizeGains(const Mesh& mesh, const std::vector<BakeView>& views,
                                            const std::vector<char>& used, int samples = 6000);

}  // namespace keypose::texture
