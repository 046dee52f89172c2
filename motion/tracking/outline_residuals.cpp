#include "motion/tracking/outline_residuals.h"

#include <limits>

#include "core/values/size_of.h"

namespace keypose::motion {
namespace {

// The nearest sample whose normal agrees; -1: none within reach.
int NearestSample(const std::vector<OutlineSample>& samples, const Silhouette::Point& point,
                  double reach) {
  int nearest = -1;
  double least = reach * reach;
  for (int i = 0; i < SizeOf(samples); ++i) {
    const double squared = (samples[i].pixel - point.pixel).squaredNorm();
    if (squared >= least || samples[i].normal.dot(point.normal) < OutlineTuning::kAgreement)
      continue;
    least = squared;
    nearest = i;
  }
  return nearest;
}

}  // namespace

ViewMatches FindMatches(const Silhouette& silhouette, const LocalSurface& surface,
                        const PosedBody& body, double reach) {
  ViewMatches matches;
  if (silhouette.empty()) return matches;
  const ProjectedBody projected = Project(silhouette, surface, body);
  if (!projected.before_camera) return matches;
  SegmentRaster raster = MakeRaster(silhouette);
  Draw(projected, 0xffff, &raster);
  matches.samples = FindOutline(silhouette, surface, body, projected, raster);
  for (const Silhouette::Point& point : silhouette.outline) {
    const int sample = NearestSample(matches.samples, point, reach);
    if (sample < 0) {
      ++matches.unexplained;
      continue;
    }
    const Eigen::Vector2d normal = (matches.samples[sample].normal + point.normal).normalized();
    matches.pulls.push_back({sample, point.pixel, normal});
  }
  return matches;
}

}  // namespace keypose::motion
