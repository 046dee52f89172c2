// Displacements of a surface made calm in time.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::fit {

/// A surface's displacements in one frame.
struct Offsets {
  PointsX3 local;        ///< V x 3, each in its vertex's own frame, which turns with the surface
  Eigen::VectorXd sure;  ///< V, 0 to 1
};

/// Weighted means over the frames around each frame: Gaussian in time, times `sure`. Where little
/// is sure, the mean over all frames takes over, so that what a frame hides looks as it does
/// elsewhere.
///
/// @param sigma  standard deviation [frames]; 0: each frame by itself, but for what it hides
/// @return as many frames; `sure` is that of the means
/// Same bits for any thread count.
std::vector<Offsets> Calmed(const std::vector<Offsets>& frames, double sigma);

/// V x 3: the mean over all frames, weighted alike.
/// @pre at least one frame
PointsX3 MeanOffsets(const std::vector<Offsets>& frames);

}  // namespace keypose::fit
