// Photographs and masks, reduced to the size at which they are compared with the mesh.
#pragma once

#include <filesystem>

#include "report/evidence/view_evidence.h"

namespace keypose {
struct ImageSet;
}

namespace keypose::report {

/// The longer side has at most `longer_px`.
/// @throws DiskError, InputError
Shot ReadShot(const View& view, const std::filesystem::path& photograph,
              const std::filesystem::path& mask, int longer_px);

/// Where both the first and the last mask of a photograph show the figure, and what the mesh covers
/// there; up to 400 pixels wide, so that a limb is ten thick. Photographs without a camera or
/// without both masks are left out.
std::vector<CoveredMask> CoveredMasks(const Mesh& mesh, const RayScene& scene, const Scene& cameras,
                                      const ImageSet& first, const ImageSet& last);

}  // namespace keypose::report
