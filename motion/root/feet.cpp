#include "motion/root/feet.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/numbers/cholesky.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "core/values/union_find.h"

namespace keypose::motion {

namespace {

// Chosen on the walks of motion/bvh (docs/results/transfer.md).
struct FeetTuning {
  KEYPOSE_TUNED(double, kSole, 0.03);      // of the height: of a patch, above the lowest point
  KEYPOSE_TUNED(double, kStands, 0.03);    // of the height: above the lowest place of a patch
  KEYPOSE_TUNED(double, kSlow, 0.15);      // of the height a second
  KEYPOSE_TUNED(double, kPairs, 0.15);     // of the height, between patches of the two meshes
  KEYPOSE_TUNED(double, kElongated, 1.6);  // length over width of a patch that is cut in two
  KEYPOSE_TUNED(int, kGap, 2);             // frames
  KEYPOSE_TUNED(int, kShortest, 3);        // frames
  KEYPOSE_TUNED(int, kEase, 5);            // frames
  KEYPOSE_TUNED(double, kFlight, 0.05);    // weight of no change of velocity, without contact
  KEYPOSE_TUNED(double, kSmooth, 0.5);     // weight of no acceleration
};
using Tuning = FeetTuning;

constexpr double kHold = 1e-4;  // weight that keeps the path's first frame in place

void SetCentre(SolePatch& patch, const PointsX3& points) {
  patch.centre.setZero();
  for (int i : patch.vertices)
    patch.centre += points.row(i) / static_cast<double>(patch.vertices.size());
}

/// The two halves of a patch across its longer horizontal axis; the patch itself when it is round.
std::vector<SolePatch> Halves(const SolePatch& patch, const PointsX3& points) {
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
  for (int i : patch.vertices) {
    const Eigen::Vector2d d = (points.row(i) - patch.centre).head<2>();
    moments += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(moments);
  const Eigen::Vector2d squares = axes.eigenvalues();
  if (patch.vertices.size() < 6 ||
      !(squares[1] > Tuning::kElongated * Tuning::kElongated * squares[0]))
    return {patch};
  std::vector<SolePatch> halves(2);
  for (int i : patch.vertices) {
    const double along =
        axes.eigenvectors().col(1).dot((points.row(i) - patch.centre).head<2>().transpose());
    halves[along > 0].vertices.push_back(i);
  }
  for (SolePatch& half : halves) {
    if (half.vertices.empty()) return {patch};
    SetCentre(half, points);
  }
  return halves;
}

double Eased(double x) { return x * x * (3 - 2 * x); }

/// Least squares for a path over T frames: rows of a few terms each.
class PathFit {
 public:
  explicit PathFit(int frames) : normal_(frames, frames), rhs_(Eigen::MatrixXd::Zero(frames, 1)) {}
  void Add(std::initializer_list<std::pair<int, double>> terms, double goal, double weight) {
    for (const auto& [i, a] : terms) {
      rhs_(i, 0) += weight * a * goal;
      for (const auto& [j, b] : terms)
        if (j <= i) entries_.emplace_back(i, j, weight * a * b);
    }
  }
  Eigen::VectorXd Solve() {
    normal_.setFromTriplets(entries_.begin(), entries_.end());
    SparseCholesky solver;
    solver.Analyze(normal_);
    solver.Factor(normal_);
    return solver.Solve(rhs_);
  }

 private:
  Eigen::SparseMatrix<double> normal_;
  Eigen::MatrixXd rhs_;
  std::vector<Eigen::Triplet<double>> entries_;
};

/// Mean over the patches that stand in both frames, of their move from frame t to t + 1.
bool MeanMove(const std::vector<SoleTrack>& tracks, const std::vector<std::vector<char>>& contacts,
              int t, Eigen::RowVector3d& move) {
  move.setZero();
  int count = 0;
  for (int p = 0; p < SizeOf(tracks); ++p) {
    if (!contacts[p][t] || !contacts[p][t + 1]) continue;
    move += tracks[p].centres.row(t + 1) - tracks[p].centres.row(t);
    ++count;
  }
  if (count > 0) move /= count;
  return count > 0;
}

PointsX3 ShiftOf(const std::vector<SoleTrack>& tracks,
                 const std::vector<std::vector<char>>& contacts,
                 const std::vector<double>& heights) {
  const int frames = static_cast<int>(tracks[0].centres.rows());
  PointsX3 shift(frames, 3);
  for (int axis = 0; axis < 3; ++axis) {
    PathFit fit(frames);
    fit.Add({{0, 1.0}}, 0, kHold);
    for (int t = 0; t + 1 < frames; ++t) {
      Eigen::RowVector3d move;
      const bool stands = MeanMove(tracks, contacts, t, move);
      const bool walks = stands && axis < 2;
      fit.Add({{t, -1.0}, {t + 1, 1.0}}, walks ? -move[axis] : 0, walks ? 1 : Tuning::kFlight);
      if (t > 0)
        fit.Add({{t - 1, 1.0}, {t, -2.0}, {t + 1, 1.0}}, 0, Tuning::kSmooth * Tuning::kFlight);
    }
    for (int p = 0; axis == 2 && p < SizeOf(tracks); ++p)
      for (int t = 0; t < frames; ++t)
        if (contacts[p][t]) fit.Add({{t, 1.0}}, heights[p] - tracks[p].centres(t, 2), 1);
    shift.col(axis) = fit.Solve();
  }
  return shift;
}

}  // namespace

std::vector<SolePatch> FindSoles(const PointsX3& points, const FacesX3& faces) {
  const double ground = points.col(2).minCoeff(), height = points.col(2).maxCoeff() - ground;
  if (!(height > 0)) return {};
  const auto low = [&](int i) { return points(i, 2) < ground + Tuning::kSole * height; };
  UnionFind joined(points.rows());
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, k), b = faces(f, (k + 1) % 3);
      if (low(a) && low(b)) joined.Join(a, b);
    }
  std::map<int, SolePatch> patches;
  for (int i = 0; i < static_cast<int>(points.rows()); ++i)
    if (low(i)) patches[joined.Find(i)].vertices.push_back(i);
  std::vector<SolePatch> soles;
  for (auto& [lowest, patch] : patches) {
    if (patch.vertices.size() < 3) continue;
    SetCentre(patch, points);
    for (SolePatch& half : Halves(patch, points)) soles.push_back(std::move(half));
  }
  return soles;
}

std::vector<int> PairSoles(
    const std::vector<SolePatch>& on_template, const std::vector<SolePatch>& on_target,
    const std::function<Eigen::RowVector3d(const Eigen::RowVector3d&)>& target_from_template,
    double target_height) {
  std::vector<int> pairs;
  for (const SolePatch& patch : on_target) {
    int best = -1;
    double nearest = Tuning::kPairs * target_height;
    for (int k = 0; k < SizeOf(on_template); ++k) {
      const double distance = (target_from_template(on_template[k].centre) - patch.centre).norm();
      if (distance < nearest) {
        nearest = distance;
        best = k;
      }
    }
    pairs.push_back(best);
  }
  return pairs;
}

std::vector<char> FindContacts(const SoleTrack& track, double height, double fps) {
  const int frames = static_cast<int>(track.centres.rows());
  std::vector<char> stands(frames, 0);
  if (frames == 0) return stands;
  const double floor = track.lowest.minCoeff();
  for (int t = 0; t < frames; ++t) {
    const int a = std::max(0, t - 1), b = std::min(frames - 1, t + 1);
    const double seconds = (b - a) / fps;
    const double speed = b > a ? (track.centres.row(b) - track.centres.row(a)).norm() / seconds : 0;
    stands[t] =
        track.lowest[t] < floor + Tuning::kStands * height && speed < Tuning::kSlow * height;
  }
  const auto runs = [&](char value, int longest, bool at_ends) {
    for (int first = 0; first < frames;) {
      int end = first;
      while (end < frames && stands[end] == stands[first]) ++end;
      const bool inside = first > 0 && end < frames;
      if (stands[first] == value && end - first <= longest && (inside || at_ends))
        std::fill(stands.begin() + first, stands.begin() + end, !value);
      first = end;
    }
  };
  runs(0, Tuning::kGap, false);
  runs(1, Tuning::kShortest - 1, frames >= Tuning::kShortest);
  return stands;
}

PatchHold HoldRuns(const PointsX3& centres, const std::vector<char>& held,
                   const std::function<Eigen::RowVector3d(int, int)>& place) {
  const int frames = SizeOf(held);
  PatchHold hold{PointsX3::Zero(frames, 3), Eigen::VectorXd::Zero(frames)};
  for (int first = 0; first < frames; ++first) {
    if (!held[first] || (first > 0 && held[first - 1])) continue;
    int end = first;
    while (end < frames && held[end]) ++end;
    const Eigen::RowVector3d at = place(first, end);
    for (int t = first; t < end; ++t) {
      hold.moves.row(t) = at - centres.row(t);
      hold.firmness[t] = 1;
    }
    for (int k = 1; k <= Tuning::kEase; ++k) {
      const double share = Eased(1 - k / (Tuning::kEase + 1.0));
      for (const auto& [t, edge] : {std::pair(first - k, first), std::pair(end - 1 + k, end - 1)}) {
        if (t < 0 || t >= frames || held[t] || hold.firmness[t] >= share) continue;
        hold.moves.row(t) = share * (at - centres.row(edge));
        hold.firmness[t] = share;
      }
    }
  }
  return hold;
}

FootPlan PlanFeet(const std::vector<SoleTrack>& tracks,
                  const std::vector<std::vector<char>>& contacts,
                  const std::vector<double>& heights) {
  FootPlan plan;
  if (tracks.empty()) return plan;
  plan.shift = ShiftOf(tracks, contacts, heights);
  for (int p = 0; p < SizeOf(tracks); ++p) {
    const PointsX3 centres = tracks[p].centres + plan.shift;
    plan.holds.push_back(HoldRuns(centres, contacts[p], [&](int first, int end) {
      Eigen::RowVector3d place = centres.middleRows(first, end - first).colwise().mean();
      place[2] = heights[p];
      return place;
    }));
  }
  return plan;
}

}  // namespace keypose::motion
