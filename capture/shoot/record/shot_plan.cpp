#include "capture/shoot/record/shot_plan.h"

#include <cmath>
#include <cstdio>

namespace keypose::capture::shoot {

std::vector<std::string> ShotPlan::Problems() const {
  std::vector<std::string> problems;
  const auto must = [&](bool fine, const std::string& sentence) {
    if (!fine) problems.push_back(sentence);
  };
  must(!rings_deg.empty() && rings_deg.size() <= 9,
       "--rings must name 1 to 9 elevations, such as 12,40");
  for (const double ring : rings_deg)
    must(ring >= -30 && ring <= 90,
         "--rings must be degrees between -30 and 90, but one is " + DegreesText(ring));
  must(angles >= 3 && angles <= 360, "--angles must be 3 to 360, but is " + std::to_string(angles));
  must(flips >= 0 && flips <= 3, "--flips must be 0 to 3, but is " + std::to_string(flips));
  must(focus_stack >= 1 && focus_stack <= 50,
       "--focus-stack must be 1 to 50, but is " + std::to_string(focus_stack));
  return problems;
}

std::vector<Shot> AllShots(const ShotPlan& plan) {
  std::vector<Shot> shots;
  for (int flip = 0; flip <= plan.flips; ++flip)
    for (std::size_t ring = 1; ring <= plan.rings_deg.size(); ++ring)
      for (int index = 0; index < plan.angles; ++index)
        shots.push_back({flip, static_cast<int>(ring), index});
  return shots;
}

double AngleOf(const ShotPlan& plan, const Shot& shot) { return 360.0 * shot.index / plan.angles; }

double TiltOf(const ShotPlan& plan, const Shot& shot) { return plan.rings_deg.at(shot.ring - 1); }

std::string NameOf(const ShotPlan& plan, const Shot& shot) {
  std::string lying;
  if (shot.flip == 1) lying = "lying_";
  if (shot.flip > 1) lying = "lying" + std::to_string(shot.flip) + "_";
  char place[32];
  std::snprintf(place, sizeof place, "r%d_a%03ld", shot.ring, std::lround(AngleOf(plan, shot)));
  return lying + place;
}

std::optional<Shot> ShotNamed(const ShotPlan& plan, const std::string& name) {
  for (const Shot& shot : AllShots(plan))
    if (NameOf(plan, shot) == name) return shot;
  return std::nullopt;
}

std::optional<Shot> ShotAt(const ShotPlan& plan, int flip, int ring, double angle_deg) {
  const bool there = flip >= 0 && flip <= plan.flips && ring >= 1 &&
                     ring <= static_cast<int>(plan.rings_deg.size());
  if (!there || !std::isfinite(angle_deg) || std::abs(angle_deg) > 1e6) return std::nullopt;
  const double step_deg = 360.0 / plan.angles;
  const double steps = angle_deg / step_deg;
  if (std::abs(steps - std::round(steps)) * step_deg > 0.5) return std::nullopt;
  const long index = std::lround(steps) % plan.angles;
  return Shot{flip, ring, static_cast<int>(index < 0 ? index + plan.angles : index)};
}

std::string DegreesText(double angle_deg) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", angle_deg);
  std::string short_text = text;
  while (short_text.back() == '0') short_text.pop_back();
  if (short_text.back() == '.') short_text.pop_back();
  return short_text;
}

}  // namespace keypose::capture::shoot
