#include "motion/video3d/view_blender.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/pictures/srgb.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::motion {
namespace {

using Eigen::Vector3f;

/// Chosen on the generated performance of docs/results/video3d.md.
struct BlendTuning {
  /// square root of linear light: a view that differs by this from the median has a quarter of its
  /// weight
  KEYPOSE_TUNED(float, kAgrees, 0.08f);
  /// sum of trust times cos^4 over the views from which on a texel is seen well: one view at 60 deg
  KEYPOSE_TUNED(float, kSeenWell, 0.06f);
};
constexpr int kMostCameras = 64;

float Fourth(float x) { return x * x * x * x; }

Vector3f Rooted(const Vector3f& linear) { return linear.cwiseMax(0.0f).cwiseSqrt(); }

/// The value at which half of the weight is reached; between two of equal share, their mean.
float WeightedMedian(std::array<std::pair<float, float>, kMostCameras>& values, int count) {
  std::sort(values.begin(), values.begin() + count);
  float total = 0;
  for (int i = 0; i < count; ++i) total += values[i].second;
  float below = 0;
  for (int i = 0; i < count; ++i) {
    below += values[i].second;
    if (below > 0.5f * total * (1 + 1e-5f)) return values[i].first;
    if (below >= 0.5f * total * (1 - 1e-5f) && i + 1 < count)
      return 0.5f * (values[i].first + values[i + 1].first);
  }
  return count > 0 ? values[count - 1].first : 0;
}

/// How much a view counts in the median. All that see the place count nearly alike: by cos^4 the
/// one in front would be its own median.
float Vote(const Sighting& seen) {
  return std::min(1.0f, 4 * seen.trust) * std::min(1.0f, 4 * seen.facing);
}

/// The median of what the views show, as square roots of linear light.
Vector3f MedianColor(const std::vector<Sighting>& seen) {
  std::array<std::pair<float, float>, kMostCameras> values;
  Vector3f median = Vector3f::Zero();
  for (int c = 0; c < 3; ++c) {
    int count = 0;
    for (const Sighting& one : seen)
      if (one.trust > 0 && count < kMostCameras)
        values[count++] = {std::sqrt(std::max(0.0f, one.color[c])), Vote(one)};
    median[c] = WeightedMedian(values, count);
  }
  return median;
}

float Agreement(const Vector3f& color, const Vector3f& median) {
  const float off = (Rooted(color) - median).cwiseAbs().maxCoeff() / BlendTuning::kAgrees;
  return 1 / ((1 + off * off) * (1 + off * off));
}

}  // namespace

ViewBlender::ViewBlender(const FacesX3& faces, const SurfaceTexels& texels, int cameras,
                         const BlendOptions& options)
    : faces_(faces),
      texels_(texels),
      cameras_(cameras),
      options_(options),
      smoothed_(static_cast<std::size_t>(texels.count()) * cameras, 0.0f) {}

ViewBlender::Blended ViewBlender::Blend(std::vector<Sighting>& seen, float* smoothed,
                                        const std::vector<Vector3f>& gains) const {
  for (int v = 0; v < cameras_; ++v)
    if (seen[v].trust > 0) seen[v].color = seen[v].color.cwiseProduct(gains[v]);
  const Vector3f median = options_.agreement ? MedianColor(seen) : Vector3f::Zero();
  const float old = first_ ? 0 : static_cast<float>(options_.smoothing);
  Blended blended;
  float sum = 0, well = 0;
  for (int v = 0; v < cameras_; ++v) {
    const Sighting& one = seen[v];
    const float angle = Fourth(one.facing);
    const bool judged = options_.agreement && one.trust > 0;
    const float now = angle * (judged ? Agreement(one.color, median) : 1);
    smoothed[v] = (1 - old) * now + old * smoothed[v];
    if (one.trust <= 0) continue;
    const float w = one.trust * smoothed[v];
    blended.color += w * one.color;
    sum += w;
    well += one.trust * angle;
  }
  if (sum > 0) blended.color /= sum;
  blended.sure = sum > 0 ? std::min(1.0f, well / BlendTuning::kSeenWell) : 0;
  return blended;
}

TexelColors ViewBlender::Next(const PointsX3& points, const std::vector<FilmedView>& views,
                              const std::vector<Vector3f>& gains) {
  const Eigen::Matrix<float, Eigen::Dynamic, 3> places = points.cast<float>(),
                                                normals =
                                                    VertexNormals(points, faces_).cast<float>();
  TexelColors colors;
  colors.color.resize(3 * static_cast<std::size_t>(texels_.count()));
  colors.sure.resize(static_cast<std::size_t>(texels_.count()));
  ParallelBlocks(texels_.count(), 1 << 12, [&](std::int64_t begin, std::int64_t end) {
    std::vector<Sighting> seen(static_cast<std::size_t>(cameras_));
    for (std::int64_t i = begin; i < end; ++i) {
      const int face = texels_.face[i];
      const Vector3f& w = texels_.weights[i];
      const Vector3f x = MeanOfCorners(places, faces_, face, w),
                     n = MeanOfCorners(normals, faces_, face, w).normalized();
      for (int v = 0; v < cameras_; ++v) seen[v] = views[v].See(x, n);
      const Blended one = Blend(seen, smoothed_.data() + i * cameras_, gains);
      for (int c = 0; c < 3; ++c) colors.color[3 * i + c] = SrgbOf(one.color[c]);
      // The least sure texel that is seen at all is told from one that is not.
      colors.sure[i] =
          static_cast<std::uint8_t>(one.sure > 0 ? std::max(1L, std::lround(255 * one.sure)) : 0);
    }
  });
  first_ = false;
  return colors;
}

std::vector<ColorPair> PairsOfViews(const PointsX3& points, const FacesX3& faces,
                                    const std::vector<FilmedView>& views, int most) {
  const PointsX3 normals = VertexNormals(points, faces);
  const Eigen::Index step = std::max<Eigen::Index>(1, points.rows() / std::max(1, most));
  std::vector<ColorPair> pairs;
  for (Eigen::Index p = 0; p < points.rows(); p += step) {
    const Vector3f x = points.row(p).cast<float>(), n = normals.row(p).cast<float>();
    std::vector<std::pair<int, Sighting>> good;
    for (int v = 0; v < SizeOf(views); ++v) {
      const Sighting seen = views[v].See(x, n);
      if (seen.trust > 0.5f && seen.facing > 0.3f) good.emplace_back(v, seen);
    }
    for (std::size_t i = 0; i < good.size(); ++i)
      for (std::size_t j = i + 1; j < good.size(); ++j) {
        const auto& [a, in_a] = good[i];
        const auto& [b, in_b] = good[j];
        pairs.push_back({a, b, in_a.color, in_b.color, in_a.facing * in_b.facing});
      }
  }
  return pairs;
}

}  // namespace keypose::motion
