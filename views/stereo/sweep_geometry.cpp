// Planes, visited pixels and displacements of patch_match_sweep.h.
#include <algorithm>

#include "views/stereo/patch_match_sweep.h"

namespace keypose::stereo {

Eigen::Vector3d PlaneNormal(const Pinhole& camera, double x, double y,
                            const PlaneHypothesis& plane) {
  const double c = plane.inverse_depth - plane.gx * x - plane.gy * y;
  return -Eigen::Vector3d(camera.fx * plane.gx, camera.fy * plane.gy,
                          camera.cx * plane.gx + camera.cy * plane.gy + c)
              .normalized();
}

bool Visited(const SweepInputs& inputs, int x, int y) {
  const DepthBounds& b = *inputs.bounds;
  const int shift = b.shift - inputs.level;
  const int bx = std::min(x >> shift, b.nearest.width - 1),
            by = std::min(y >> shift, b.nearest.height - 1);
  return *b.nearest.at(bx, by) > 0 && InMask(*inputs.reference->levels[inputs.level].grey.at(x, y));
}

double PixelsPerInverseDepth(const SweepInputs& inputs) {
  // For the middle of the picture, at the mean of the bounds there.
  const DepthBounds& b = *inputs.bounds;
  double w = 0;
  std::int64_t n = 0;
  for (std::size_t i = 0; i < b.nearest.data.size(); ++i)
    if (b.nearest.data[i] > 0) {
      w += 0.5 * (b.nearest.data[i] + b.farthest.data[i]);
      ++n;
    }
  if (n == 0 || inputs.sources.empty()) return 1;
  w /= static_cast<double>(n);
  const Pinhole& camera = inputs.reference->camera(inputs.level);
  const Eigen::Vector3f p(static_cast<float>(camera.width * 0.5),
                          static_cast<float>(camera.height * 0.5), 1);
  double sum = 0;
  for (const PreparedView* source : inputs.sources) {
    const Transfer t = MakeTransfer(*inputs.reference, *source, inputs.level);
    auto at = [&](double inverse_depth) -> Eigen::Vector2d {
      const Eigen::Vector3d h = (t.a * p).cast<double>() + t.b.cast<double>() * inverse_depth;
      return h.head<2>() / h.z();
    };
    sum += (at(w * 1.01) - at(w * 0.99)).norm() / (0.02 * w);
  }
  return std::max(1e-9, sum / static_cast<double>(inputs.sources.size()));
}

}  // namespace keypose::stereo
