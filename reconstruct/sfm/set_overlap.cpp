#include "reconstruct/sfm/set_overlap.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/io/pictures/image_set.h"
#include "core/pictures/joined_images.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "reconstruct/turntable/upside_down.h"

namespace keypose::reconstruct {
namespace {

/// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct OverlapTuning {
  KEYPOSE_TUNED(int, kStrong, 60);  ///< matches of a pair with a large overlap
};

/// "a.jpg, b.jpg, c.jpg"; only the first ones of many.
std::string Names(const ImageSet& set, const std::vector<int>& images) {
  constexpr std::size_t kMost = 8;
  std::string names;
  for (std::size_t k = 0; k < std::min(kMost, images.size()); ++k)
    names += (k == 0 ? "" : ", ") + set.images[images[k]].name;
  if (images.size() > kMost) names += " and " + std::to_string(images.size() - kMost) + " more";
  return names;
}

}  // namespace

void RequireOverlap(StageContext& stage, const ImageSet& set, const MatchedFeatures& matched) {
  const int images = SizeOf(set.images);
  std::vector<ImageTie> ties;
  for (const PairMatches& pair : matched.verified)
    ties.push_back({pair.first, pair.second, SizeOf(pair.features)});
  const auto groups = JoinedImages(images, ties);
  stage.Report("joined_groups", SizeOf(groups));
  stage.Report("largest_group", static_cast<int>(groups.at(0).size()));
  if (!FallsApart(images, ties, OverlapTuning::kStrong)) return;
  throw InputError(
      "sfm: the photographs are too far apart: each matches a few others, but the " +
      std::to_string(images) + " of them fall into " + std::to_string(groups.size()) +
      " groups that share no features, the largest being " + Names(set, groups[0]) +
      ". More photographs from the same sides do not help: turn the table by 15 degrees at most "
      "from one photograph to the "
      "next (24 for a turn), and raise the camera by 20 degrees at most between rings");
}

std::vector<char> FindUpsideDown(StageContext& stage, const ImageSet& set,
                                 const EvidenceCheck& check, const MatchedFeatures& matched) {
  const int images = SizeOf(set.images);
  const std::vector<int> found = UpsideDownByOutlines(
      UpsideDownByMatches(images, PointsOf(matched.verified, matched.features)), check.masks());
  std::vector<char> upside_down(found.size(), 0);
  std::vector<int> members;
  nlohmann::json names = nlohmann::json::array();
  for (int i = 0; i < images; ++i) {
    if (found[i] != 1) continue;
    upside_down[i] = 1;
    members.push_back(i);
    names.push_back(set.images[i].name);
  }
  stage.ReportJson("upside_down", names.dump());
  if (!members.empty())
    stage.Note(
        "sfm: these photographs are upside down relative to the others, which is allowed for: " +
        Names(set, members));
  return upside_down;
}

}  // namespace keypose::reconstruct
