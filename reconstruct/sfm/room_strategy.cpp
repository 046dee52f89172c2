#include "reconstruct/sfm/room_strategy.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/pictures/png_io.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "reconstruct/matching/verification.h"
#include "reconstruct/sfm/print_check.h"
#include "reconstruct/sfm/surroundings.h"
#include "reconstruct/surroundings/likely_figure.h"
#include "reconstruct/surroundings/turning_cameras.h"

namespace keypose::reconstruct {
namespace fs = std::filesystem;

namespace {

/// Chosen on generated rooms with a turning mat (seeds 12 to 14), the plush figure on a book and
/// the pot on a mat.
struct RoomStrategyTuning {
  KEYPOSE_TUNED(int, kTripodPairs, 3);  ///< fewer may be photographs that were taken twice
  /// features of a photograph that move otherwise, and the share of photographs with as many, for a
  /// second motion to be looked for
  KEYPOSE_TUNED(int, kOthers, 30);
  KEYPOSE_TUNED(double, kShareWithOthers, 0.4);
  KEYPOSE_TUNED(double, kShareOfOther, 0.5);  ///< of the photographs, that a second motion places
  KEYPOSE_TUNED(double, kTurnsMore, 1.5);     ///< times the other's mean turn
  KEYPOSE_TUNED(double, kLikelier, 1.2);      ///< times the other's likely figure
  /// mean turn [radians] of cameras that hardly go round anything; of what turns with the figure
  /// it is more, but where a mat matched itself
  KEYPOSE_TUNED(double, kHardlyTurns, 0.25);
  KEYPOSE_TUNED(double, kTurns, 0.5);
  /// mean turn of cameras that go round what they look at: no other motion can turn clearly more
  KEYPOSE_TUNED(double, kGoesRound, 0.9);
  /// for each photograph, pairs that what moves otherwise ties, with so many matches
  KEYPOSE_TUNED(double, kPairsOfOther, 1);
  KEYPOSE_TUNED(int, kMatchesOfOther, 20);
  KEYPOSE_TUNED(int, kPrintRounds, 3);  ///< of placing again what the print shows to be turned
};

double Degrees(double radians) { return 180 / 3.14159265358979 * radians; }

struct Room {
  const StrategyContext& context;
  const fs::path& scratch;
  const PlaceByFiles& place;

  SfmFiles Files(const std::string& name) const {
    return {scratch, context.set.folder, scratch / (name + ".db")};
  }
};

/// A placement and what it was made of.
struct Placed {
  StrategyResult result;
  MatchedFeatures matched;
};

/// The set with regions in place of its masks; photographs without a region have none.
ImageSet WithRegions(const Room& room, const std::vector<Image8>& regions,
                     const std::string& name) {
  ImageSet set = room.context.set;
  const fs::path folder = room.scratch / name;
  fs::create_directories(folder);
  ParallelFor(std::ssize(set.images), [&](std::int64_t i) {
    CapturedImage& image = set.images[i];
    image.mask.clear();
    const Image8& region = regions[i];
    if (region.empty() || *std::max_element(region.data.begin(), region.data.end()) == 0) return;
    const Image8 mask = ResizedMask(region, image.width, image.height);
    const fs::path file = fs::absolute(folder / (std::to_string(i) + ".png"));
    WriteGreyMaskPng(file, mask);
    image.mask = file.string();
  });
  return set;
}

double MeanShare(const std::vector<Image8>& regions) {
  double sum = 0;
  for (const Image8& region : regions)
    sum += region.empty()
               ? 1
               : static_cast<double>(std::count(region.data.begin(), region.data.end(), 255)) /
                     static_cast<double>(region.data.size());
  return regions.empty() ? 1 : sum / static_cast<double>(regions.size());
}

void NotePlaced(const Room& room, const std::string& name, const StrategyResult& result) {
  const CameraEvidence& evidence = result.evidence;
  room.context.stage.Note("sfm: features of '" + name + "' place " +
                          std::to_string(result.views()) + " of " +
                          std::to_string(room.context.set.images.size()) + ", which turn by " +
                          std::to_string(std::lround(Degrees(MeanTurn(result.model.scene.views)))) +
                          " degrees in the mean; " + std::to_string(evidence.pairs_agree) + " of " +
                          std::to_string(evidence.pairs) + " pairs agree");
}

Placed Place(const Room& room, const ImageSet& set, const std::string& name,
             const FeatureKind& kind, const std::vector<ImagePair>& tripod_pairs) {
  const auto& [stage, all, options, check, watch] = room.context;
  const SfmFiles files = room.Files(name);
  Placed placed;
  placed.matched = BuildDatabase(stage, set, files, options, kind, watch, tripod_pairs);
  placed.result = room.place(files, placed.matched);
  watch.Lap(stage, "surroundings");
  NotePlaced(room, name, placed.result);
  return placed;
}

/// Places again the cameras that the print under the figure shows to be turned, and such as it
/// gives to photographs without one; what stays turned is left out.
/// @return whether there is a print that agrees with them now
bool PlaceByPrint(const Room& room, const PrintPictures& pictures, const std::string& name,
                  Placed& placed) {
  const auto& [stage, set, options, check, watch] = room.context;
  std::size_t with_guests = 0;  // views when guests last came in
  for (int round = 0; round <= RoomStrategyTuning::kPrintRounds; ++round) {
    const std::size_t views = placed.result.views();
    const PrintCheck print =
        CheckPrint(room.context, pictures, placed.result.model.scene, placed.matched);
    placed.result.measurements.Add("print_known", print.known);
    placed.result.measurements.Add("print_turned", print.turned);
    watch.Lap(stage, "print");
    const bool helps = print.guests > 0 && round < RoomStrategyTuning::kPrintRounds &&
                       (with_guests == 0 || views > with_guests);
    if (print.turned == 0 && !helps) return 2 * print.known > static_cast<int>(views);
    stage.Note("sfm: the print under the figure is turned in " + std::to_string(print.turned) +
               " of " + std::to_string(views) + " photographs, and places " +
               std::to_string(print.guests) + " more");
    const std::vector<PairMatches> verified = placed.matched.verified;
    if (round < RoomStrategyTuning::kPrintRounds)
      KeepMatchesOf(room.context, print.scene, room.Files(name), placed.matched);
    else
      ForgetMatchesOf(print.is_turned, room.Files(name), placed.matched);
    if (print.guests > 0) with_guests = views;
    StrategyResult before =
        std::exchange(placed.result, room.place(room.Files(name), placed.matched));
    watch.Lap(stage, "surroundings");
    NotePlaced(room, name, placed.result);
    // A cloth's pattern repeats itself and says wrong turns: then fewer pairs agree than before.
    const CameraEvidence &now = placed.result.evidence, &was = before.evidence;
    if (IsSure(was) && now.pairs_agree < was.pairs_agree &&
        now.pairs_agree_share() <= was.pairs_agree_share()) {
      placed.result = std::move(before);
      ReplaceVerified(verified, room.Files(name), placed.matched);
      return false;
    }
  }
  return false;
}

bool Turns(const StrategyResult& result) {
  return MeanTurn(result.model.scene.views) > RoomStrategyTuning::kTurns;
}

/// Places again by the matches that fit cameras over the print that turns before the tripods: it
/// needs hardly any, where others misled the mapper or were too few for it. Where photographs from
/// the hand contradict that, they come after, by the print.
/// @return whether that is better; then the print agrees
bool PlaceByTurningPrint(const Room& room, const PrintPictures& pictures, const std::string& name,
                         Placed& placed) {
  const auto& [stage, set, options, check, watch] = room.context;
  const auto turning =
      CamerasOverTurningPrint({NamesOf(set), LensOfEach(placed.matched), placed.matched.features,
                               placed.matched.matches, placed.matched.tripod_pairs},
                              pictures.photographs, pictures.regions);
  watch.Lap(stage, "print");
  if (!turning || turning->scene.views.size() < 3) return false;
  stage.Note("sfm: a plane turns before " + std::to_string(turning->tripods) +
             " tripods; its print tells the turns of " +
             std::to_string(turning->scene.views.size()) + " of " +
             std::to_string(set.images.size()) + " photographs");
  Placed other = placed;
  const auto place = [&] {
    other.result = room.place(room.Files(name), other.matched);
    watch.Lap(stage, "surroundings");
    NotePlaced(room, name, other.result);
  };
  KeepMatchesOf(room.context, turning->scene, room.Files(name), other.matched);
  place();
  if (!IsEnough(room.context, other.result)) {
    std::vector<char> by_hand(set.images.size(), 1);
    for (const View& view : turning->scene.views) by_hand[set.Find(view.name)] = 0;
    ForgetMatchesOf(by_hand, room.Files(name), other.matched);
    place();
  }
  if (!Turns(other.result) || !PlaceByPrint(room, pictures, name, other)) return false;
  if (Turns(placed.result) && !IsBetter(other.result.evidence, placed.result.evidence))
    return false;
  other.result.measurements.Add("started_by_print", true);
  placed = std::move(other);
  return true;
}

void KeepBetter(Placed other, Placed& best) {
  if (best.result.views() == 0 || IsBetter(other.result.evidence, best.result.evidence))
    best = std::move(other);
}

/// By the regions; again with more features where those leave photographs out.
Placed PlaceRegions(const Room& room, const std::vector<Image8>& regions, const std::string& name,
                    const std::vector<ImagePair>& tripod_pairs) {
  const ImageSet set = WithRegions(room, regions, name);
  Placed best = Place(room, set, name, {.region = true, .on_table = true}, tripod_pairs);
  const PrintPictures pictures = PicturesForPrint(room.context.set, regions);
  bool agrees = PlaceByPrint(room, pictures, name, best);
  if (!tripod_pairs.empty() && !(agrees && HasNearlyAll(room.context, best.result)))
    agrees |= PlaceByTurningPrint(room, pictures, name, best);
  // More features cost minutes, and where the print agrees they have placed no photograph more.
  const bool placed =
      agrees ? IsEnough(room.context, best.result) : HasNearlyAll(room.context, best.result);
  if (!placed || !Turns(best.result)) {
    Placed fine = Place(room, set, name + "_fine", {.fine = true, .region = true, .on_table = true},
                        tripod_pairs);
    PlaceByPrint(room, pictures, name + "_fine", fine);
    if (!Turns(best.result))
      best = std::move(fine);
    else
      KeepBetter(std::move(fine), best);
  }
  best.result.measurements.Add("region_share", MeanShare(regions));
  return best;
}

/// What does not fit the cameras of a placement.
struct Others {
  std::vector<Image8> regions;  ///< empty where that is little
  bool likelier = false;        ///< it is more likely the figure than what fits
};

/// How likely features are on the figure by where people aim; masks of a room are doubtful.
Eigen::VectorXf NearMiddle(const Features& features, const CapturedImage& image) {
  return LikelyOnFigure(features, image.width, image.height, {});
}

/// Whether features with positive votes are more likely on the figure than those with negative
/// ones, in the mean.
bool AreLikelier(const Room& room, const std::vector<Features>& features,
                 const MotionVotes& votes) {
  const ImageSet& set = room.context.set;
  double sum[2] = {0, 0}, count[2] = {0, 0};
  for (std::size_t i = 0; i < votes.size(); ++i) {
    const Eigen::VectorXf likely = NearMiddle(features[i], set.images[i]);
    for (std::size_t f = 0; f < votes[i].size(); ++f) {
      if (votes[i][f] == 0) continue;
      sum[votes[i][f] > 0] += static_cast<double>(likely(static_cast<Eigen::Index>(f)));
      ++count[votes[i][f] > 0];
    }
  }
  return count[1] > 0 && sum[1] * count[0] > sum[0] * count[1];
}

/// Pairs of photographs that features with positive votes tie rigidly: wrong matches fit no cameras
/// either.
int TiedPairs(const MatchedFeatures& matched, const MotionVotes& votes) {
  VerificationOptions options;
  options.min_inliers = RoomStrategyTuning::kMatchesOfOther;
  std::vector<char> tied(matched.matches.size(), 0);
  ParallelFor(std::ssize(matched.matches), [&](std::int64_t k) {
    PairMatches pair = matched.matches[k];
    std::erase_if(pair.features, [&](const auto& match) {
      return votes[pair.first][match.first] <= 0 || votes[pair.second][match.second] <= 0;
    });
    tied[k] = VerifyPair(matched.features[pair.first], matched.features[pair.second], pair, options)
                  .has_value();
  });
  return static_cast<int>(std::count(tied.begin(), tied.end(), 1));
}

Others FindOthers(const Room& room, const Placed& first) {
  const StrategyContext& context = room.context;
  const MatchedFeatures& matched = first.matched;
  const MotionSegmentationOptions options;
  const Scene& scene = first.result.model.scene;
  const MotionVotes votes =
      MovesOtherwise(matched.features, matched.matches, scene, context.check.ViewOfImage(scene),
                     options, context.stage.progress());
  const std::vector<Camera> lens = LensOfEach(matched);
  Others others{MotionRegions(matched.features, votes, lens, options), false};
  const std::vector<int> counts = CountInRegions(matched.features, votes, lens, others.regions);
  const auto with_others = std::count_if(
      counts.begin(), counts.end(), [](int count) { return count >= RoomStrategyTuning::kOthers; });
  const int tied = TiedPairs(matched, votes);
  context.stage.Report("photographs_with_other_motion", static_cast<int>(with_others));
  context.stage.Report("pairs_in_other_motion", tied);
  const auto images = static_cast<double>(counts.size());
  if (static_cast<double>(with_others) < RoomStrategyTuning::kShareWithOthers * images ||
      tied < RoomStrategyTuning::kPairsOfOther * images)
    others.regions.clear();
  else
    others.likelier = AreLikelier(room, matched.features, votes);
  return others;
}

/// How likely the verified matches are on the figure, in the mean.
double LikelyFigure(const Room& room, const MatchedFeatures& matched) {
  const ImageSet& set = room.context.set;
  double sum = 0, count = 0;
  std::vector<Eigen::VectorXf> likely;
  for (std::size_t i = 0; i < set.images.size(); ++i)
    likely.push_back(NearMiddle(matched.features[i], set.images[i]));
  for (const PairMatches& pair : matched.verified)
    for (const auto& [f, s] : pair.features) {
      sum += std::min(likely[pair.first](f), likely[pair.second](s));
      ++count;
    }
  return count > 0 ? sum / count : 0;
}

/// Whether the figure follows the second placement, not the first.
bool IsOfFigure(const Room& room, const Placed& second, const Placed& first) {
  const std::size_t views = second.result.views();
  if (views < 3 || !IsSure(second.result.evidence) || !Turns(second.result) ||
      static_cast<double>(views) <
          RoomStrategyTuning::kShareOfOther * static_cast<double>(room.context.set.images.size()))
    return false;
  // Where the first fits its own matches badly, it is of nothing that stands still.
  if (!IsSure(first.result.evidence)) return true;
  const double turn = MeanTurn(second.result.model.scene.views),
               other = MeanTurn(first.result.model.scene.views);
  if (turn > RoomStrategyTuning::kTurnsMore * other) return true;
  if (other > RoomStrategyTuning::kTurnsMore * turn) return false;
  return LikelyFigure(room, second.matched) >
         RoomStrategyTuning::kLikelier * LikelyFigure(room, first.matched);
}

/// Where what does not repeat itself confirms the cameras, those pairs count again that agree with
/// them: on a print most are right.
void TakeBackAgreeing(const Room& room, const std::vector<PairMatches>& before,
                      const SfmFiles& files, Placed& placed) {
  const CameraEvidence& evidence = placed.result.evidence;
  if (evidence.pairs_agree < SizeOf(placed.result.model.scene.views) ||
      evidence.pairs_agree_share() < CameraEvidenceTuning::kSurePairShare)
    return;
  const std::vector<char> agrees =
      room.context.check.Agreement(placed.result.model.scene, placed.matched.features, before);
  std::vector<PairMatches> verified = placed.matched.verified;
  for (std::size_t k = 0; k < before.size(); ++k)
    if (agrees[k] == 1 && std::none_of(placed.matched.verified.begin(),
                                       placed.matched.verified.end(), [&](const PairMatches& pair) {
                                         return pair.first == before[k].first &&
                                                pair.second == before[k].second;
                                       }))
      verified.push_back(before[k]);
  ReplaceVerified(std::move(verified), files, placed.matched);
  placed.result = room.context.WithEvidence(std::move(placed.result), placed.matched);
}

/// Places again without pairs that match by what repeats itself: a cloth's pattern matches a period
/// off, with more matches than the figure has, and then most pairs deny right cameras.
void PlaceWithoutRepeated(const Room& room, const SfmFiles& files, Placed& best) {
  const auto& [stage, set, options, check, watch] = room.context;
  Placed other = best;
  VerifyMatches(stage, files, options, true, watch, other.matched);
  other.result = room.place(files, other.matched);
  watch.Lap(stage, "surroundings");
  TakeBackAgreeing(room, best.matched.verified, files, other);
  NotePlaced(room, "whole, without what repeats itself", other.result);
  if (IsBetter(other.result.evidence, best.result.evidence))
    best = std::move(other);
  else
    ReplaceVerified(best.matched.verified, files, best.matched);
}

/// The whole photographs, and what moves otherwise in them if that is the figure.
Placed PlaceWhole(const Room& room, const SfmFiles& files, MatchedFeatures matched) {
  const auto& [stage, set, options, check, watch] = room.context;
  Placed first;
  VerifyMatches(stage, files, options, false, watch, matched);
  first.result = room.place(files, matched);
  first.matched = std::move(matched);
  watch.Lap(stage, "surroundings");
  NotePlaced(room, "whole", first.result);
  if (!IsSure(first.result.evidence)) PlaceWithoutRepeated(room, files, first);
  const bool goes_round = IsSure(first.result.evidence) &&
                          MeanTurn(first.result.model.scene.views) > RoomStrategyTuning::kGoesRound;
  if (first.result.views() >= 3 && !goes_round) {
    const Others others = FindOthers(room, first);
    if (!others.regions.empty()) {
      Placed second = PlaceRegions(room, others.regions, "other", {});
      if (IsOfFigure(room, second, first)) {
        second.result.measurements.Add("left_out_turn_deg",
                                       Degrees(MeanTurn(first.result.model.scene.views)));
        return second;
      }
      // The figure cannot be placed, and what can is not the figure: masks may hold it as well.
      if (others.likelier ||
          MeanTurn(first.result.model.scene.views) < RoomStrategyTuning::kHardlyTurns)
        throw InputError(
            "sfm: the figure turns before a room that stands still, and what turns with it does "
            "not join the photographs: " +
            std::to_string(second.result.views()) + " of " + std::to_string(set.images.size()) +
            " could be placed, without certainty. Photograph it with smaller turns, or put "
            "something under it whose print does not repeat itself (a page of a newspaper), or "
            "hang a plain cloth behind it");
    }
  }
  if (!HasNearlyAll(room.context, first.result))
    KeepBetter(Place(room, set, "whole_fine", {.fine = true, .whole = true}, {}), first);
  return first;
}

}  // namespace

StrategyResult PlaceBySurroundings(const StrategyContext& context, const fs::path& scratch,
                                   const PlaceByFiles& place, MatchedFeatures& matched) {
  const auto& [stage, set, options, check, watch] = context;
  const Room room{context, scratch, place};
  const SfmFiles files = room.Files("whole");
  MatchedFeatures whole = MatchPhotographs(stage, set, files, options, {.whole = true}, watch);
  std::vector<ImagePair> tripods = whole.tripod_pairs;
  if (SizeOf(tripods) < RoomStrategyTuning::kTripodPairs) tripods.clear();
  Placed placed;
  if (!tripods.empty())
    placed = PlaceRegions(room, MotionRegions(whole.features, whole.turning, LensOfEach(whole), {}),
                          "turning", tripods);
  else
    placed = PlaceWhole(room, files, std::move(whole));
  StrategyResult result = std::move(placed.result);
  matched = std::move(placed.matched);
  // What turned before a tripod and seems hardly to turn is a mat that matched itself.
  if (result.views() == 0 || (!tripods.empty() && !Turns(result))) return {};
  result.method = "surroundings";
  result.measurements.Add("pairs_before_tripod", SizeOf(tripods));
  MeasureSurroundings(check, matched, result);
  return result;
}

}  // namespace keypose::reconstruct
