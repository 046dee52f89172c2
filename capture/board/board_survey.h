// Which calibration board do these pictures show?
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "capture/board/board_pattern.h"
#include "capture/board/markers.h"
#include "core/values/image.h"

namespace keypose::capture {

/// What the user says about the board; the rest is found in the pictures.
struct BoardWish {
  std::optional<BoardPattern::Kind> kind;
  int columns = 0, rows = 0;  ///< squares; 0: not said
  double square_m = BoardLayout{}.square_m;
  /// what has eleven columns and the markers of Keypose's own board is that board, with all its
  /// rows
  bool own_completed = true;
};

/// Gathers evidence from pictures until it is clear which board they show: its kind, dictionary,
/// squares, the square that it begins with, and whether it is printed inverted.
///
/// Quadrilaterals are read with every dictionary of OpenCV. The numbers of a board's markers run
/// row by row, so that with the right count of columns, and only with it, they fall into places
/// that a homography explains, each marker upright in its square. Where there are no markers,
/// checkerboards are looked for.
class BoardSurvey {
 public:
  explicit BoardSurvey(const BoardWish& wish);
  /// Once it is sure, only the board's own markers are read, which is quick: in its last row, that
  /// may be out of sight in some pictures.
  void Add(const Image8& picture);
  /// More pictures would not change the answer but for the board's last rows.
  bool sure() const { return sure_; }
  /// The board; empty where the pictures do not tell.
  std::optional<BoardPattern> Pattern() const;
  /// What was seen, for a message: "markers of DICT_4X4_50 (0 to 17)"; empty: nothing.
  std::string Seen() const;

 private:
  struct Print {  // of a board's markers
    int dictionary = 0;
    bool inverted = false;
    auto operator<=>(const Print&) const = default;
  };
  /// How well markers agree with one way to lay them out.
  struct Tally {
    double score = 0;  // markers in their places, less three of each picture
    std::vector<double> shares;
    int last = 0;  // marker
    bool mirrored = false;
  };
  struct Evidence {
    std::set<int> ids;
    std::map<std::pair<int, bool>, Tally> layouts;  // by columns, and whether it begins white
  };

  void ReadMarkers(const Image8& picture, bool inverted, const std::vector<int>& dictionaries);
  void Count(const Print& print, const std::vector<SeenMarker>& markers, bool mirrored);
  void Weigh();
  std::optional<BoardPattern> Checkerboard() const;

  BoardWish wish_;
  std::map<Print, Evidence> evidence_;
  std::map<std::pair<int, int>, int> checkerboards_;  // inner corners, pictures
  std::optional<BoardPattern> charuco_;
  int pictures_ = 0;
  bool sure_ = false;
};

/// The board in one picture.
struct FoundBoard {
  std::vector<BoardCorner> corners;  ///< numbered as those of the layout
  /// Some rows or columns of a checkerboard are out of sight, and nobody knows which: good for a
  /// lens, not for a place.
  bool partial = false;
};

/// Looks for a board of this pattern, also in small pictures.
FoundBoard LookForBoard(const Image8& picture, const BoardPattern& pattern);

}  // namespace keypose::capture
