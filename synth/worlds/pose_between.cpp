#include "synth/worlds/pose_between.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace keypose::synth {
namespace {

/// Whether two deformations move the same part in the same way, by angles or ratios of their own.
bool SameJoint(const Deformation& a, const Deformation& b) {
  return a.kind == b.kind && a.origin == b.origin && a.axis == b.axis && a.hinge == b.hinge &&
         a.begin == b.begin && a.end == b.end && a.center == b.center && a.radius == b.radius;
}

Deformation Faded(Deformation step, double share) {
  step.angle *= share;
  step.ratio = 1 + share * (step.ratio - 1);
  return step;
}

Deformation Mixed(const Deformation& a, const Deformation& b, double share) {
  Deformation mixed = a;
  mixed.angle += share * (b.angle - a.angle);
  mixed.ratio += share * (b.ratio - a.ratio);
  return mixed;
}

/// Index of the same joint's deformation in `steps`; -1: none.
int TwinOf(const Deformation& step, const std::vector<Deformation>& steps) {
  const auto twin = std::find_if(steps.begin(), steps.end(),
                                 [&](const Deformation& other) { return SameJoint(step, other); });
  return twin == steps.end() ? -1 : static_cast<int>(twin - steps.begin());
}

bool SameOrder(const Pose& a, const Pose& b) {
  int last = -1;
  for (const Deformation& step : a.steps) {
    const int twin = TwinOf(step, b.steps);
    if (twin < 0) continue;
    if (twin < last) return false;
    last = twin;
  }
  return true;
}

}  // namespace

Pose PoseBetween(const Pose& a, const Pose& b, double share) {
  if (share <= 0) return a;
  if (share >= 1) return b;
  Pose between{a.name + "-" + b.name, {}, a.touches || b.touches};
  if (!SameOrder(a, b)) {
    const Pose& near = share < 0.5 ? a : b;
    for (const Deformation& step : near.steps)
      between.steps.push_back(Faded(step, std::abs(2 * share - 1)));
    return between;
  }
  // Merged in the order of both: what only b has comes before the next step that both have.
  std::size_t next = 0;
  for (const Deformation& step : a.steps) {
    const int twin = TwinOf(step, b.steps);
    for (; twin >= 0 && next < static_cast<std::size_t>(twin); ++next)
      between.steps.push_back(Faded(b.steps[next], share));
    between.steps.push_back(twin < 0 ? Faded(step, 1 - share) : Mixed(step, b.steps[twin], share));
    if (twin >= 0) ++next;
  }
  for (; next < b.steps.size(); ++next) between.steps.push_back(Faded(b.steps[next], share));
  return between;
}

}  // namespace keypose::synth
