#include "reconstruct/sfm_matching_stage.h"

#include <algorithm>
#include <numeric>

#include "core/errors.h"
#include "core/parallel.h"
#include "reconstruct/guided_matching.h"
#include "reconstruct/ring_static.h"

namespace keypose::reconstruct {
namespace {

/// The one camera: median focal length of the EXIF data, else COLMAP's guess of 1.2 times the longer side.
Camera StartCamera(const ImageSet& set, bool& focal_known) {
  std::vector<double> focals;
  for (const CapturedImage& image : set.images) {
    if (image.width != set.images[0].width || image.height != set.images[0].height)
      throw InputError("sfm: " + image.name + " is " + std::to_string(image.width) + " x " + std::to_string(image.height) + ", but " +
                       set.images[0].name + " is " + std::to_string(set.images[0].width) + " x " + std::to_string(set.images[0].height) +
                       "; one camera is assumed: run capture again");
    if (image.focal_px > 0) focals.push_back(image.focal_px);
  }
  Camera camera;
  camera.width = set.images[0].width;
  camera.height = set.images[0].height;
  std::sort(focals.begin(), focals.end());
  focal_known = !focals.empty();
  camera.fx = camera.fy = focal_known ? focals[focals.size() / 2] : 1.2 * std::max(camera.width, camera.height);
  camera.cx = camera.width / 2.0;
  camera.cy = camera.height / 2.0;
  return camera;
}

/// Raw matches, but for those on a background that stands still. @param rejected  how many those were
std::vector<PairMatches> MatchPairs(const std::vector<Features>& features, const std::vector<ImagePair>& pairs, int longer_side_px,
                                    const SfmOptions& options, int& rejected, Progress* progress) {
  std::vector<PairMatches> matches(pairs.size());
  std::vector<int> static_matches(pairs.size(), 0);
  MatchOptions matching;
  matching.max_ratio = options.max_ratio;
  ParallelFor(static_cast<std::int64_t>(pairs.size()), [&](std::int64_t k) {
    if (progress && progress->cancelled()) throw Cancelled();
    const auto [i, j] = pairs[static_cast<std::size_t>(k)];
    PairMatches& pair = matches[static_cast<std::size_t>(k)];
    pair.first = i;
    pair.second = j;
    const Features &first = features[static_cast<std::size_t>(i)], &second = features[static_cast<std::size_t>(j)];
    pair.features = MatchDescriptors(first, second, matching);
    static_matches[static_cast<std::size_t>(k)] = RejectStaticMatches(first, second, longer_side_px, pair.features);
  });
  rejected = std::accumulate(static_matches.begin(), static_matches.end(), 0);
  std::erase_if(matches, [](const PairMatches& pair) { return pair.features.empty(); });
  return matches;
}

/// Matches verified pairs once more along their epipolar lines, and keeps what is more. @return inliers gained
int MatchAlongLines(ColmapDatabase& database, const std::vector<Features>& features, int longer_side_px, const SfmOptions& options,
                    Progress* progress) {
  constexpr double kMaxError_px = 4;  // COLMAP's own threshold
  const std::vector<VerifiedPair> pairs = database.VerifiedPairs();
  std::vector<PairMatches> guided(pairs.size());
  MatchOptions matching;
  matching.max_ratio = options.max_ratio;
  ParallelFor(static_cast<std::int64_t>(pairs.size()), [&](std::int64_t k) {
    if (progress && progress->cancelled()) throw Cancelled();
    const VerifiedPair& pair = pairs[static_cast<std::size_t>(k)];
    if (pair.geometry.kind == PairGeometry::kOther) return;
    PairMatches& found = guided[static_cast<std::size_t>(k)];
    found.first = pair.first;
    found.second = pair.second;
    const Features &first = features[static_cast<std::size_t>(pair.first)], &second = features[static_cast<std::size_t>(pair.second)];
    found.features = MatchGuided(first, second, pair.geometry, matching, kMaxError_px);
    RejectStaticMatches(first, second, longer_side_px, found.features);
    if (static_cast<int>(found.features.size()) <= pair.inliers) found.features.clear();
  });
  int gained = 0;
  for (std::size_t k = 0; k < pairs.size(); ++k)
    if (!guided[k].features.empty()) gained += static_cast<int>(guided[k].features.size()) - pairs[k].inliers;
  std::erase_if(guided, [](const PairMatches& pair) { return pair.features.empty(); });
  database.ReplaceInliers(guided);
  return gained;
}

void ReportMatches(StageContext& stage, std::size_t pairs, std::size_t with_matches, const ColmapDatabase& database) {
  int inliers = 0;
  const auto verified = database.VerifiedPairs();
  for (const VerifiedPair& pair : verified) inliers += pair.inliers;
  stage.Report("pairs_tried", static_cast<int>(pairs));
  stage.Report("pairs_matched", static_cast<int>(with_matches));
  stage.Report("pairs_verified", static_cast<int>(verified.size()));
  stage.Report("verified_matches", inliers);
}

}  // namespace

std::vector<std::string> NamesOf(const ImageSet& set) {
  std::vector<std::string> names;
  for (const CapturedImage& image : set.images) names.push_back(image.name);
  return names;
}

Seen BuildDatabase(StageContext& stage, const ImageSet& set, const SfmFiles& files, const SfmOptions& options, Stopwatch& watch) {
  Seen seen;
  seen.camera = StartCamera(set, seen.focal_known);
  const std::vector<std::string> names = NamesOf(set);
  ColmapDatabase::Create(files.database, seen.camera, seen.focal_known, names);
  ExtractFeatures(stage, set, files, options);
  watch.Lap(stage, "features");
  std::vector<Features>& features = seen.features;
  {
    const ColmapDatabase database(files.database);
    for (std::size_t i = 0; i < names.size(); ++i) features.push_back(database.ReadFeatures(static_cast<int>(i)));
  }
  double count = 0;
  for (const Features& f : features) count += f.count();
  stage.Report("mean_features", count / static_cast<double>(features.size()));
  Step(stage.progress(), 0.4, "choosing pairs");
  const auto pairs = ChoosePairs(features, options.PairList(), stage.progress());
  watch.Lap(stage, "pairs");
  Step(stage.progress(), 0.45, "matching");
  const int longer_side_px = std::max(seen.camera.width, seen.camera.height);
  int static_matches = 0;
  seen.matches = MatchPairs(features, pairs, longer_side_px, options, static_matches, stage.progress());
  stage.Report("static_matches_rejected", static_matches);
  if (static_matches > 0)
    stage.Note("warning: " + std::to_string(static_matches) +
               " matches lie on a background that stands still while the object turns; they are left out (better masks would spare them)");
  watch.Lap(stage, "matching");
  Step(stage.progress(), 0.6, "verifying matches");
  std::vector<PairMatches> enough = seen.matches;
  std::erase_if(enough, [&](const PairMatches& pair) { return static_cast<int>(pair.features.size()) < options.min_inliers; });
  VerifyMatches(stage, files, enough, options);
  watch.Lap(stage, "verification");
  ColmapDatabase database(files.database);
  if (options.guided_matching) {
    Step(stage.progress(), 0.65, "matching along epipolar lines");
    stage.Report("guided_gain", MatchAlongLines(database, features, longer_side_px, options, stage.progress()));
    watch.Lap(stage, "guided_matching");
  }
  ReportMatches(stage, pairs.size(), enough.size(), database);
  return seen;
}

}  // namespace keypose::reconstruct
