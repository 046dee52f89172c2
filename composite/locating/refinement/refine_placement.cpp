#include "composite/locating/refinement/refine_placement.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

constexpr double kDamping = 1e-4, kLongestTurn = 0.25;  // rad
constexpr double kLongestLensStep = 0.05;               // of the logarithm, and of k1

double ReachOf(const RefineStep& step, int round) {
  if (step.rounds < 2) return step.last_reach_px;
  const double t = static_cast<double>(round) / (step.rounds - 1);
  return step.reach_px * std::pow(step.last_reach_px / step.reach_px, t);
}

Terms TermsOf(const RefineStep& step, int round, double scale) {
  return {ReachOf(step, round), step.texture, step.edges, step.matte_offset_px * scale};
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
  result.camera.fx *= factor;
  result.camera.fy *= factor;
  result.camera.k1 = scaled.camera.k1;
  return result;
}

/// The equations of one of several frames with one lens; the first has the lens's prior.
NormalEquations EquationsAmong(const std::vector<SharedFrame>& frames, const SharedFrame& frame,
                               const RefineStep& step, int round, const LensPrior& lens) {
  const double scale = frame.evidence->scale;
  NormalEquations equations = EquationsOf(*frame.figure, *frame.evidence, frame.at.Scaled(scale),
                                          TermsOf(step, round, scale));
  if (&frame == &frames.front()) AddLensPrior(equations, lens, scale, step.matte_offset_px * scale);
  return equations;
}

/// The step of what all frames share, from the sum of their parts.
Eigen::Vector3d LensStep(Eigen::Matrix3d h, Eigen::Vector3d g, const LensPrior& lens) {
  const std::array<bool, 3> free{lens.focal_free, lens.k1_free, lens.matte_offset_deviation > 0};
  for (int i = 0; i < 3; ++i)
    if (!free[i]) {
      h.row(i).setZero();
      h.col(i).setZero();
      h(i, i) = 1;
      g[i] = 0;
    }
  const Eigen::Vector3d step = h.ldlt().solve(g);
  return step.allFinite() ? step : Eigen::Vector3d::Zero();
}

/// @return the misfit when each frame's place is refined at this focal length
double CostAt(const std::vector<SharedFrame>& frames, double focal_px, double reach_px,
              double matte_offset_px, double* count) {
  double cost = 0;
  LensPrior fixed;
  if (count) *count = 0;
  for (const SharedFrame& frame : frames) {
    Placement at = WithFocal(frame.at, focal_px, frame.figure->center);
    at = Refined(*frame.figure, *frame.evidence, at,
                 {reach_px, reach_px, 5, nullptr, false, matte_offset_px}, fixed);
    const double scale = frame.evidence->scale;
    const Misfit misfit = MisfitOf(*frame.figure, *frame.evidence, at.Scaled(scale), reach_px,
                                   matte_offset_px * scale);
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
  const Eigen::Matrix<double, 6, 3> cross = m.block<6, 3>(0, kLogFocal);
  LensPart part;
  part.place_by_lens = solver.solve(cross);
  part.place = solver.solve(g.head<6>());
  part.h = m.block<3, 3>(kLogFocal, kLogFocal) - cross.transpose() * part.place_by_lens;
  part.g = g.segment<3>(kLogFocal) - cross.transpose() * part.place;
  return part;
}

Placement WithFocal(const Placement& at, double focal_px, const Eigen::Vector3d& center) {
  Placement result = at;
  const double factor = focal_px / at.camera.fx;
  result.camera.fx *= factor;
  result.camera.fy *= factor;
  const Eigen::Vector3d c = at.camera_from_mesh * center;
  result.camera_from_mesh.translation.z() += (factor - 1) * c.z();
  return result;
}

Placement Refined(const Figure& figure, const PictureEvidence& evidence, const Placement& at,
                  const RefineStep& step, const LensPrior& lens) {
  Placement scaled = at.Scaled(evidence.scale);
  const double start_focal = scaled.camera.fx;
  for (int round = 0; round < step.rounds; ++round) {
    NormalEquations equations =
        EquationsOf(figure, evidence, scaled, TermsOf(step, round, evidence.scale));
    AddLensPrior(equations, lens, evidence.scale);
    const Step move =
        Limited(equations.Solve(FreeUnknowns(lens.focal_free, lens.k1_free), kDamping));
    scaled = equations.Moved(move);
    if (move.norm() < 1e-8) break;
  }
  return AtWholeSize(at, scaled, start_focal);
}

double RefineShared(std::vector<SharedFrame>& frames, const RefineStep& step,
                    const LensPrior& lens) {
  RefineStep now = step;
  const double first_scale = frames.front().evidence->scale;
  for (int round = 0; round < step.rounds; ++round) {
    std::vector<NormalEquations> equations;
    std::vector<LensPart> parts;
    Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (SharedFrame& frame : frames) {
      equations.push_back(EquationsAmong(frames, frame, now, round, lens));
      parts.push_back(Eliminated(equations.back()));
      h += parts.back().h;
      g += parts.back().g;
    }
    const Eigen::Vector3d lens_step = LensStep(h, g, lens);
    std::vector<Step> moves(frames.size());
    double factor = std::min(1.0, kLongestLensStep / std::max(lens_step.head<2>().norm(), 1e-300));
    for (int i = 0; i < SizeOf(frames); ++i) {
      moves[i].setZero();
      moves[i].head<6>() = parts[i].place - parts[i].place_by_lens * lens_step;
      moves[i].segment<2>(kLogFocal) = lens_step.head<2>();
      factor = std::min(factor, kLongestTurn / std::max(moves[i].head<6>().norm(), 1e-300));
    }
    // One factor for all, or the frames would end with different lenses.
    for (int i = 0; i < SizeOf(frames); ++i) {
      const double start = equations[i].at().camera.fx;
      frames[i].at = AtWholeSize(frames[i].at, equations[i].Moved(factor * moves[i]), start);
    }
    now.matte_offset_px += factor * lens_step[2] / first_scale;
  }
  for (SharedFrame& frame : frames) frame.at.camera = frames[0].at.camera;
  return now.matte_offset_px;
}

Placement RefinedStill(const std::vector<SharedFrame>& frames, const Placement& at,
                       const RefineStep& step, const LensPrior& lens) {
  Placement result = at;
  const Figure& first = *frames[0].figure;
  for (int round = 0; round < step.rounds; ++round) {
    const Placement scaled = result.Scaled(frames[0].evidence->scale);
    NormalEquations sum(scaled, first.center, first.radius);
    for (const SharedFrame& frame : frames)
      sum.Add(EquationsOf(*frame.figure, *frame.evidence, scaled,
                          TermsOf(step, round, frame.evidence->scale), first.center, first.radius));
    AddLensPrior(sum, lens, frames[0].evidence->scale);
    const Step move = Limited(sum.Solve(FreeUnknowns(lens.focal_free, lens.k1_free), kDamping));
    result = AtWholeSize(result, sum.Moved(move), scaled.camera.fx);
    if (move.norm() < 1e-8) break;
  }
  return result;
}

double CenterDeviation(const std::vector<SharedFrame>& frames, const RefineStep& step,
                       const LensPrior& lens) {
  // What all frames share, five unknowns, with each frame's place solved for them.
  using Shared = Eigen::Matrix<double, 5, 5>;
  Shared sum = Shared::Zero();
  for (const SharedFrame& frame : frames) {
    const NormalEquations equations = EquationsAmong(frames, frame, step, step.rounds - 1, lens);
    const StepMatrix& m = equations.matrix();
    const Eigen::Matrix<double, 6, 5> cross = m.block<6, 5>(0, kLogFocal);
    const Eigen::Matrix<double, 6, 6> place = m.topLeftCorner<6, 6>();
    sum += m.block<5, 5>(kLogFocal, kLogFocal) -
           cross.transpose() * place.completeOrthogonalDecomposition().solve(cross);
  }
  std::vector<int> free{kCenterX - kLogFocal, kCenterY - kLogFocal};
  if (lens.focal_free) free.push_back(0);
  if (lens.k1_free) free.push_back(kK1 - kLogFocal);
  if (lens.matte_offset_deviation > 0) free.push_back(kMatteOffset - kLogFocal);
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

double FocalDeviationByOffset(const std::vector<SharedFrame>& frames, const RefineStep& step,
                              const LensPrior& lens) {
  Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
  for (const SharedFrame& frame : frames) {
    h += Eliminated(EquationsAmong(frames, frame, step, step.rounds - 1, lens)).h;
  }
  LensPrior known = lens;
  known.matte_offset_deviation = 0;
  // By how much focal length and k1 follow the offset, and what is known of it when they do.
  const Eigen::Vector3d follows = LensStep(h, h.col(2), known);
  const double known_of_it = h(2, 2) - h.col(2).head<2>().dot(follows.head<2>());
  return known_of_it > 0 ? std::abs(follows[0]) / std::sqrt(known_of_it) : 0;
}

FocalProfile ProfileFocal(std::vector<SharedFrame> frames, double reach_px,
                          double matte_offset_px) {
  constexpr std::array<double, 11> kSteps{-0.7, -0.4, -0.2, -0.1, -0.04, 0,
                                          0.04, 0.1,  0.2,  0.4,  0.7};
  const double start = frames[0].at.camera.fx;
  std::array<double, kSteps.size()> costs;
  double count = 0;
  for (int i = 0; i < SizeOf(kSteps); ++i)
    costs[i] = CostAt(frames, start * std::exp(kSteps[i]), reach_px, matte_offset_px, &count);
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
