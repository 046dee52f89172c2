#include "capture/board/board_choice.h"

#include <algorithm>
#include <cmath>

#include "core/values/errors.h"

namespace keypose::capture {
namespace {

/// What was said, for a message.
std::string TextOfSaid(const SaidBoard& said) {
  std::string text = std::to_string(said.columns) + " x " + std::to_string(said.rows) + " squares";
  if (said.dictionary) text += ", " + DictionaryName(*said.dictionary);
  if (said.legacy)
    text += ", in the layout of OpenCV before 4.6";
  else if (said.first_white)
    text += *said.first_white ? ", with a marker in its first square" : ", its first square black";
  if (said.inverted) text += ", printed inverted";
  return text;
}

[[noreturn]] void RefuseOther(const BoardPattern& seen, const SaidBoard& said) {
  const bool markers = seen.kind == BoardPattern::Kind::kCharuco;
  BoardPattern as_said = seen;
  if (said.square_m > 0) as_said.layout.square_m = said.square_m;
  throw InputError("the pictures show " + seen.Name() + ", not the board that was said (" +
                   TextOfSaid(said) + "); " +
                   (markers ? "give --board " + as_said.Text() +
                                  " with the side of its squares, or "
                                  "leave --board out"
                            : "leave --board out"));
}

/// Keypose's own print has exact markers, which pictures show almost so.
double ExactShare(const BoardPattern& pattern, double seen_share) {
  constexpr double kAsOwn = 0.02;
  const bool own = IsOwnPrint(pattern, pattern.layout) &&
                   std::abs(seen_share - BoardLayout::kMarkerShare) < kAsOwn;
  return own ? BoardLayout::kMarkerShare : seen_share;
}

}  // namespace

BoardPattern PatternOf(const SaidBoard& said, double square_m) {
  BoardPattern pattern;
  if (said.columns > 0) {
    pattern.layout.columns = said.columns;
    pattern.layout.rows = said.rows;
  }
  pattern.layout.square_m = said.square_m > 0 ? said.square_m : square_m;
  pattern.layout.marker_m =
      said.marker_m > 0 ? said.marker_m : BoardLayout::kMarkerShare * pattern.layout.square_m;
  pattern.first_white = said.FirstWhite(pattern.layout.rows).value_or(false);
  pattern.inverted = said.inverted;
  pattern.dictionary = said.dictionary.value_or(kOwnDictionary);
  if (!said.dictionary)
    pattern.dictionary =
        std::max(kOwnDictionary, SmallestDictionary(kOwnDictionary, pattern.MarkerCount()));
  return pattern;
}

bool IsOwnPrint(const BoardPattern& seen, const BoardLayout& own) {
  return seen.kind == BoardPattern::Kind::kCharuco && BeginAlike(seen.dictionary, kOwnDictionary) &&
         !seen.first_white && !seen.inverted && seen.layout.columns == own.columns &&
         seen.layout.rows <= own.rows;
}

bool HasOwnMarkers(const BoardLayout& seen) {
  return std::abs(seen.marker_m / seen.square_m - BoardLayout::kMarkerShare) < 0.1;
}

BoardPattern SeenAsSaid(const BoardPattern& seen, const SaidBoard& said, double square_m) {
  if (seen.kind != BoardPattern::Kind::kCharuco || !said.Allows(seen.layout, seen))
    RefuseOther(seen, said);
  BoardPattern pattern = seen;
  const double share = ExactShare(seen, seen.layout.marker_m / seen.layout.square_m);
  pattern.layout.square_m = said.square_m > 0 ? said.square_m : square_m;
  pattern.layout.marker_m = said.marker_m > 0 ? said.marker_m : share * pattern.layout.square_m;
  if (said.columns > 0) {
    const bool exchanged = seen.layout.columns != said.columns || seen.layout.rows > said.rows;
    pattern.layout.rows = exchanged ? said.columns : said.rows;
  }
  pattern.dictionary =
      said.dictionary.value_or(SmallestDictionary(seen.dictionary, pattern.MarkerCount()));
  if (const auto problems = pattern.Problems(); !problems.empty())
    throw InputError(problems.front());
  return pattern;
}

}  // namespace keypose::capture
