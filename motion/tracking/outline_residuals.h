// How far the template's silhouette is from an actor's outline in one view, in both directions.
#pragma once

#include <vector>

#include "core/values/tuned.h"
#include "motion/tracking/body_outline.h"

namespace keypose::motion {

/// Found on the generated performance with seeds 101 and 102 and on the dome.
struct OutlineTuning {
  /// a residual counts less the larger it is, and not at all beyond this [px] (Tukey)
  KEYPOSE_TUNED(double, kReach, 10);
  /// length of the outline over which errors of a mask are alike [px]
  KEYPOSE_TUNED(double, kAlike, 4);
  /// least cosine between the normals of the template's silhouette and of the outline
  KEYPOSE_TUNED(double, kAgreement, 0.4);
};

/// One view of one pose: contour samples, and the outline points that pull at them.
struct ViewMatches {
  struct Pull {
    int sample = 0;
    Eigen::Vector2d target, normal;  ///< of the outline point; both normals' mean, unit
  };
  std::vector<OutlineSample> samples;
  std::vector<Pull> pulls;
  int unexplained = 0;  ///< outline points without a sample within reach
};
/// @param reach  [px]
ViewMatches FindMatches(const Silhouette& silhouette, const LocalSurface& surface,
                        const PosedBody& body, double reach);

/// Tukey's weight: 1 at zero, 0 beyond the reach.
inline double TukeyWeight(double residual, double reach) {
  const double t = residual / reach;
  if (t * t >= 1) return 0;
  return (1 - t * t) * (1 - t * t);
}
/// Tukey's loss; its limit is reach^2 / 6.
inline double TukeyLoss(double residual, double reach) {
  const double t = residual / reach, rest = 1 - t * t;
  return rest <= 0 ? reach * reach / 6 : reach * reach / 6 * (1 - rest * rest * rest);
}

/// One residual at a point of the template: d(residual) = pull^T d(x).
struct OutlineResidual {
  const OutlineSample* sample = nullptr;
  Eigen::Vector3d x;      ///< in world
  Eigen::Vector3d pull;   ///< [px/m]
  double value = 0;       ///< [px]
  double stands_for = 0;  ///< length of outline over kAlike: how many independent measurements
};

/// Calls visit(OutlineResidual) for each residual of a view, with its samples moved by `body`.
/// The contours stay on the surface where they were: to first order a contour that slides along the
/// surface does not move in the picture (recipes M.13).
template <class Visit>
void VisitResiduals(const Silhouette& silhouette, const ViewMatches& matches, const PosedBody& body,
                    Visit&& visit) {
  std::vector<Eigen::Vector3d> world(matches.samples.size());
  for (std::size_t i = 0; i < matches.samples.size(); ++i) {
    const OutlineSample& sample = matches.samples[i];
    OutlineResidual residual;
    residual.sample = &sample;
    residual.x = world[i] = body.ToWorld(Segments()[sample.segment].joint, sample.local);
    const Eigen::Vector2d pixel = silhouette.Project(residual.x);
    if (silhouette.Cut(pixel)) continue;
    Eigen::Vector2d gradient;
    residual.value = silhouette.Distance(pixel, &gradient);
    const double size = gradient.norm();
    // On a ridge between two outlines the distance has no direction.
    if (size < 0.3 || gradient.dot(sample.normal) < OutlineTuning::kAgreement * size) continue;
    residual.pull = silhouette.Pull(residual.x, gradient);
    residual.stands_for = sample.length / OutlineTuning::kAlike;
    visit(residual);
  }
  for (const ViewMatches::Pull& pull : matches.pulls) {
    OutlineResidual residual;
    residual.sample = &matches.samples[pull.sample];
    residual.x = world[pull.sample];
    residual.value = pull.normal.dot(silhouette.Project(residual.x) - pull.target);
    residual.pull = silhouette.Pull(residual.x, pull.normal);
    residual.stands_for = silhouette.outline_step / OutlineTuning::kAlike;
    visit(residual);
  }
}

}  // namespace keypose::motion
