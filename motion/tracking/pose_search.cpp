#include "motion/tracking/pose_search.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/numbers/rotations.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::motion {
namespace {

using Eigen::Vector3d;

constexpr int kHeadings = 16;

/// The body's cells in one view without one limb, for comparing poses of that limb.
struct LimbCanvas {
  SegmentRaster raster;           // segments of the rest
  std::vector<std::int8_t> gain;  // cells that differ more where the limb covers a cell: -1, 0, 1
  std::vector<int> stamp;         // the last candidate, or upper segment, that covered a cell
  int base = 0;                   // cells of the mask that the rest leaves
};

std::vector<LimbCanvas> CanvasesWithout(const std::vector<Silhouette>& silhouettes,
                                        const LocalSurface& surface, const PosedBody& body,
                                        std::uint32_t limb) {
  std::vector<LimbCanvas> canvases(silhouettes.size());
  ParallelFor(SizeOf(silhouettes), [&](std::int64_t v) {
    LimbCanvas& canvas = canvases[v];
    if (silhouettes[v].empty()) return;
    canvas.raster = MakeRaster(silhouettes[v]);
    Draw(Project(silhouettes[v], surface, body, ~limb & 0xffff), ~limb & 0xffff, &canvas.raster);
    const std::vector<std::uint8_t> mask = MaskCells(silhouettes[v], canvas.raster);
    canvas.stamp.assign(mask.size(), -1);
    canvas.gain.assign(mask.size(), 0);
    for (std::size_t i = 0; i < mask.size(); ++i) {
      if (canvas.raster.bits[i]) continue;
      canvas.gain[i] = mask[i] ? -1 : 1;
      canvas.base += mask[i];
    }
  });
  return canvases;
}

int FirstDof(Limb limb) {
  switch (limb) {
    case Limb::kLeftArm:
      return Joints()[kShoulderL].first_dof;
    case Limb::kRightArm:
      return Joints()[kShoulderR].first_dof;
    case Limb::kLeftLeg:
      return Joints()[kHipL].first_dof;
    default:
      return Joints()[kHipR].first_dof;
  }
}

bool IsArm(Limb limb) { return limb == Limb::kLeftArm || limb == Limb::kRightArm; }

/// Directions spread evenly over the sphere (a Fibonacci spiral).
std::vector<Vector3d> Directions(int count) {
  std::vector<Vector3d> directions;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - 2 * (i + 0.5) / count, r = std::sqrt(1 - z * z),
                 angle = 2.399963229728653 * i;
    directions.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return directions;
}

/// Numbers of a limb: three of its ball joint, one of its hinge, two of its end.
using LimbNumbers = Eigen::Matrix<double, 6, 1>;

/// A pose of a limb. Where `upper` is the same, the first three numbers are.
struct LimbCandidate {
  LimbNumbers numbers;
  int upper = 0;
};

bool Possible(const LimbNumbers& numbers, int first_dof) {
  constexpr double kSlack = 0.25;
  for (int i = 0; i < 4; ++i) {
    const DofModel& dof = Dofs()[first_dof + i];
    if (numbers[i] < dof.low - kSlack || numbers[i] > dof.high + kSlack) return false;
  }
  return true;
}

/// Along the limb in the rest pose.
Vector3d AxisOf(Limb limb) {
  if (!IsArm(limb)) return -Vector3d::UnitZ();
  return limb == Limb::kLeftArm ? Vector3d::UnitX() : Vector3d(-Vector3d::UnitX());
}

/// A regular set of poses of a limb within its joints' limits.
std::vector<LimbCandidate> Candidates(Limb limb) {
  const bool arm = IsArm(limb);
  const int first = FirstDof(limb);
  const Vector3d rest = AxisOf(limb);
  const std::vector<double> bends =
      arm ? std::vector<double>{0.1, 0.7, 1.4, 2.1} : std::vector<double>{0.1, 0.7, 1.4};
  const std::vector<double> twists =
      arm ? std::vector<double>{-1.5, -0.75, 0, 0.75, 1.5} : std::vector<double>{-0.5, 0, 0.5};
  std::vector<LimbCandidate> all;
  int upper = 0;
  for (const Vector3d& direction : Directions(arm ? 110 : 130)) {
    const Eigen::Quaterniond swing = Eigen::Quaterniond::FromTwoVectors(rest, direction);
    for (const double twist : twists) {
      LimbNumbers numbers = LimbNumbers::Zero();
      numbers.head<3>() = LogOf(Eigen::Quaterniond(swing * Eigen::AngleAxisd(twist, rest)));
      for (const double bend : bends) {
        if (bend < 0.2 && twist != 0) continue;  // the twist of a straight limb is not seen
        numbers[3] = bend;
        if (Possible(numbers, first)) all.push_back({numbers, upper});
      }
      ++upper;
    }
  }
  return all;
}

BodyPose WithLimb(const BodyPose& pose, Limb limb, const LimbNumbers& numbers) {
  BodyPose with = pose;
  with.q.segment<6>(FirstDof(limb)) = numbers;
  return with;
}

/// Compares poses of one limb with the mask of one view, in cells.
class LimbComparison {
 public:
  LimbComparison(const Silhouette& silhouette, const LocalSurface& surface, const BodyShape& shape,
                 Limb limb, LimbCanvas* canvas)
      : silhouette_(silhouette), surface_(surface), shape_(shape), canvas_(*canvas) {
    for (int s = 0; s < kSegments; ++s)
      if (SegmentsOf(limb) >> s & 1) segments_.push_back(s);
    first_joint_ = Segments()[segments_.front()].joint;
    last_joint_ = Segments()[segments_.back()].joint;
    projected_.pixels.resize(kBodyVertices, 2);
  }

  /// Cells in which the body and the mask differ, for the candidates at the indices. The upper
  /// segment is drawn once where candidates that come one after the other share it.
  std::vector<double> Differences(const BodyPose& pose, Limb limb,
                                  const std::vector<LimbCandidate>& candidates,
                                  const std::vector<int>& indices) {
    std::vector<double> differences;
    PosedBody body = Posed(pose, shape_);
    int drawn = -1, with_upper = 0;
    for (const int c : indices) {
      Repose(WithLimb(pose, limb, candidates[c].numbers), shape_, first_joint_, last_joint_, &body);
      const int upper_mark = -2 - candidates[c].upper;
      if (candidates[c].upper != drawn)
        with_upper = canvas_.base + Cover(body, segments_.front(), upper_mark, upper_mark);
      drawn = candidates[c].upper;
      int difference = with_upper;
      for (std::size_t s = 1; s < segments_.size(); ++s)
        difference += Cover(body, segments_[s], c, upper_mark);
      differences.push_back(difference);
    }
    return differences;
  }

 private:
  /// What a segment changes where neither mark stands yet; leaves its own mark.
  int Cover(const PosedBody& body, int segment, int mark, int other_mark) {
    int change = 0;
    ProjectDrawn(silhouette_, surface_, body, segment, Detail::kCoarse, &projected_);
    VisitSpans(canvas_.raster, projected_, segment, Detail::kCoarse, [&](int first, int end) {
      for (int cell = first; cell < end; ++cell) {
        int& stamp = canvas_.stamp[cell];
        if (stamp == mark || stamp == other_mark) continue;
        stamp = mark;
        change += canvas_.gain[cell];
      }
    });
    return change;
  }

  const Silhouette& silhouette_;
  const LocalSurface& surface_;
  const BodyShape& shape_;
  LimbCanvas& canvas_;
  std::vector<int> segments_;  // from the trunk outwards
  int first_joint_ = 0, last_joint_ = 0;
  ProjectedBody projected_;
};

struct Scored {
  double difference = 0;
  int index = 0;
};

void SortBest(std::vector<Scored>* scored) {
  std::stable_sort(scored->begin(), scored->end(),
                   [](const Scored& a, const Scored& b) { return a.difference < b.difference; });
}

/// Compares poses of one limb with all views; most of them only with every second one.
class LimbSearch {
 public:
  LimbSearch(const std::vector<Silhouette>& silhouettes, const LocalSurface& surface,
             const BodyShape& shape, const BodyPose& pose, Limb limb)
      : silhouettes_(silhouettes),
        surface_(surface),
        shape_(shape),
        pose_(pose),
        limb_(limb),
        canvases_(CanvasesWithout(silhouettes, surface, Posed(pose, shape), SegmentsOf(limb))) {}

  /// The most alike first.
  std::vector<Scored> Sorted(const std::vector<LimbCandidate>& candidates) {
    std::vector<int> seen;
    for (int v = 0; v < SizeOf(silhouettes_); ++v)
      if (!silhouettes_[v].empty()) seen.push_back(v);
    std::vector<Scored> scored(candidates.size());
    for (int c = 0; c < SizeOf(candidates); ++c) scored[c].index = c;
    if (SizeOf(seen) < kManyViews) {
      Add(seen, candidates, &scored);
    } else {
      std::vector<int> first, rest;
      for (int i = 0; i < SizeOf(seen); ++i) (i % 2 == 0 ? first : rest).push_back(seen[i]);
      Add(first, candidates, &scored);
      SortBest(&scored);
      scored.resize(std::max<std::size_t>(scored.size() / kWorthAll, 1));
      std::sort(scored.begin(), scored.end(),
                [](const Scored& a, const Scored& b) { return a.index < b.index; });
      Add(rest, candidates, &scored);
    }
    SortBest(&scored);
    return scored;
  }

 private:
  static constexpr int kManyViews = 6;  // from so many on, half of them sort out
  static constexpr int kWorthAll = 6;   // one in so many candidates is worth the other half

  void Add(const std::vector<int>& views, const std::vector<LimbCandidate>& candidates,
           std::vector<Scored>* scored) {
    std::vector<int> indices;
    for (const Scored& s : *scored) indices.push_back(s.index);
    std::vector<std::vector<double>> differences(views.size());
    ParallelFor(SizeOf(views), [&](std::int64_t i) {
      const int v = views[i];
      differences[i] = LimbComparison(silhouettes_[v], surface_, shape_, limb_, &canvases_[v])
                           .Differences(pose_, limb_, candidates, indices);
    });
    for (const std::vector<double>& view : differences)
      for (std::size_t i = 0; i < view.size(); ++i) (*scored)[i].difference += view[i];
  }

  const std::vector<Silhouette>& silhouettes_;
  const LocalSurface& surface_;
  const BodyShape& shape_;
  const BodyPose& pose_;
  Limb limb_;
  std::vector<LimbCanvas> canvases_;
};

}  // namespace

Coverage CoverageOf(const std::vector<Silhouette>& silhouettes, const LocalSurface& surface,
                    const PosedBody& body) {
  std::vector<Coverage> views(silhouettes.size());
  ParallelFor(SizeOf(silhouettes), [&](std::int64_t v) {
    if (silhouettes[v].empty()) return;
    SegmentRaster raster = MakeRaster(silhouettes[v]);
    Draw(Project(silhouettes[v], surface, body), 0xffff, &raster);
    const std::vector<std::uint8_t> mask = MaskCells(silhouettes[v], raster);
    for (std::size_t i = 0; i < mask.size(); ++i) {
      const bool in_body = raster.bits[i] != 0, in_mask = mask[i] != 0;
      views[v].both += in_body && in_mask;
      views[v].body_only += in_body && !in_mask;
      views[v].mask_only += in_mask && !in_body;
      if (!in_body) continue;
      for (std::size_t l = 0; l < kLimbs.size(); ++l)
        if (!(raster.bits[i] & ~SegmentsOf(kLimbs[l]))) {
          views[v].limb[l] += 1;
          views[v].limb_outside[l] += !in_mask;
        }
    }
  });
  Coverage sum;
  for (const Coverage& view : views) {
    sum.both += view.both;
    sum.body_only += view.body_only;
    sum.mask_only += view.mask_only;
    for (std::size_t l = 0; l < kLimbs.size(); ++l) {
      sum.limb[l] += view.limb[l];
      sum.limb_outside[l] += view.limb_outside[l];
    }
  }
  return sum;
}

std::uint32_t SegmentsOf(Limb limb) { return 7u << (4 + 3 * static_cast<int>(limb)); }

std::vector<BodyPose> SearchLimb(const std::vector<Silhouette>& silhouettes, const BodyShape& shape,
                                 const LocalSurface& surface, const BodyPose& pose, Limb limb,
                                 int keep) {
  std::vector<LimbCandidate> candidates = Candidates(limb);
  candidates.push_back({pose.q.segment<6>(FirstDof(limb)), candidates.back().upper + 1});
  const std::vector<Scored> scored =
      LimbSearch(silhouettes, surface, shape, pose, limb).Sorted(candidates);
  std::vector<BodyPose> best;
  for (const Scored& s : scored) {
    const LimbNumbers& numbers = candidates[s.index].numbers;
    const bool known = std::any_of(best.begin(), best.end(), [&](const BodyPose& other) {
      return (other.q.segment<4>(FirstDof(limb)) - numbers.head<4>()).norm() < 0.5;
    });
    if (!known) best.push_back(WithLimb(pose, limb, numbers));
    if (SizeOf(best) == keep) break;
  }
  return best;
}

double BentBackwards(const BodyPose& pose, Limb limb) {
  const int hinge = FirstDof(limb) + 3;
  return std::max(0.0, Dofs()[hinge].low - pose.q[hinge]);
}

BodyPose TurnedAround(const BodyPose& pose, Limb limb) {
  LimbNumbers numbers = pose.q.segment<6>(FirstDof(limb));
  const Eigen::Quaterniond ball = QuaternionOf(numbers.head<3>());
  numbers.head<3>() = LogOf(Eigen::Quaterniond(ball * Eigen::AngleAxisd(kPi, AxisOf(limb))));
  numbers[3] = -numbers[3];
  numbers.tail<2>().setZero();
  return WithLimb(pose, limb, numbers);
}

namespace {

/// The point that is nearest to the rays through the masks' middles.
Vector3d MiddleOfMasks(const std::vector<Silhouette>& silhouettes, double* radius) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Identity() * 1e-12;
  Vector3d right = Vector3d::Zero();
  for (const Silhouette& s : silhouettes) {
    if (s.empty()) continue;
    const Vector3d ray = s.camera_from_world.rotation.conjugate() *
                         s.pinhole.Ray(s.pinhole.width / 2.0, s.pinhole.height / 2.0).normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    sum += across;
    right += across * s.center;
  }
  const Vector3d middle = sum.ldlt().solve(right);
  *radius = 0;
  for (const Silhouette& s : silhouettes) {
    if (s.empty()) continue;
    const double depth = (s.camera_from_world * middle).z();
    const double half =
        std::hypot(s.pinhole.width / s.pinhole.fx, s.pinhole.height / s.pinhole.fy) / 2;
    *radius = std::max(*radius, std::abs(depth) * half);
  }
  return middle;
}

bool InsideAll(const std::vector<Silhouette>& silhouettes, const Vector3d& x, double size,
               int most_against) {
  int against = 0;
  for (const Silhouette& s : silhouettes) {
    if (s.empty()) continue;
    const Vector3d in_camera = s.camera_from_world * x;
    const bool outside = in_camera.z() <= 0 || s.Distance(s.pinhole.Project(in_camera)) >
                                                   size * s.pinhole.fx / in_camera.z();
    if (outside && ++against > most_against) return false;
  }
  return true;
}

BodyPose StandingPose(const CoarseHull& hull, const Eigen::Quaterniond& up_from_world,
                      const BodyShape& shape, double heading, double arms, double elbows) {
  BodyPose pose;
  pose.root_chart =
      up_from_world.conjugate() * Eigen::Quaterniond(Eigen::AngleAxisd(heading, Vector3d::UnitZ()));
  for (const int shoulder : {kShoulderL, kShoulderR}) {
    const double side = shoulder == kShoulderL ? 1 : -1;
    pose.q[Joints()[shoulder].first_dof + 1] = side * arms;
    pose.q[Joints()[shoulder + 1].first_dof] = elbows;
  }
  for (const int hip : {kHipL, kHipR}) {
    pose.q[Joints()[hip].first_dof + 1] = hip == kHipL ? -0.1 : 0.1;
    pose.q[Joints()[hip + 1].first_dof] = 0.1;
  }
  // Feet on the hull's lowest point, the trunk over its middle.
  const double legs = shape.lengths[kThigh] + shape.lengths[kShin] + 0.09;
  pose.q.head<3>() =
      up_from_world.conjugate() * Vector3d(hull.middle.x(), hull.middle.y(), hull.low.z() + legs);
  return pose;
}

}  // namespace

CoarseHull FindCoarseHull(const std::vector<Silhouette>& silhouettes,
                          const Eigen::Quaterniond& up_from_world) {
  constexpr int kSide = 72;
  double radius = 0;
  const Vector3d middle = MiddleOfMasks(silhouettes, &radius);
  const double voxel = 2 * radius / kSide;
  const int views = static_cast<int>(std::count_if(silhouettes.begin(), silhouettes.end(),
                                                   [](const Silhouette& s) { return !s.empty(); }));
  // Of many views one may be wrong.
  const int most_against = views >= 8 ? 1 : 0;
  std::vector<std::vector<Vector3d>> layers(kSide);
  ParallelFor(kSide, [&](std::int64_t k) {
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i) {
        const Vector3d offset =
            voxel * (Vector3d(i, j, static_cast<double>(k)).array() + 0.5 - kSide / 2.0);
        const Vector3d x = middle + up_from_world.conjugate() * offset;
        if (InsideAll(silhouettes, x, 0.3 * voxel, most_against))
          layers[k].push_back(up_from_world * x);
      }
  });
  CoarseHull hull;
  hull.low.setConstant(1e30);
  hull.high.setConstant(-1e30);
  hull.middle.setZero();
  for (const std::vector<Vector3d>& layer : layers)
    for (const Vector3d& x : layer) {
      hull.low = hull.low.cwiseMin(x);
      hull.high = hull.high.cwiseMax(x);
      hull.middle += x;
      ++hull.voxels;
    }
  hull.middle /= std::max(1, hull.voxels);
  hull.low.array() -= voxel / 2;
  hull.high.array() += voxel / 2;
  return hull;
}

std::vector<BodyPose> SearchPoses(const std::vector<Silhouette>& silhouettes,
                                  const CoarseHull& hull, const Eigen::Quaterniond& up_from_world,
                                  const BodyShape& shape, int keep, Progress* progress) {
  const LocalSurface surface = SurfaceOf(shape);
  struct Start {
    BodyPose pose;
    double difference;
  };
  std::vector<Start> starts;
  for (int h = 0; h < kHeadings; ++h)
    for (const double arms : {-0.6, 0.0, 0.7, 1.3})
      for (const double elbows : {0.15, 1.2}) {
        const BodyPose pose =
            StandingPose(hull, up_from_world, shape, 2 * kPi * h / kHeadings, arms, elbows);
        starts.push_back({pose, CoverageOf(silhouettes, surface, Posed(pose, shape)).Difference()});
      }
  const auto by_difference = [](const Start& a, const Start& b) {
    return a.difference < b.difference;
  };
  std::stable_sort(starts.begin(), starts.end(), by_difference);
  // The best start of each heading, so that front and back are both tried.
  std::vector<Start> chosen;
  for (const Start& start : starts) {
    const bool known = std::any_of(chosen.begin(), chosen.end(), [&](const Start& other) {
      return other.pose.root_chart.angularDistance(start.pose.root_chart) <
             0.7 * 2 * kPi / kHeadings;
    });
    if (!known) chosen.push_back(start);
    if (SizeOf(chosen) == 8) break;
  }
  PoseOptions options;
  options.rounds = 10;
  options.first_reach = 40;
  options.priors = {RestPrior()};
  int done = 0;
  for (Start& start : chosen) {
    if (progress && progress->cancelled()) throw Cancelled();
    start.pose = SolvePose(silhouettes, shape, surface, start.pose, options).pose;
    for (const Limb limb : kLimbs) {
      double least = CoverageOf(silhouettes, surface, Posed(start.pose, shape)).Difference();
      PoseOptions near = options;
      near.rounds = 5;
      near.first_reach = 20;
      for (const BodyPose& candidate :
           SearchLimb(silhouettes, shape, surface, start.pose, limb, 2)) {
        const BodyPose solved = SolvePose(silhouettes, shape, surface, candidate, near).pose;
        const double difference =
            CoverageOf(silhouettes, surface, Posed(solved, shape)).Difference();
        if (difference < 0.995 * least) {
          least = difference;
          start.pose = solved;
        }
      }
    }
    start.difference = CoverageOf(silhouettes, surface, Posed(start.pose, shape)).Difference();
    ReportProgress(progress, ++done / static_cast<double>(chosen.size()), "the first pose");
  }
  std::stable_sort(chosen.begin(), chosen.end(), by_difference);
  std::vector<BodyPose> best;
  for (const Start& start : chosen) {
    const BodyPose pose = start.pose.Recharted();
    const bool known = std::any_of(best.begin(), best.end(), [&](const BodyPose& other) {
      return other.root_chart.angularDistance(pose.root_chart) < 50 * kDegree;
    });
    if (!known && SizeOf(best) < keep) best.push_back(pose);
  }
  return best;
}

}  // namespace keypose::motion
