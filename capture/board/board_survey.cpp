#include "capture/board/board_survey.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <set>

#include "capture/board/board_choice.h"
#include "capture/board/board_detection.h"
#include "capture/board/checkerboard.h"
#include "core/numbers/statistics.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

using Eigen::Vector2d;

constexpr int kLeastMarkers = 4;    // of a picture that tells about a layout
constexpr int kMostColumns = 40;    // squares
constexpr double kLeastScore = 4;   // markers beyond the three that any layout explains
constexpr double kSureScore = 20;   // no picture more is needed
constexpr double kAhead = 3;        // of the next layout
constexpr double kHopeless = 0.5;   // of the best layout's score: not looked at any more
constexpr int kEnoughCheckers = 4;  // pictures of whole checkerboards

Vector2d MiddleOf(const SeenMarker& marker) {
  // where the diagonals cross: the middle of a square in perspective
  const auto& c = marker.corners;
  const Vector2d a = c[2] - c[0], b = c[3] - c[1], between = c[1] - c[0];
  const double cross = a.x() * b.y() - a.y() * b.x();
  if (std::abs(cross) < 1e-9) return (c[0] + c[2]) / 2;
  return c[0] + a * ((between.x() * b.y() - between.y() * b.x()) / cross);
}

double SideOfMarker(const SeenMarker& marker) { return MarkerQuad{marker.corners}.Side(); }

/// A marker's share of its square, where it lies upright in one; 0 where it does not.
double ShareOf(const SeenMarker& marker, const Eigen::Matrix3d& grid_from_image) {
  constexpr double kLeast = 0.3, kMost = 0.98, kAskew = 0.35;
  std::array<Vector2d, 4> at;
  for (int k = 0; k < 4; ++k)
    at[k] = (grid_from_image * marker.corners[k].homogeneous()).hnormalized();
  const Vector2d right = (at[1] - at[0] + at[2] - at[3]) / 2,
                 down = (at[3] - at[0] + at[2] - at[1]) / 2;
  for (const double side : {right.x(), down.y()})
    if (!(side > kLeast && side < kMost)) return 0;
  if (std::abs(right.y()) > kAskew * right.x() || std::abs(down.x()) > kAskew * down.y()) return 0;
  return (right.x() + down.y()) / 2;
}

/// How markers of one picture agree with a layout.
struct Agreement {
  std::vector<int> ids;
  std::vector<double> shares;
};

Agreement AgreementOf(const std::vector<SeenMarker>& markers, const BoardPattern& pattern) {
  constexpr double kMiss = 0.35;  // of a marker's side
  std::vector<cv::Point2d> grid, seen;
  std::vector<double> sides;
  for (const SeenMarker& marker : markers) {
    const auto [column, row] = pattern.SquareOf(marker.id);
    const Vector2d middle = MiddleOf(marker);
    grid.emplace_back(column + 0.5, row + 0.5);
    seen.emplace_back(middle.x(), middle.y());
    sides.push_back(SideOfMarker(marker));
  }
  std::vector<std::uint8_t> inlier;
  const cv::Mat h =
      cv::findHomography(grid, seen, cv::RANSAC,
                         std::max(1.0, kMiss * UpperMedian(std::move(sides))), inlier, 300, 0.99);
  if (h.empty()) return {};
  const Eigen::Matrix3d image_from_grid =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(h.ptr<double>());
  const Eigen::Matrix3d grid_from_image = image_from_grid.inverse();
  if (!grid_from_image.allFinite()) return {};
  Agreement agreement;
  for (int i = 0; i < SizeOf(markers); ++i) {
    if (!inlier[i]) continue;
    const double share = ShareOf(markers[i], grid_from_image);
    if (share == 0) continue;
    agreement.ids.push_back(markers[i].id);
    agreement.shares.push_back(share);
  }
  if (SizeOf(agreement.ids) < kLeastMarkers) return {};
  return agreement;
}

/// Each number once; a board has no marker twice.
std::vector<SeenMarker> Unlike(const std::vector<SeenMarker>& markers) {
  std::map<int, int> count;
  for (const SeenMarker& marker : markers) ++count[marker.id];
  std::vector<SeenMarker> single;
  for (const SeenMarker& marker : markers)
    if (count[marker.id] == 1) single.push_back(marker);
  return single;
}

std::vector<MarkerQuad> Mirrored(std::vector<MarkerQuad> quads, int width) {
  for (MarkerQuad& quad : quads) {
    for (Vector2d& corner : quad.corners) corner.x() = width - 1 - corner.x();
    std::swap(quad.corners[1], quad.corners[3]);  // clockwise again
  }
  return quads;
}

/// Of the dictionaries that begin alike.
int Largest(int dictionary) {
  for (const int largest : LargestDictionaries())
    if (BeginAlike(largest, dictionary)) return largest;
  return dictionary;
}

/// The corners of a checkerboard's grid by the layout's numbers; none where it is larger.
FoundBoard Numbered(const CheckerGrid& grid, const BoardPattern& pattern) {
  FoundBoard found;
  const int across = std::max(pattern.layout.columns, pattern.layout.rows) - 1,
            down = std::min(pattern.layout.columns, pattern.layout.rows) - 1;
  if (grid.empty() || grid.columns > across || grid.rows > down) return found;
  found.partial = grid.columns < across || grid.rows < down;
  const bool upright = pattern.layout.columns >= pattern.layout.rows;
  for (const CheckerGrid::Corner& corner : grid.corners) {
    // a layout whose longer side runs down: a quarter turn
    const int column = upright ? corner.column : down - 1 - corner.row,
              row = upright ? corner.row : corner.column;
    found.corners.push_back({row * (pattern.layout.columns - 1) + column, corner.pixel});
  }
  return found;
}

}  // namespace

BoardSurvey::BoardSurvey(const BoardWish& wish) : wish_(wish) {}

void BoardSurvey::ReadMarkers(const Image8& picture, bool inverted,
                              const std::vector<int>& dictionaries) {
  const Image8 grey = GreyPicture(picture, inverted);
  const std::vector<MarkerQuad> quads = FindQuads(grey);
  const Image8 mirror = MirroredPicture(grey);
  const std::vector<MarkerQuad> mirrored = Mirrored(quads, grey.width);
  for (const int dictionary : dictionaries) {
    std::vector<SeenMarker> plain = Unlike(ReadQuads(grey, quads, dictionary));
    std::vector<SeenMarker> flipped = Unlike(ReadQuads(mirror, mirrored, dictionary));
    const bool turned = flipped.size() > plain.size();
    std::vector<SeenMarker>& markers = turned ? flipped : plain;
    if (SizeOf(markers) >= kLeastMarkers) Count({dictionary, inverted}, markers, turned);
  }
}

void BoardSurvey::Count(const Print& print, const std::vector<SeenMarker>& markers, bool mirrored) {
  Evidence& evidence = evidence_[print];
  for (const SeenMarker& marker : markers) evidence.ids.insert(marker.id);
  double best = 0;
  for (const auto& [layout, tally] : evidence.layouts) best = std::max(best, tally.score);
  for (int columns = 3; columns <= kMostColumns; ++columns) {
    if (wish_.columns && columns != wish_.columns && columns != wish_.rows) continue;
    for (const bool first_white : {false, true}) {
      Tally& tally = evidence.layouts[{columns, first_white}];
      if (tally.score < kHopeless * best) continue;
      BoardPattern pattern;
      pattern.layout.columns = columns;
      pattern.first_white = first_white;
      const Agreement agreement = AgreementOf(markers, pattern);
      if (agreement.ids.empty()) continue;
      tally.score += SizeOf(agreement.ids) - kLeastMarkers + 1;
      tally.shares.insert(tally.shares.end(), agreement.shares.begin(), agreement.shares.end());
      tally.last =
          std::max(tally.last, *std::max_element(agreement.ids.begin(), agreement.ids.end()));
      tally.mirrored |= mirrored;
    }
  }
}

void BoardSurvey::Add(const Image8& picture) {
  ++pictures_;
  if (sure_ && charuco_) {
    ReadMarkers(picture, charuco_->inverted, {Largest(charuco_->dictionary)});
    Weigh();
    return;
  }
  const bool markers = wish_.kind != BoardPattern::Kind::kCheckerboard;
  if (markers) {
    ReadMarkers(picture, false, LargestDictionaries());
    if (!charuco_ || charuco_->inverted) ReadMarkers(picture, true, LargestDictionaries());
    Weigh();
  }
  if (wish_.kind == BoardPattern::Kind::kCharuco || charuco_) return;
  const CheckerGrid grid = FindCheckerboard(picture);
  if (grid.empty()) return;
  const int seen = ++checkerboards_[{grid.columns, grid.rows}];
  sure_ = seen >= kEnoughCheckers && !markers;
}

void BoardSurvey::Weigh() {
  charuco_.reset();
  double most = 0;
  for (const auto& [print, evidence] : evidence_) {
    const std::pair<const std::pair<int, bool>, Tally>* best = nullptr;
    double next = 0;
    for (const auto& item : evidence.layouts) {
      const double score = item.second.score, other = best ? best->second.score : 0;
      next = std::max(next, std::min(score, other));
      if (score > other) best = &item;
    }
    if (!best || best->second.score < std::max(kLeastScore, next + kAhead)) continue;
    if (best->second.score <= most) continue;
    most = best->second.score;
    const auto& [columns, first_white] = best->first;
    const Tally& tally = best->second;
    BoardPattern pattern;
    pattern.inverted = print.inverted;
    pattern.mirrored = tally.mirrored;
    pattern.first_white = first_white;
    pattern.layout.columns = columns;
    pattern.layout.rows = pattern.SquareOf(tally.last).second + 1;
    pattern.dictionary = SmallestDictionary(print.dictionary, pattern.MarkerCount());
    pattern.layout.square_m = wish_.square_m;
    pattern.layout.marker_m = UpperMedian(tally.shares) * wish_.square_m;
    if (pattern.Problems().empty()) charuco_ = pattern;
  }
  sure_ = charuco_ && most >= kSureScore;
}

std::optional<BoardPattern> BoardSurvey::Checkerboard() const {
  std::pair<int, int> size;
  int most = 0;
  for (const auto& [inner, pictures] : checkerboards_) {
    const int across = std::max(wish_.columns, wish_.rows) - 1;
    const int down = std::min(wish_.columns, wish_.rows) - 1;
    if (wish_.columns && inner != std::pair(across, down)) continue;
    // of sizes seen as often, the larger one: the others are parts of it
    if (pictures >= most) {
      most = pictures;
      size = inner;
    }
  }
  if (most == 0 || (most == 1 && pictures_ > 1 && !wish_.columns)) return {};
  BoardPattern pattern;
  pattern.kind = BoardPattern::Kind::kCheckerboard;
  pattern.layout.columns = size.first + 1;
  pattern.layout.rows = size.second + 1;
  pattern.layout.square_m = wish_.square_m;
  pattern.layout.marker_m = BoardLayout::kMarkerShare * wish_.square_m;
  return pattern;
}

std::optional<BoardPattern> BoardSurvey::Pattern() const {
  if (!charuco_) return Checkerboard();
  BoardPattern pattern = *charuco_;
  if (wish_.columns) {
    const bool portrait = pattern.layout.columns != wish_.columns;
    pattern.layout.rows = portrait ? wish_.columns : wish_.rows;
    pattern.dictionary = SmallestDictionary(pattern.dictionary, pattern.MarkerCount());
  }
  if (!wish_.own_completed) return pattern;
  // Keypose's own print has exact markers.
  BoardLayout own;
  if (wish_.columns) own = pattern.layout;
  own.rows = std::max(own.rows, pattern.layout.rows);
  if (IsOwnPrint(pattern, own) && HasOwnMarkers(pattern.layout) &&
      pattern.MarkerCount() <= MarkersOfDictionary(kOwnDictionary)) {
    pattern.layout.rows = own.rows;
    pattern.layout.marker_m = BoardLayout::kMarkerShare * pattern.layout.square_m;
    pattern.dictionary = kOwnDictionary;
  }
  return pattern;
}

std::string BoardSurvey::Seen() const {
  if (const std::optional<BoardPattern> pattern = Pattern()) return pattern->Name();
  const Print* most = nullptr;
  std::set<int> ids;
  for (const auto& [print, evidence] : evidence_)
    if (evidence.ids.size() > ids.size()) {
      ids = evidence.ids;
      most = &print;
    }
  if (most)
    return fmt::format("{} markers that may be of {} (between {} and {}){}", ids.size(),
                       DictionaryName(SmallestDictionary(most->dictionary, *ids.rbegin() + 1)),
                       *ids.begin(), *ids.rbegin(), most->inverted ? ", printed inverted" : "");
  std::string text;
  for (const auto& [inner, pictures] : checkerboards_)
    text += fmt::format("{}{} x {} inner corners in {} pictures", text.empty() ? "" : ", ",
                        inner.first, inner.second, pictures);
  return text.empty() ? text : "checkerboards of " + text;
}

FoundBoard LookForBoard(const Image8& picture, const BoardPattern& pattern) {
  if (pattern.kind == BoardPattern::Kind::kCharuco) return {FindBoard(picture, pattern, true)};
  return Numbered(FindCheckerboard(picture), pattern);
}

}  // namespace keypose::capture
