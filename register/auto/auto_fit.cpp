#include "register/auto/auto_fit.h"

#include <algorithm>
#include <cmath>

#include "core/values/tuned.h"

namespace keypose::registration {

namespace {

// Chosen on tentacle seeds 0 to 9 (docs/results/tentacle.md) and the seven registration pairs
// (docs/results/registration.md); sensitivity: docs/results/sensitivity.md.
// Weights are in units of the shape term; lengths assume a target whose diagonal is 2.
struct AutoFitTuning {
  KEYPOSE_TUNED(double, kMatchWeight, 1000);     // of all matches together in FitToMatches
  KEYPOSE_TUNED(double, kMatchRobust, 0.3);      // length at which a match has a quarter of it
  KEYPOSE_TUNED(double, kMatchTolerance, 0.01);  // squared mismatch, likewise
  // weight of the whole surface at stiffness 1: about 1 per vertex of the middle level
  KEYPOSE_TUNED(double, kSurfaceWeight, 1700);
};

constexpr int kMostLandmarkTurns = 500, kMatchRounds = 8, kMatchTurns = 8, kSolverSteps = 10;
constexpr double kPinned = 1e5;  // weight that holds a vertex of a rigid piece
constexpr double kStill = 2e-4;  // landmark turns end below this movement

double Square(double x) { return x * x; }

void AddMarks(const Level& level, double weight, Pulls& pulls) {
  for (const Mark& mark : level.marks)
    pulls.AddPoint(mark.vertex, weight, mark.target - level.fit->maps()[mark.vertex] * mark.arm);
}

void AddMatches(const Level& level, const PointsX3& points, double weight, double robust,
                Pulls& pulls) {
  const double per_area = weight / level.fit->vertex_areas().sum();
  for (std::size_t i = 0; i < level.matches.size(); ++i) {
    const LandmarkCoordinates::Match& match = level.matches[i];
    if (match.vertex < 0) continue;
    const Eigen::Index v = static_cast<Eigen::Index>(i);
    const double r2 = (points.row(match.vertex) - level.moved.row(v)).squaredNorm();
    const double belief = Square(robust * robust / (robust * robust + r2)) *
                          Square(AutoFitTuning::kMatchTolerance /
                                 (AutoFitTuning::kMatchTolerance + Square(match.mismatch)));
    pulls.AddPoint(v, belief * per_area * level.fit->vertex_areas()[v],
                   points.row(match.vertex).transpose());
  }
}

/// Alternates between positions and maps. The pulls in `staying` are fixed; those of landmarks are
/// updated in each turn, because a landmark's arm turns with its vertex.
/// @return the largest movement of a vertex in the last turn
double Turn(Level& level, const Pulls& staying, double landmark_weight, int turns, int solver_steps,
            double still) {
  double move = 0;
  for (int k = 0; k < turns; ++k) {
    Pulls pulls = staying;
    AddMarks(level, landmark_weight, pulls);
    if (k == 0) level.fit->SetWeights(pulls.MeanWeights());
    PointsX3 next = level.fit->FitPositions(pulls, level.moved, solver_steps);
    move = std::sqrt((next - level.moved).rowwise().squaredNorm().maxCoeff());
    level.moved = std::move(next);
    level.fit->FitMaps(level.moved);
    if (move < still) break;
  }
  return move;
}

/// Restores the exact shape of rigid pieces, then fits the rest to them.
void HoldPieces(Level& level, const Pulls& staying, double landmark_weight) {
  if (level.fit->pieces().empty()) return;
  level.growth = level.fit->StraightenPieces(level.moved);
  const PointsX3 straight = level.moved;
  Pulls pulls = staying;
  AddMarks(level, landmark_weight, pulls);
  for (const std::vector<int>& piece : level.fit->pieces().pieces())
    for (int v : piece) pulls.AddPoint(v, kPinned, straight.row(v));
  level.fit->SetWeights(pulls.MeanWeights());
  level.moved = level.fit->FitPositions(pulls, level.moved, kSolverSteps);
  for (const std::vector<int>& piece : level.fit->pieces().pieces())
    for (int v : piece) level.moved.row(v) = straight.row(v);
  level.fit->FitMaps(level.moved);
}

}  // namespace

void FitToLandmarks(Level& level, double weight) {
  // With point pulls alone the factor is the exact inverse, so one solver step is enough.
  Turn(level, Pulls(level.rest.rows()), weight, kMostLandmarkTurns, 1, kStill);
}

void FitToMatches(Level& level, const PointsX3& match_points, double landmark_weight) {
  double robust = 2;
  for (int round = 0; round < kMatchRounds; ++round) {
    Pulls pulls(level.rest.rows());
    AddMatches(level, match_points, AutoFitTuning::kMatchWeight, robust, pulls);
    robust = round == 0 ? 0.5 : std::max(robust * 0.8, AutoFitTuning::kMatchRobust);
    Turn(level, pulls, landmark_weight, kMatchTurns, 1, 0);
  }
}

SurfaceGap FitToSurface(Level& level, const SurfacePull& target, const PointsX3& match_points,
                        const FitTerms& terms, Eigen::VectorXd* seen) {
  Pulls pulls(level.rest.rows());
  SurfacePullTerms surface;
  surface.weight = AutoFitTuning::kSurfaceWeight / terms.stiffness;
  surface.robust = terms.robust;
  surface.samples = terms.samples;
  surface.measure = terms.measure;
  const SurfaceGap gap = target.Add(level.moved, level.faces, level.rim, level.fit->vertex_areas(),
                                    surface, level.feet, pulls);
  if (seen) {
    // MeanWeights is a third of the trace, so a plane with the full weight gives a third of it.
    // seen is 1/2 at a sixth of the full weight.
    const Eigen::ArrayXd full =
        surface.weight / level.fit->vertex_areas().sum() * level.fit->vertex_areas().array();
    const Eigen::ArrayXd held = pulls.MeanWeights().array();
    *seen = held / (held + full / 6 + 1e-300);
  }
  if (terms.matches > 0)
    AddMatches(level, match_points, terms.matches, AutoFitTuning::kMatchRobust, pulls);
  Turn(level, pulls, terms.landmarks, terms.turns, kSolverSteps, 0);
  HoldPieces(level, pulls, terms.landmarks);
  return gap;
}

}  // namespace keypose::registration
