// The side file of a pose's photographs, shoot.json; docs/shoot.md has its fields.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "capture/shoot/develop/photograph.h"
#include "capture/shoot/record/shot_plan.h"

namespace keypose::capture::shoot {

/// What is wrong with a photograph or a ring, for the person.
struct Finding {
  std::string code;  ///< as in docs/shoot.md
  std::string words, what_to_do;
  bool operator==(const Finding&) const = default;
};

struct PhotographEntry {
  Shot shot;
  std::string file, raw;  ///< names in the folder; `raw` beside a JPEG, else empty
  std::int64_t time = 0;  ///< seconds since 1970
  bool readable = true;
  int width = 0, height = 0;
  ExposureSettings settings;
  double crispness = 0;      ///< of the figure, in [0, 1]
  double sharpness = 0;      ///< variance of its Laplacian [grey levels^2]
  double exposure = 0;       ///< mean luma of the figure, 0..255
  double light = 0;          ///< mean linear luma of the set round the figure, in [0, 1]
  double clipped = 0;        ///< share of the figure's pixels at the ends
  double mask_fraction = 0;  ///< share of the picture that is figure
  bool touches_border = false;
  std::vector<Finding> findings;
};

struct RingEntry {
  int flip = 0, ring = 1;
  std::optional<double> moved_px;  ///< nothing if the check was skipped
  std::vector<double> missing_deg;
  std::vector<Finding> findings;
};

struct CarriedWhite {
  std::array<double, 3> gains = {1, 1, 1};
  std::string from;  ///< the card's photograph and place
};

struct SideFile {
  std::string pose;
  ShotPlan plan;
  std::string camera, turntable;
  std::optional<CarriedWhite> white;
  std::map<Shot, PhotographEntry> photographs;
  std::vector<RingEntry> rings;  ///< those that are complete, in order
  std::set<Shot> skipped;

  const RingEntry* FindRing(int flip, int ring) const;
};

std::string SideFileText(const SideFile& side);
/// @param where  the file's path, for messages
/// @throws InputError  not a side file, or damaged
SideFile ParseSideFile(const std::string& text, const std::string& where);

nlohmann::json PlanJson(const ShotPlan& plan);
nlohmann::json EntryJson(const ShotPlan& plan, const PhotographEntry& entry);
nlohmann::json RingJson(const RingEntry& ring);
nlohmann::json FindingsJson(const std::vector<Finding>& findings);

/// A number as the file keeps it. What is judged is rounded first: a verdict must not depend on
/// whether the number was read back from there.
double Decimal(double value, int digits);

/// "2024-05-03T14:03:22Z".
std::string TimeText(std::int64_t seconds);

}  // namespace keypose::capture::shoot
