#include "reconstruct/sfm/matched_features.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <optional>

#include "core/io/pictures/image_set.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "reconstruct/matching/flat_pairs.h"
#include "reconstruct/matching/guided_matching.h"
#include "reconstruct/matching/rotation_cycles.h"
#include "reconstruct/matching/static_matches.h"
#include "reconstruct/matching/verification.h"
#include "reconstruct/sfm/set_lenses.h"

namespace keypose::reconstruct {
namespace {

/// Raw matches, also those on a static background.
std::vector<PairMatches> MatchPairs(const std::vector<Features>& features,
                                    const std::vector<ImagePair>& pairs, const SfmOptions& options,
                                    Progress* progress) {
  std::vector<PairMatches> matches(pairs.size());
  MatchOptions matching;
  matching.max_ratio = options.max_ratio;
  ParallelFor(std::ssize(pairs), [&](std::int64_t k) {
    if (progress && progress->cancelled()) throw Cancelled();
    const auto [i, j] = pairs[k];
    matches[k] = {i, j, MatchDescriptors(features[i], features[j], matching)};
  });
  return matches;
}

bool IsAmong(const std::vector<ImagePair>& pairs, const PairMatches& pair) {
  return std::binary_search(pairs.begin(), pairs.end(), ImagePair(pair.first, pair.second));
}

/// Leaves out matches on a static background.
/// @param tripod_pairs  sorted pairs that are known to be before one tripod
/// @return number of those
int LeaveOutStatic(const std::vector<Features>& features, int longer_side_px,
                   const std::vector<ImagePair>& tripod_pairs, PairMatches& pair) {
  const Features &first = features[pair.first], &second = features[pair.second];
  if (IsAmong(tripod_pairs, pair))
    return LeaveOutNearlyInPlace(first, second, longer_side_px, {}, pair);
  return RejectStaticMatches(first, second, longer_side_px, pair.features);
}

int LeaveOutStatic(int longer_side_px, MatchedFeatures& matched) {
  std::vector<int> rejected(matched.matches.size(), 0);
  ParallelFor(std::ssize(matched.matches), [&](std::int64_t k) {
    rejected[k] =
        LeaveOutStatic(matched.features, longer_side_px, matched.tripod_pairs, matched.matches[k]);
  });
  return std::accumulate(rejected.begin(), rejected.end(), 0);
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
int MatchAlongLines(std::vector<Verified>& pairs, const MatchedFeatures& matched,
                    int longer_side_px, const SfmOptions& options, Progress* progress) {
  std::vector<int> gained(pairs.size(), 0);
  MatchOptions matching;
  matching.max_ratio = options.max_ratio;
  ParallelFor(std::ssize(pairs), [&](std::int64_t k) {
    if (progress && progress->cancelled()) throw Cancelled();
    Verified& pair = pairs[k];
    const auto& [first, second, inliers] = pair.inliers;
    PairMatches found{first, second,
                      MatchGuided(matched.features[first], matched.features[second], pair.geometry,
                                  matching, VerificationOptions{}.max_error_px)};
    LeaveOutStatic(matched.features, longer_side_px, matched.tripod_pairs, found);
    if (found.features.size() <= inliers.size()) return;
    gained[k] = static_cast<int>(found.features.size() - inliers.size());
    pair.inliers.features = std::move(found.features);
  });
  return std::accumulate(gained.begin(), gained.end(), 0);
}

void ReportMatches(StageContext& stage, std::size_t with_matches,
                   const std::vector<Verified>& verified) {
  std::size_t inliers = 0;
  for (const Verified& pair : verified) inliers += pair.inliers.features.size();
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

/// Leaves out pairs that match by what repeats itself. Before matching along epipolar lines, as
/// those of such pairs collect wrong matches.
void LeaveOutRepeated(StageContext& stage, const MatchedFeatures& matched, int longer_side_px,
                      const SfmOptions& options, std::vector<Verified>& verified) {
  const double pixels = options.PixelsOf(longer_side_px);
  const std::vector<char> flat = FlatPairs(matched.features, {}, pixels, verified);
  stage.Report("flat_pairs", static_cast<int>(std::count(flat.begin(), flat.end(), 1)));
  stage.Report(
      "contradicted_pairs",
      LeaveOutContradictedTurns(matched.features, LensOfEach(matched), flat,
                                pixels * VerificationOptions{}.max_error_px, {}, verified));
}

/// Verifies matches, and adds those along epipolar lines if asked.
std::vector<Verified> VerifyAll(StageContext& stage, const MatchedFeatures& matched,
                                const std::vector<PairMatches>& enough, int longer_side_px,
                                const SfmOptions& options, bool without_repeated,
                                Stopwatch& watch) {
  std::vector<Verified> verified = VerifyPairs(matched.features, enough, options, stage.progress());
  if (without_repeated) LeaveOutRepeated(stage, matched, longer_side_px, options, verified);
  watch.Lap(stage, "verification");
  if (!options.guided_matching) return verified;
  ReportProgress(stage.progress(), 0.65, "matching along epipolar lines");
  stage.Report("guided_gain",
               MatchAlongLines(verified, matched, longer_side_px, options, stage.progress()));
  watch.Lap(stage, "guided_matching");
  return verified;
}

}  // namespace

std::vector<std::string> NamesOf(const ImageSet& set) {
  std::vector<std::string> names;
  for (const CapturedImage& image : set.images) names.push_back(image.name);
  return names;
}

std::vector<Camera> LensOfEach(const MatchedFeatures& matched) {
  std::vector<Camera> lens;
  for (const int l : matched.lens_of_image) lens.push_back(matched.lenses[l]);
  return lens;
}

namespace {

/// The lenses, in the database and in the result.
MatchedFeatures WithLenses(const ImageSet& set, const SfmFiles& files) {
  SetLenses lenses = LensesOf(set);
  ColmapDatabase::Create(files.database, lenses.cameras, lenses.focal_known, NamesOf(set),
                         lenses.of_image);
  MatchedFeatures matched;
  matched.camera = lenses.cameras.front();
  matched.focal_known = lenses.focal_known;
  matched.lenses = std::move(lenses.cameras);
  matched.lens_of_image = std::move(lenses.of_image);
  return matched;
}

int LongerSide(const std::vector<Camera>& lenses) {
  int longer_side_px = 0;
  for (const Camera& lens : lenses)
    longer_side_px = std::max({longer_side_px, lens.width, lens.height});
  return longer_side_px;
}

/// Matches of chosen pairs without those that stay in place.
void MatchChosen(StageContext& stage, const SfmOptions& options, const FeatureKind& kind,
                 Stopwatch& watch, MatchedFeatures& matched) {
  const std::vector<Features>& features = matched.features;
  const int longer_side_px = LongerSide(matched.lenses);
  ReportProgress(stage.progress(), 0.4, "selecting pairs");
  const auto pairs = ChoosePairs(features, options.PairList(), stage.progress());
  watch.Lap(stage, "pairs");
  ReportProgress(stage.progress(), 0.45, "matching");
  matched.matches = MatchPairs(features, pairs, options, stage.progress());
  watch.Lap(stage, "matching");
  if (kind.whole)
    matched.turning =
        TurnsBeforeTripod(features, matched.matches, longer_side_px, {}, &matched.tripod_pairs);
  const int static_matches = LeaveOutStatic(longer_side_px, matched);
  std::erase_if(matched.matches, [](const PairMatches& pair) { return pair.features.empty(); });
  stage.Report("static_matches_rejected", static_matches);
  if (static_matches > 0 && !matched.in_room)
    stage.Warn(std::to_string(static_matches) +
               " matches lie on a background that does not move while the object turns; they are "
               "left out (better masks would avoid them)");
  stage.Report("pairs_tried", SizeOf(pairs));
}

}  // namespace

MatchedFeatures MatchPhotographs(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                                 const SfmOptions& options, const FeatureKind& kind,
                                 Stopwatch& watch, std::vector<ImagePair> tripod_pairs) {
  MatchedFeatures matched = WithLenses(set, files);
  matched.tripod_pairs = std::move(tripod_pairs);
  matched.in_room = kind.whole || kind.region;
  ExtractFeatures(stage, set, files, options, kind);
  watch.Lap(stage, "features");
  matched.features = ReadAllFeatures(stage, files.database, set.images.size());
  MatchChosen(stage, options, kind, watch, matched);
  matched.upside_down.assign(set.images.size(), 0);
  return matched;
}

void VerifyMatches(StageContext& stage, const SfmFiles& files, const SfmOptions& options,
                   bool without_repeated, Stopwatch& watch, MatchedFeatures& matched) {
  const auto few = [&](const PairMatches& pair) {
    return SizeOf(pair.features) < options.min_inliers;
  };
  ReportProgress(stage.progress(), 0.6, "verifying matches");
  std::vector<PairMatches> enough = matched.matches;
  std::erase_if(enough, few);
  std::vector<Verified> verified = VerifyAll(stage, matched, enough, LongerSide(matched.lenses),
                                             options, without_repeated, watch);
  ReportMatches(stage, enough.size(), verified);
  std::vector<PairMatches> inliers;
  for (Verified& pair : verified) inliers.push_back(std::move(pair.inliers));
  ReplaceVerified(std::move(inliers), files, matched);
}

void ReplaceVerified(std::vector<PairMatches> verified, const SfmFiles& files,
                     MatchedFeatures& matched) {
  std::vector<PairMatches> gone = std::move(matched.verified);
  for (PairMatches& pair : gone) pair.features.clear();
  ColmapDatabase database(files.database);
  database.PutInliers(gone);
  database.PutInliers(verified);
  matched.verified = std::move(verified);
}

MatchedFeatures BuildDatabase(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                              const SfmOptions& options, const FeatureKind& kind, Stopwatch& watch,
                              std::vector<ImagePair> tripod_pairs) {
  MatchedFeatures matched =
      MatchPhotographs(stage, set, files, options, kind, watch, std::move(tripod_pairs));
  VerifyMatches(stage, files, options, kind.region, watch, matched);
  return matched;
}

}  // namespace keypose::reconstruct
