#include "reconstruct/sfm/surroundings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "core/io/pictures/image_set.h"
#include "core/numbers/statistics.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "reconstruct/matching/static_matches.h"
#include "reconstruct/matching/verification.h"
#include "reconstruct/sfm/set_lenses.h"
#include "reconstruct/surroundings/likely_figure.h"

namespace keypose::reconstruct {
namespace fs = std::filesystem;

namespace {

/// Chosen on the plush figure on a book, the pot on a mat, the plush dog and the skull.
struct SurroundingsTuning {
  KEYPOSE_TUNED(int, kPairs, 4);  ///< pairs of neighbours that are looked at
  /// of the longer side: places so far outside of the mask are not the figure's
  KEYPOSE_TUNED(double, kOutside, 0.03);
  /// matches outside of the masks, on the median of these pairs
  KEYPOSE_TUNED(int, kFewest, 10);
  KEYPOSE_TUNED(double, kEnough, 0.9);      ///< share of the photographs
  KEYPOSE_TUNED(double, kNearlyAll, 0.98);  ///< likewise
};

/// Photographs in pairs of neighbours, spread over the set.
ImageSet Probes(const ImageSet& set) {
  ImageSet probes;
  probes.folder = set.folder;
  constexpr std::size_t pairs = SurroundingsTuning::kPairs;
  std::size_t next = 0;
  for (std::size_t k = 0; k < pairs; ++k) {
    const std::size_t i = std::max(next, k * set.images.size() / pairs);
    if (i + 1 >= set.images.size()) break;
    probes.images.push_back(set.images[i]);
    probes.images.push_back(set.images[i + 1]);
    next = i + 2;
  }
  return probes;
}

/// Which features lie outside of a mask by more than the margin; all where there is none.
std::vector<char> Outside(const Features& features, const CapturedImage& image,
                          const Image8& mask) {
  const Eigen::VectorXf away = DistanceToMask(features, image.width, mask);
  const auto margin =
      static_cast<float>(SurroundingsTuning::kOutside * std::max(image.width, image.height));
  std::vector<char> outside(static_cast<std::size_t>(features.count()));
  for (std::size_t f = 0; f < outside.size(); ++f)
    outside[f] = away(static_cast<Eigen::Index>(f)) > margin;
  return outside;
}

int OutsideMatches(const Features& first, const Features& second,
                   const std::vector<char>& outside_a, const std::vector<char>& outside_b,
                   int longer_side_px, const SfmOptions& options) {
  MatchOptions matching;
  matching.max_ratio = options.max_ratio;
  PairMatches pair{0, 1, MatchDescriptors(first, second, matching)};
  RejectStaticMatches(first, second, longer_side_px, pair.features);
  std::erase_if(pair.features, [&](const auto& match) {
    return !outside_a[match.first] || !outside_b[match.second];
  });
  const auto verified = VerifyPair(first, second, pair, VerificationOptions{});
  return verified ? SizeOf(verified->inliers.features) : 0;
}

}  // namespace

bool HasSurroundings(const StrategyContext& context, const fs::path& scratch) {
  const auto& [stage, set, options, check, watch] = context;
  const ImageSet probes = Probes(set);
  if (probes.images.size() < 4) return false;
  const SetLenses lenses = LensesOf(probes);
  const SfmFiles files{scratch, set.folder, scratch / "probes.db"};
  ColmapDatabase::Create(files.database, lenses.cameras, lenses.focal_known, NamesOf(probes),
                         lenses.of_image);
  ExtractFeatures(stage, probes, files, options, {.whole = true});
  const ColmapDatabase database(files.database);
  std::vector<int> counts;
  for (std::size_t k = 0; k + 1 < probes.images.size(); k += 2) {
    Features features[2];
    std::vector<char> outside[2];
    int longer_side_px = 0;
    for (std::size_t side = 0; side < 2; ++side) {
      const CapturedImage& image = probes.images[k + side];
      features[side] = database.ReadFeatures(static_cast<int>(k + side));
      outside[side] = Outside(features[side], image, check.masks()[set.Find(image.name)]);
      longer_side_px = std::max({longer_side_px, image.width, image.height});
    }
    counts.push_back(
        OutsideMatches(features[0], features[1], outside[0], outside[1], longer_side_px, options));
  }
  const int usual = UpperMedian(std::move(counts));
  stage.Report("surroundings_matches", usual);
  watch.Lap(stage, "surroundings_probe");
  return usual >= SurroundingsTuning::kFewest;
}

bool IsEnough(const StrategyContext& context, const StrategyResult& result) {
  return IsSure(result.evidence) &&
         static_cast<double>(result.views()) >=
             SurroundingsTuning::kEnough * static_cast<double>(context.set.images.size());
}

bool HasNearlyAll(const StrategyContext& context, const StrategyResult& result) {
  return IsSure(result.evidence) &&
         static_cast<double>(result.views()) >=
             SurroundingsTuning::kNearlyAll * static_cast<double>(context.set.images.size());
}

void MeasureSurroundings(const EvidenceCheck& check, const MatchedFeatures& matched,
                         StrategyResult& result) {
  double on = 0, around = 0;
  std::vector<Eigen::VectorXf> away;
  for (std::size_t i = 0; i < matched.features.size(); ++i) {
    const Camera& lens = matched.lenses[static_cast<std::size_t>(matched.lens_of_image[i])];
    away.push_back(DistanceToMask(matched.features[i], lens.width, check.masks()[i]));
  }
  for (const PairMatches& pair : matched.verified)
    for (const auto& [f, s] : pair.features) {
      const bool figure = away[pair.first](f) <= 0 && away[pair.second](s) <= 0;
      (figure ? on : around) += 1;
    }
  Measurements& measurements = result.measurements;
  measurements.Add("matches_on_masks", on);
  measurements.Add("matches_around", around);
  measurements.Add("lenses", SizeOf(matched.lenses));
  const std::string what = on >= around ? "the figure and what stands still with it"
                                        : "what stands still with the figure, and the figure";
  measurements.Add("cameras_from",
                   matched.turning.empty()
                       ? what + "; what moves otherwise (a wall behind, the table) was left out"
                       : what);
}

Similarity3 LevelBySupport(const SupportPlane& support, const std::vector<View>& views) {
  const Eigen::Vector3d up = support.normal;
  // The first camera is in direction -y.
  Eigen::Vector3d back = support.foot - views.front().Center();
  back -= up * up.dot(back);
  if (back.norm() < 1e-9) back = up.unitOrthogonal();
  back.normalize();
  Similarity3 level;
  level.scale = 1 / support.distance;
  level.rotation.row(0) = back.cross(up);
  level.rotation.row(1) = back;
  level.rotation.row(2) = up;
  level.translation = -level.scale * (level.rotation * support.foot);
  return level;
}

}  // namespace keypose::reconstruct
