#include "composite/locating/refinement/refine.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/size_of.h"

namespace keypose::composite {
namespace {

constexpr double kDamping = 1e-4, kLongestTurn = 0.25;  // rad
constexpr double kLongestLensStep = 0.05;               // of the logarithm, and of k1

double ReachOf(const RefineStep& step, int round) {
  if (step.rounds < 2) return step.last_reach_px;
  const double t = static_cast<double>(round) / (step.rounds - 1);
  return step.reach_px * std::pow(step.last_reach_px / step.reach_px, t);
}

Terms TermsOf(const RefineStep& step, int round) {
  return {ReachOf(step, round), step.texture, step.edges};
}

Step Limited(Step step) {
  const double longest = step.head<6>().norm();
  if (longest > kLongestTurn) step *= kLongestTurn / longest;
  return step;
}

/// The whole picture's camera with the lens that was found at another size.
Placement AtWholeSize(const Placement& whole, const Placement& scaled, double start_focal) {
  Placement result{whole.camera, scaled.camera_from_mesh};
  const double factor = scaled.camera.fx / start_focal;
  result.camera.fx *= factor, result.camera.fy *= factor;
  result.camera.k1 = scaled.camera.k1;
  return result;
}

/// The lens's step from the sum of all frames' parts.
Eigen::Vector2d LensStep(Eigen::Matrix2d h, Eigen::Vector2d g, const LensPrior& lens) {
  const std::array<bool, 2> free{lens.focal_free, lens.k1_free};
  for (int i = 0; i < 2; ++i)
    if (!free[i]) h.row(i).setZero(), h.col(i).setZero(), h(i, i) = 1, g[i] = 0;
  const Eigen::Vector2d step = h.ldlt().solve(g);
  return step.allFinite() ? step : Eigen::Vector2d::Zero();
}

/// @return the misfit when each frame's place is refined at this focal length
double CostAt(const std::vector<SharedFrame>& frames, double focal_px, double reach_px,
              double* count) {
  double cost = 0;
  LensPrior fixed;
  if (count) *count = 0;
  for (const SharedFrame& frame : frames) {
    Placement at = WithFocal(frame.at, focal_px, frame.figure->center);
    at = Refined(*frame.figure, *frame.evidence, at, {reach_px, reach_px, 5}, fixed);
    const Misfit misfit =
        MisfitOf(*frame.figure, *frame.evidence, at.Scaled(frame.evidence->scale), reach_px);
    cost += misfit.cost;
    if (count) *count += misfit.count;
  }
  return cost;
}

}  // namespace

LensPart Eliminated(const NormalEquations& equations) {
  const StepMatrix& m = equations.matrix();
  const Step g = equations.gradient();
  Eigen::Matrix<double, 6, 6> p = m.topLeftCorner<6, 6>();
  p.diagonal() *= 1 + kDamping;
  p.diagonal().array() += 1e-12 * p.trace();
  const auto solver = p.ldlt();
  const Eigen::Matrix<double, 6, 2> cross = m.block<6, 2>(0, kLogFocal);
  LensPart part;
  part.place_by_lens = solver.solve(cross);
  part.place = solver.solve(g.head<6>());
  part.h = m.block<2, 2>(kLogFocal, kLogFocal) - cross.transpose() * part.place_by_lens;
  part.g = g.segment<2>(kLogFocal) - cross.transpose() * part.place;
  return part;
}

Placement WithFocal(const Placement& at, double focal_px, const Eigen::Vector3d& center) {
  Placement result = at;
  const double factor = focal_px / at.camera.fx;
  result.camera.fx *= factor, result.camera.fy *= factor;
  const Eigen::Vector3d c = at.camera_from_mesh * center;
  result.camera_from_mesh.translation.z() += (factor - 1) * c.z();
  return result;
}

Placement Refined(const Figure& figure, const Evidence& evidence, const Placement& at,
                  const RefineStep& step, const LensPrior& lens) {
  Placement scaled = at.Scaled(evidence.scale);
  const double start_focal = scaled.camera.fx;
  for (int round = 0; round < step.rounds; ++round) {
    NormalEquations equations = EquationsOf(figure, evidence, scaled, TermsOf(step, round));
    AddLensPrior(equations, lens, evidence.scale);
    const Step move =
        Limited(equations.Solve(FreeUnknowns(lens.focal_free, lens.k1_free), kDamping));
    scaled = equations.Moved(move);
    if (move.norm() < 1e-8) break;
  }
  return AtWholeSize(at, scaled, start_focal);
}

void RefineShared(std::vector<SharedFrame>& frames, const RefineStep& step, const LensPrior& lens) {
  for (int round = 0; round < step.rounds; ++round) {
    std::vector<NormalEquations> equations;
    std::vector<LensPart> parts;
    Eigen::Matrix2d h = Eigen::Matrix2d::Zero();
    Eigen::Vector2d g = Eigen::Vector2d::Zero();
    for (SharedFrame& frame : frames) {
      NormalEquations of_frame =
          EquationsOf(*frame.figure, *frame.evidence, frame.at.Scaled(frame.evidence->scale),
                      TermsOf(step, round));
      if (equations.empty()) AddLensPrior(of_frame, lens, frame.evidence->scale);
      equations.push_back(of_frame);
      parts.push_back(Eliminated(of_frame));
      h += parts.back().h, g += parts.back().g;
    }
    const Eigen::Vector2d lens_step = LensStep(h, g, lens);
    std::vector<Step> moves(frames.size());
    double factor = std::min(1.0, kLongestLensStep / std::max(lens_step.norm(), 1e-300));
    for (int i = 0; i < SizeOf(frames); ++i) {
      moves[i].setZero();
      moves[i].head<6>() = parts[i].place - parts[i].place_by_lens * lens_step;
      moves[i].segment<2>(kLogFocal) = lens_step;
      factor = std::min(factor, kLongestTurn / std::max(moves[i].head<6>().norm(), 1e-300));
    }
    // One factor for all, or the frames would end with different lenses.
    for (int i = 0; i < SizeOf(frames); ++i) {
      const double start = equations[i].at().camera.fx;
      frames[i].at = AtWholeSize(frames[i].at, equations[i].Moved(factor * moves[i]), start);
    }
  }
  for (SharedFrame& frame : frames) frame.at.camera = frames[0].at.camera;
}

Placement RefinedStill(const std::vector<SharedFrame>& frames, const Placement& at,
                       const RefineStep& step, const LensPrior& lens) {
  Placement result = at;
  const Figure& first = *frames[0].figure;
  for (int round = 0; round < step.rounds; ++round) {
    const Placement scaled = result.Scaled(frames[0].evidence->scale);
    NormalEquations sum(scaled, first.center, first.radius);
    for (const SharedFrame& frame : frames)
      sum.Add(EquationsOf(*frame.figure, *frame.evidence, scaled, TermsOf(step, round),
                          first.center, first.radius));
    AddLensPrior(sum, lens, frames[0].evidence->scale);
    const Step move = Limited(sum.Solve(FreeUnknowns(lens.focal_free, lens.k1_free), kDamping));
    result = AtWholeSize(result, sum.Moved(move), scaled.camera.fx);
    if (move.norm() < 1e-8) break;
  }
  return result;
}

double CenterDeviation(const std::vector<SharedFrame>& frames, const RefineStep& step,
                       const LensPrior& lens) {
  // The lens's four unknowns, with each frame's place solved for them.
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (const SharedFrame& frame : frames) {
    NormalEquations equations =
        EquationsOf(*frame.figure, *frame.evidence, frame.at.Scaled(frame.evidence->scale),
                    TermsOf(step, step.rounds - 1));
    if (&frame == &frames.front()) AddLensPrior(equations, lens, frame.evidence->scale);
    const StepMatrix& m = equations.matrix();
    const Eigen::Matrix<double, 6, 4> cross = m.block<6, 4>(0, kLogFocal);
    const Eigen::Matrix<double, 6, 6> place = m.topLeftCorner<6, 6>();
    sum += m.block<4, 4>(kLogFocal, kLogFocal) -
           cross.transpose() * place.completeOrthogonalDecomposition().solve(cross);
  }
  std::vector<int> free{2, 3};
  if (lens.focal_free) free.push_back(0);
  if (lens.k1_free) free.push_back(1);
  Eigen::MatrixXd known = sum(free, free);
  // Columns are scaled to one: a focal length's logarithm moves pixels a thousand times as much.
  const Eigen::VectorXd scale = known.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  known = (scale.asDiagonal() * known * scale.asDiagonal()).eval();
  const Eigen::MatrixXd covariance =
      known.ldlt().solve(Eigen::MatrixXd::Identity(known.rows(), known.cols()));
  const double x = scale[0] * scale[0] * covariance(0, 0),
               y = scale[1] * scale[1] * covariance(1, 1);
  if (!(x > 0 && y > 0)) return std::numeric_limits<double>::infinity();
  return std::sqrt(std::max(x, y)) / frames.front().evidence->scale;
}

double FocalByOffset(const std::vector<SharedFrame>& frames, const RefineStep& step,
                     const LensPrior& lens) {
  Eigen::Matrix2d h = Eigen::Matrix2d::Zero();
  Eigen::Vector2d g = Eigen::Vector2d::Zero();
  Terms terms = TermsOf(step, step.rounds - 1);
  for (const SharedFrame& frame : frames) {
    const Placement at = frame.at.Scaled(frame.evidence->scale);
    terms.offset_px = 0;
    NormalEquations as_is = EquationsOf(*frame.figure, *frame.evidence, at, terms);
    terms.offset_px = 1;
    const NormalEquations farther = EquationsOf(*frame.figure, *frame.evidence, at, terms);
    g += Eliminated(farther).g - Eliminated(as_is).g;
    if (&frame == &frames.front()) AddLensPrior(as_is, lens, frame.evidence->scale);
    h += Eliminated(as_is).h;
  }
  return LensStep(h, g, lens)[0];
}

FocalProfile ProfileFocal(std::vector<SharedFrame> frames, double reach_px) {
  constexpr std::array<double, 11> kSteps{-0.7, -0.4, -0.2, -0.1, -0.04, 0,
                                          0.04, 0.1,  0.2,  0.4,  0.7};
  const double start = frames[0].at.camera.fx;
  std::array<double, kSteps.size()> costs;
  double count = 0;
  for (int i = 0; i < SizeOf(kSteps); ++i)
    costs[i] = CostAt(frames, start * std::exp(kSteps[i]), reach_px, &count);
  const int best = static_cast<int>(std::min_element(costs.begin(), costs.end()) - costs.begin());
  // What the model cannot explain is counted as noise.
  const double variance = std::max(1.0, costs[best] / std::max(1.0, count));
  FocalProfile profile{start * std::exp(kSteps[best]), 1};
  const auto side = [&](int direction) {
    for (int i = best + direction; i >= 0 && i < SizeOf(kSteps); i += direction) {
      const double rise = (costs[i] - costs[best]) / variance;
      // Near its minimum the curve is a parabola, whose width a value beyond it gives.
      if (rise > 1) return std::abs(kSteps[i] - kSteps[best]) / std::sqrt(rise);
    }
    return 1.0;
  };
  profile.deviation = std::min(1.0, std::max(side(-1), side(1)));
  return profile;
}

}  // namespace keypose::composite
