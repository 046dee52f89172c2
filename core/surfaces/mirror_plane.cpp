#include "core/surfaces/mirror_plane.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/numbers/kd_tree.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

using Eigen::Vector3d;

constexpr int kMirroredSamples = 500, kSurfaceSamples = 6000;
constexpr double kFitting = 0.7;        // share of the samples that count
constexpr double kCoarse_deg = 6;       // between the first azimuths
constexpr double kCoarseOffset = 0.04;  // of the diagonal, to both sides of the middle
constexpr double kMostLean_deg = 8;
constexpr int kRefined = 4;       // of the first planes
constexpr int kHalvings = 7;      // of the steps
constexpr double kOpposed = 0.3;  // normals that agree less are of another side

double Radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// A plane by numbers of like size.
struct Tilt {
  double azimuth_deg = 0, lean_deg = 0, offset = 0;
};

class MirrorFit {
 public:
  MirrorFit(const PointsX3& points, const FacesX3& faces)
      : dense_(SampleSurface(points, faces, kSurfaceSamples, 1)),
        sparse_(SampleSurface(points, faces, kMirroredSamples, 2)),
        normals_(FaceNormals(points, faces)),
        tree_(dense_.points),
        middle_(dense_.points.colwise().mean()),
        diagonal_(BoundingDiagonal(points)) {}

  double diagonal() const { return diagonal_; }
  MirrorPlane PlaneOf(const Tilt& tilt) const {
    const double azimuth = Radians(tilt.azimuth_deg), lean = Radians(tilt.lean_deg);
    MirrorPlane plane;
    plane.normal = {std::cos(lean) * std::cos(azimuth), std::cos(lean) * std::sin(azimuth),
                    std::sin(lean)};
    plane.offset = plane.normal.dot(middle_) + tilt.offset * diagonal_;
    return plane;
  }
  double Misfit(const Tilt& tilt) const {
    const MirrorPlane plane = PlaneOf(tilt);
    std::vector<double> off;
    for (Eigen::Index i = 0; i < sparse_.points.rows(); ++i) {
      const Vector3d mirrored = plane.Mirrored(sparse_.points.row(i));
      const Vector3d normal = plane.Turned(normals_.row(sparse_.faces[i]));
      const KdTree::Neighbor near = tree_.Nearest(mirrored);
      const Vector3d there = normals_.row(dense_.faces[near.index]);
      const Vector3d step = mirrored - dense_.points.row(near.index).transpose();
      // Along the normal: samples of one surface do not lie on each other.
      off.push_back(normal.dot(there) > kOpposed && step.norm() < 0.05 * diagonal_
                        ? std::abs(step.dot(there))
                        : step.norm() + 0.02 * diagonal_);
    }
    std::sort(off.begin(), off.end());
    const auto count = static_cast<std::ptrdiff_t>(kFitting * static_cast<double>(off.size()));
    double sum = 0;
    for (std::ptrdiff_t i = 0; i < count; ++i) sum += off[i];
    return sum / static_cast<double>(count) / diagonal_;
  }

 private:
  SurfaceSamples dense_, sparse_;
  PointsX3 normals_;
  KdTree tree_;
  Vector3d middle_;
  double diagonal_;
};

struct Tried {
  Tilt tilt;
  double misfit = 0;
};

std::vector<Tried> CoarsePlanes(const MirrorFit& fit) {
  std::vector<Tried> tried;
  for (double azimuth = 0; azimuth < 180; azimuth += kCoarse_deg)
    for (const double offset : {-kCoarseOffset, 0.0, kCoarseOffset}) {
      const Tilt tilt{azimuth, 0, offset};
      tried.push_back({tilt, fit.Misfit(tilt)});
    }
  std::stable_sort(tried.begin(), tried.end(),
                   [](const Tried& a, const Tried& b) { return a.misfit < b.misfit; });
  return tried;
}

/// Steps along each number as long as one helps, then steps half as long.
Tried Refined(const MirrorFit& fit, Tried best) {
  double turn = kCoarse_deg / 2, shift = kCoarseOffset / 2;
  for (int halving = 0; halving < kHalvings; ++halving, turn /= 2, shift /= 2) {
    for (bool better = true; better;) {
      better = false;
      for (const auto& [member, step] :
           {std::pair{&Tilt::azimuth_deg, turn}, std::pair{&Tilt::offset, shift},
            std::pair{&Tilt::lean_deg, turn}})
        for (const double way : {-1.0, 1.0}) {
          Tilt tilt = best.tilt;
          tilt.*member += way * step;
          if (std::abs(tilt.lean_deg) > kMostLean_deg) continue;
          const double misfit = fit.Misfit(tilt);
          if (misfit >= best.misfit) continue;
          best = {tilt, misfit};
          better = true;
        }
    }
  }
  return best;
}

}  // namespace

MirrorPlane FindMirrorPlane(const PointsX3& points, const FacesX3& faces) {
  if (faces.rows() == 0) throw InputError("a mesh without faces has no mirror plane");
  const MirrorFit fit(points, faces);
  const std::vector<Tried> first = CoarsePlanes(fit);
  Tried best = first.front();
  for (int i = 0; i < kRefined; ++i) {
    const Tried refined = Refined(fit, first[static_cast<std::size_t>(i)]);
    if (refined.misfit < best.misfit) best = refined;
  }
  MirrorPlane plane = fit.PlaneOf(best.tilt);
  plane.misfit = best.misfit;
  return plane;
}

}  // namespace keypose
