#include "capture/board_to_find.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "capture/board/board_choice.h"
#include "capture/board/board_survey.h"
#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/values/errors.h"

namespace keypose::capture {
namespace {

/// Photographs spread over the set, and whether each shows corners of the wished board.
struct BoardProbes {
  std::vector<Image8> pictures;
  std::vector<char> shows;
  bool any() const { return std::find(shows.begin(), shows.end(), 1) != shows.end(); }
};

BoardProbes LookForBoards(const PhotographImport& import, const BoardPattern& wished) {
  constexpr std::size_t kProbes = 8;
  const std::size_t probes = std::min(kProbes, import.files.size());
  BoardProbes found;
  found.pictures.resize(probes);
  found.shows.resize(probes);
  ParallelFor(static_cast<std::int64_t>(probes), [&](std::int64_t k) {
    const std::size_t i = static_cast<std::size_t>(k) * import.files.size() / probes;
    try {
      found.pictures[k] = LoadReduced(import, i, DetailEighths(import, i));
      found.shows[k] = !CornersOf(found.pictures[k], wished).empty();
    } catch (const InputError&) {
      // A damaged photograph is reported later, with all the others.
    }
  });
  return found;
}

/// Which board the photographs show, of any kind; empty where they do not tell. Where the wished
/// one was seen, the other photographs tell nothing.
std::optional<BoardPattern> SurveyedBoard(const BoardProbes& probes, double square_m) {
  BoardWish wish;
  wish.square_m = square_m;
  wish.own_completed = false;
  BoardSurvey survey(wish);
  for (std::size_t k = 0; k < probes.pictures.size(); ++k)
    if (!probes.pictures[k].empty() && (probes.shows[k] || !probes.any()))
      survey.Add(probes.pictures[k]);
  return survey.Pattern();
}

/// Whether the board is only seen in a mirror.
bool IsMirrored(const BoardProbes& probes, BoardPattern pattern) {
  if (!pattern.mirrored) return false;
  pattern.mirrored = false;
  return std::all_of(probes.pictures.begin(), probes.pictures.end(), [&](const Image8& picture) {
    return picture.empty() || CornersOf(picture, pattern).empty();
  });
}

/// How much of a square a marker takes, by the photographs.
double MeasuredShare(const BoardProbes& probes, const BoardPattern& pattern) {
  constexpr std::size_t kEnough = 3;
  std::vector<double> shares;
  for (const Image8& picture : probes.pictures)
    if (!picture.empty() && shares.size() < kEnough)
      if (const double share = MarkerShareIn(picture, pattern); share > 0) shares.push_back(share);
  return shares.empty() ? pattern.layout.marker_m / pattern.layout.square_m
                        : UpperMedian(std::move(shares));
}

/// The board that the photographs show instead of Keypose's own, or as it was said.
BoardPattern OtherBoard(StageContext& stage, const BoardProbes& probes, const BoardPattern& shown,
                        const CaptureOptions& options) {
  const SaidBoard said = options.Said().value_or(SaidBoard{});
  const double square_m = options.board_square_mm / 1000;
  BoardPattern pattern = SeenAsSaid(shown, said, square_m);
  pattern.mirrored = false;
  if (said.marker_m == 0) {
    pattern.layout.marker_m = MeasuredShare(probes, pattern) * pattern.layout.square_m;
    pattern = SeenAsSaid(pattern, said, square_m);
  }
  if (options.SaysSide())
    stage.Note("the photographs show " + pattern.Name());
  else
    stage.Warn("the photographs show " + pattern.Name() + ". Its squares are taken for " +
               nlohmann::json(options.board_square_mm).dump() +
               " mm: measure one and give --board " + pattern.Text() +
               " with that side, or all lengths are wrong by one factor");
  return pattern;
}

}  // namespace

std::vector<BoardCorner> CornersOf(const Image8& image, const BoardPattern& pattern) {
  return FindBoard(image, pattern, !IsOwnPrint(pattern, pattern.layout));
}

std::optional<BoardPattern> BoardToFind(StageContext& stage, const PhotographImport& import,
                                        const CaptureOptions& options) {
  const BoardPattern wished = options.Board();
  const BoardProbes probes = LookForBoards(import, wished);
  const std::optional<BoardPattern> shown = SurveyedBoard(probes, wished.layout.square_m);
  const bool markers = shown && shown->kind == BoardPattern::Kind::kCharuco;
  if (!markers && probes.any()) return wished;
  if (markers && IsMirrored(probes, *shown)) {
    stage.Warn("the photographs show " + shown->Name() +
               " in a mirror, so it is not used: the print is mirrored: print it anew; or the "
               "camera mirrors its pictures, and must be told not to");
    return {};
  }
  if (markers && !options.Said() && IsOwnPrint(*shown, wished.layout))
    return probes.any() ? std::optional(wished) : std::nullopt;
  if (markers) return OtherBoard(stage, probes, *shown, options);
  if (shown)
    stage.Warn("the photographs show " + shown->Name() +
               ", which is not used, as it has no markers: the cameras come from the figure alone, "
               "and lengths have no unit. Print the board of `keypose capture --print-board`");
  else if (options.Said())
    stage.Warn("the photographs do not show " + wished.Name() + ", nor another board");
  return {};
}

}  // namespace keypose::capture
