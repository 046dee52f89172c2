#include "reconstruct/sfm/matched_features.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <optional>

#include "core/errors.h"
#include "core/io/image_set.h"
#include "core/parallel.h"
#include "core/size_of.h"
#include "reconstruct/matching/guided_matching.h"
#include "reconstruct/matching/static_matches.h"
#include "reconstruct/matching/verification.h"

namespace keypose::reconstruct {
namespace {

/// The shared camera: median focal length of the EXIF data, else COLMAP's default of 1.2 times the
/// longer side.
Camera StartCamera(const ImageSet& set, bool& focal_known) {
  std::vector<double> focals;
  for (const CapturedImage& image : set.images) {
    if (image.width != set.images[0].width || image.height != set.images[0].height)
      throw InputError("sfm: " + image.name + " is " + std::to_string(image.width) + " x " +
                       std::to_string(image.height) + ", but " + set.images[0].name + " is " +
                       std::to_string(set.images[0].width) + " x " +
                       std::to_string(set.images[0].height) +
                       "; one camera is assumed: run capture again");
    if (image.focal_px > 0) focals.push_back(image.focal_px);
  }
  Camera camera;
  camera.width = set.images[0].width;
  camera.height = set.images[0].height;
  std::sort(focals.begin(), focals.end());
  focal_known = !focals.empty();
  camera.fx = camera.fy =
      focal_known ? focals[focals.size() / 2] : 1.2 * std::max(camera.width, camera.height);
  camera.cx = camera.width / 2.0;
  camera.cy = camera.height / 2.0;
  return camera;
}

/// Raw matches without those on a static background.
/// @param rejected  number of those
std::vector<PairMatches> MatchPairs(const std::vector<Features>& features,
                                    const std::vector<ImagePair>& pairs, int longer_side_px,
                                    const SfmOptions& options, int& rejected, Progress* progress) {
  std::vector<PairMatches> matches(pairs.size());
  std::vector<int> static_matches(pairs.size(), 0);
  MatchOptions matching;
  matching.max_ratio = options.max_ratio;
  ParallelFor(std::ssize(pairs), [&](std::int64_t k) {
    if (progress && progress->cancelled()) throw Cancelled();
    const auto [i, j] = pairs[k];
    PairMatches& pair = matches[k];
    pair.first = i;
    pair.second = j;
    const Features &first = features[i], &second = features[j];
    pair.features = MatchDescriptors(first, second, matching);
    static_matches[k] = RejectStaticMatches(first, second, longer_side_px, pair.features);
  });
  rejected = std::accumulate(static_matches.begin(), static_matches.end(), 0);
  std::erase_if(matches, [](const PairMatches& pair) { return pair.features.empty(); });
  return matches;
}

/// The pairs whose matches fit one rigid scene, in the pairs' order.
std::vector<Verified> VerifyPairs(const std::vector<Features>& features,
                                  const std::vector<PairMatches>& matches,
                                  const SfmOptions& options, Progress* progress) {
  std::vector<std::optional<Verified>> tested(matches.size());
  VerificationOptions verification;
  verification.min_inliers = options.min_inliers;
  ParallelFor(std::ssize(matches), [&](std::int64_t k) {
    if (progress && progress->cancelled()) throw Cancelled();
    const PairMatches& pair = matches[k];
    tested[k] = VerifyPair(features[pair.first], features[pair.second], pair, verification);
  });
  std::vector<Verified> verified;
  for (std::optional<Verified>& pair : tested)
    if (pair) verified.push_back(std::move(*pair));
  return verified;
}

/// Matches verified pairs again along their epipolar lines, and keeps the result where it has more
/// matches.
/// @return number of additional inliers
int MatchAlongLines(std::vector<Verified>& pairs, const std::vector<Features>& features,
                    int longer_side_px, const SfmOptions& options, Progress* progress) {
  std::vector<int> gained(pairs.size(), 0);
  MatchOptions matching;
  matching.max_ratio = options.max_ratio;
  ParallelFor(std::ssize(pairs), [&](std::int64_t k) {
    if (progress && progress->cancelled()) throw Cancelled();
    Verified& pair = pairs[k];
    const Features &first = features[pair.inliers.first], &second = features[pair.inliers.second];
    auto found =
        MatchGuided(first, second, pair.geometry, matching, VerificationOptions{}.max_error_px);
    RejectStaticMatches(first, second, longer_side_px, found);
    if (found.size() <= pair.inliers.features.size()) return;
    gained[k] = static_cast<int>(found.size() - pair.inliers.features.size());
    pair.inliers.features = std::move(found);
  });
  return std::accumulate(gained.begin(), gained.end(), 0);
}

void ReportMatches(StageContext& stage, std::size_t pairs, std::size_t with_matches,
                   const std::vector<Verified>& verified) {
  std::size_t inliers = 0;
  for (const Verified& pair : verified) inliers += pair.inliers.features.size();
  stage.Report("pairs_tried", static_cast<int>(pairs));
  stage.Report("pairs_matched", static_cast<int>(with_matches));
  stage.Report("pairs_verified", SizeOf(verified));
  stage.Report("verified_matches", static_cast<int>(inliers));
}

std::vector<Features> ReadAllFeatures(StageContext& stage, const std::filesystem::path& file,
                                      std::size_t images) {
  std::vector<Features> features;
  const ColmapDatabase database(file);
  for (std::size_t i = 0; i < images; ++i)
    features.push_back(database.ReadFeatures(static_cast<int>(i)));
  double count = 0;
  for (const Features& f : features) count += f.count();
  stage.Report("mean_features", count / static_cast<double>(features.size()));
  return features;
}

/// Verifies matches, and adds those along epipolar lines if asked.
std::vector<Verified> VerifyAll(StageContext& stage, const std::vector<Features>& features,
                                const std::vector<PairMatches>& enough, int longer_side_px,
                                const SfmOptions& options, Stopwatch& watch) {
  std::vector<Verified> verified = VerifyPairs(features, enough, options, stage.progress());
  watch.Lap(stage, "verification");
  if (!options.guided_matching) return verified;
  ReportProgress(stage.progress(), 0.65, "matching along epipolar lines");
  stage.Report("guided_gain",
               MatchAlongLines(verified, features, longer_side_px, options, stage.progress()));
  watch.Lap(stage, "guided_matching");
  return verified;
}

}  // namespace

std::vector<std::string> NamesOf(const ImageSet& set) {
  std::vector<std::string> names;
  for (const CapturedImage& image : set.images) names.push_back(image.name);
  return names;
}

MatchedFeatures BuildDatabase(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                              const SfmOptions& options, bool fine, Stopwatch& watch) {
  MatchedFeatures matched;
  matched.camera = StartCamera(set, matched.focal_known);
  const std::vector<std::string> names = NamesOf(set);
  ColmapDatabase::Create(files.database, matched.camera, matched.focal_known, names);
  ExtractFeatures(stage, set, files, options, fine);
  watch.Lap(stage, "features");
  matched.features = ReadAllFeatures(stage, files.database, names.size());
  const std::vector<Features>& features = matched.features;
  ReportProgress(stage.progress(), 0.4, "selecting pairs");
  const auto pairs = ChoosePairs(features, options.PairList(), stage.progress());
  watch.Lap(stage, "pairs");
  ReportProgress(stage.progress(), 0.45, "matching");
  const int longer_side_px = std::max(matched.camera.width, matched.camera.height);
  int static_matches = 0;
  matched.matches =
      MatchPairs(features, pairs, longer_side_px, options, static_matches, stage.progress());
  stage.Report("static_matches_rejected", static_matches);
  if (static_matches > 0)
    stage.Warn(std::to_string(static_matches) +
               " matches lie on a background that does not move while the object turns; they are "
               "left out (better masks would avoid them)");
  watch.Lap(stage, "matching");
  ReportProgress(stage.progress(), 0.6, "verifying matches");
  std::vector<PairMatches> enough = matched.matches;
  std::erase_if(
      enough, [&](const PairMatches& pair) { return SizeOf(pair.features) < options.min_inliers; });
  std::vector<Verified> verified =
      VerifyAll(stage, features, enough, longer_side_px, options, watch);
  ReportMatches(stage, pairs.size(), enough.size(), verified);
  for (Verified& pair : verified) matched.verified.push_back(std::move(pair.inliers));
  ColmapDatabase(files.database).PutInliers(matched.verified);
  matched.upside_down.assign(names.size(), 0);
  return matched;
}

}  // namespace keypose::reconstruct
