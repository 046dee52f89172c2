#include "motion/tracking/rig_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"

namespace keypose::motion {
namespace {

using Eigen::Vector3d;

constexpr int kLeastVoxels = 30;
constexpr double kLeastGain = 0.8;  // factor on the disagreement that offsets must reach

std::vector<Silhouette> Without(const std::vector<Silhouette>& silhouettes, int camera) {
  std::vector<Silhouette> others = silhouettes;
  others.erase(others.begin() + camera);
  return others;
}

/// Whether the camera's mask shows about the place where the hull is.
bool Shows(const Silhouette& s, const CoarseHull& hull, const Eigen::Quaterniond& up_from_world) {
  if (s.empty()) return true;
  const Vector3d middle = up_from_world.conjugate() * hull.middle;
  const Vector3d in_camera = s.camera_from_world * middle;
  if (in_camera.z() <= 0) return false;
  const double size = (hull.high - hull.low).norm() / 4;
  return s.Distance(s.pinhole.Project(in_camera)) < size * s.pinhole.fx / in_camera.z();
}

/// Angles of the two planes through both cameras that touch an outline.
struct Tangents {
  double low = 0, high = 0;
  bool known = false;
};

/// The planes through two cameras, by their angle about the line between them.
class PlanePencil {
 public:
  PlanePencil(const Vector3d& a, const Vector3d& b, const Vector3d& middle) {
    const Vector3d line = (b - a).normalized();
    first_ = middle - a;
    first_ -= first_.dot(line) * line;
    usable_ = first_.norm() > 1e-6 * (b - a).norm();
    first_.normalize();
    second_ = line.cross(first_);
  }
  Tangents Of(const OutlineRays& rays) const {
    Tangents t{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
               usable_ && !rays.empty()};
    for (const Vector3d& ray : rays) {
      const double angle = std::atan2(ray.dot(second_), ray.dot(first_));
      t.low = std::min(t.low, angle);
      t.high = std::max(t.high, angle);
    }
    // An outline around the other camera's picture has no tangent plane.
    t.known = t.known && t.high - t.low < 120 * kDegree;
    return t;
  }

 private:
  Vector3d first_, second_;
  bool usable_ = true;
};

/// Disagreement of two cameras for each offset from -most to most.
std::vector<double> PairCosts(const std::vector<OutlineRays>& a, const std::vector<OutlineRays>& b,
                              const PlanePencil& pencil, int most) {
  std::vector<Tangents> of_a, of_b;
  for (const OutlineRays& rays : a) of_a.push_back(pencil.Of(rays));
  for (const OutlineRays& rays : b) of_b.push_back(pencil.Of(rays));
  std::vector<double> costs;
  for (int k = -most; k <= most; ++k) {
    double sum = 0;
    int count = 0;
    for (int f = 0; f < SizeOf(of_a); ++f) {
      const int g = f + k;
      if (g < 0 || g >= SizeOf(of_b) || !of_a[f].known || !of_b[g].known) continue;
      // A wrong mask must not decide: differences beyond five degrees count as five.
      const double off =
          std::abs(of_a[f].low - of_b[g].low) + std::abs(of_a[f].high - of_b[g].high);
      sum += std::min(off, 10 * kDegree);
      ++count;
    }
    costs.push_back(count > 0 ? sum / (2 * count) : 0);
  }
  return costs;
}

struct PairTable {
  int a, b;
  std::vector<double> costs;
};

double TotalCost(const std::vector<PairTable>& pairs, const std::vector<int>& offsets, int most) {
  double sum = 0;
  for (const PairTable& pair : pairs) {
    const int k = std::clamp(offsets[pair.b] - offsets[pair.a], -most, most);
    sum += pair.costs[k + most];
  }
  return sum / std::max<std::size_t>(1, pairs.size());
}

/// Each camera's offset by itself, until none becomes better.
void Descend(const std::vector<PairTable>& pairs, int most, std::vector<int>* offsets) {
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t c = 1; c < offsets->size(); ++c) {
      int best = (*offsets)[c];
      double least = TotalCost(pairs, *offsets, most);
      for (int k = -most; k <= most; ++k) {
        (*offsets)[c] = k;
        if (const double cost = TotalCost(pairs, *offsets, most); cost < least - 1e-12) {
          least = cost;
          best = k;
          changed = true;
        }
      }
      (*offsets)[c] = best;
    }
  }
}

}  // namespace

RigAgreement CheckAgreement(const std::vector<Silhouette>& silhouettes,
                            const Eigen::Quaterniond& up_from_world) {
  RigAgreement agreement;
  agreement.hull = FindCoarseHull(silhouettes, up_from_world);
  if (agreement.hull.voxels < kLeastVoxels && silhouettes.size() > 2) {
    int best = -1;
    for (int c = 0; c < SizeOf(silhouettes); ++c) {
      const CoarseHull hull = FindCoarseHull(Without(silhouettes, c), up_from_world);
      if (hull.voxels < kLeastVoxels || (best >= 0 && hull.voxels <= agreement.hull.voxels))
        continue;
      best = c;
      agreement.hull = hull;
    }
    if (best >= 0) agreement.against.push_back(best);
  }
  if (agreement.hull.voxels < kLeastVoxels) agreement.hull.voxels = 0;
  if (agreement.hull.voxels == 0) return agreement;
  for (int c = 0; c < SizeOf(silhouettes); ++c) {
    const bool known =
        std::find(agreement.against.begin(), agreement.against.end(), c) != agreement.against.end();
    if (!known && !Shows(silhouettes[c], agreement.hull, up_from_world))
      agreement.against.push_back(c);
  }
  return agreement;
}

bool AgreesScaled(const std::vector<Silhouette>& silhouettes, int camera, double factor,
                  const Eigen::Quaterniond& up_from_world) {
  std::vector<Silhouette> scaled = silhouettes;
  scaled[camera].camera_from_world.translation *= factor;
  scaled[camera].center *= factor;
  const CoarseHull hull = FindCoarseHull(scaled, up_from_world);
  return hull.voxels >= kLeastVoxels && Shows(scaled[camera], hull, up_from_world);
}

OutlineRays RaysOf(const Silhouette& silhouette) {
  OutlineRays rays;
  for (const Silhouette::Point& point : silhouette.outline)
    rays.push_back(silhouette.camera_from_world.rotation.conjugate() *
                   silhouette.pinhole.Ray(point.pixel.x(), point.pixel.y()));
  return rays;
}

ClockOffsets FindClockOffsets(const std::vector<std::vector<OutlineRays>>& rays,
                              const std::vector<Vector3d>& centers, const Vector3d& middle,
                              int most) {
  const int cameras = SizeOf(rays);
  std::vector<PairTable> pairs;
  for (int a = 0; a < cameras; ++a)
    for (int b = a + 1; b < cameras; ++b) pairs.push_back({a, b, {}});
  ParallelFor(SizeOf(pairs), [&](std::int64_t i) {
    PairTable& pair = pairs[i];
    pair.costs = PairCosts(rays[pair.a], rays[pair.b],
                           PlanePencil(centers[pair.a], centers[pair.b], middle), most);
  });
  std::vector<int> offsets(static_cast<std::size_t>(cameras), 0);
  ClockOffsets found;
  found.before = TotalCost(pairs, offsets, most);
  Descend(pairs, most, &offsets);
  found.after = TotalCost(pairs, offsets, most);
  if (found.after > kLeastGain * found.before) {
    std::fill(offsets.begin(), offsets.end(), 0);
    found.after = found.before;
  }
  const int least = *std::min_element(offsets.begin(), offsets.end());
  for (int& offset : offsets) offset -= least;
  found.frames = offsets;
  return found;
}

}  // namespace keypose::motion
