// A calibration board as any program may have printed it.
#pragma once

#include <string>
#include <vector>

#include "core/values/board_print.h"

namespace keypose::capture {

struct BoardPattern : BoardPrint {
  enum class Kind { kCharuco, kCheckerboard };

  BoardPattern() = default;
  /// The board that `capture` prints, or one that is printed otherwise.
  explicit BoardPattern(const BoardLayout& squares, const BoardPrint& print = {})
      : BoardPrint(print), layout(squares) {}

  Kind kind = Kind::kCharuco;
  BoardLayout layout;  ///< squares; a checkerboard has no markers
  /// Some pictures show the board in a mirror: its back, printed as well, or a camera that mirrors.
  bool mirrored = false;

  int MarkerCount() const;
  /// The square that holds a marker: column, row.
  std::pair<int, int> SquareOf(int marker) const;
  /// How many ways of turning a checkerboard in its plane nobody can tell apart: 1, 2 or 4.
  int Turns() const;
  /// "a ChArUco board of 11 x 8 squares, DICT_5X5_100"
  std::string Name() const;
  /// "11x8:22mm:DICT_5X5_100", as ParseBoard reads it.
  std::string Text() const { return BoardText(layout, *this); }
  /// One sentence for each fault; empty when valid.
  std::vector<std::string> Problems() const;
};

/// Numbers of the dictionaries that contain all others of OpenCV: DICT_4X4_1000 begins with the
/// markers of DICT_4X4_50.
const std::vector<int>& LargestDictionaries();

/// The smallest dictionary that begins like this one and has so many markers. Fewer markers allow
/// more wrong bits.
int SmallestDictionary(int largest, int markers);

/// Ink of a marker, rows from the top, its black border included: 1 for ink.
std::vector<std::vector<int>> MarkerInk(int dictionary, int marker);

}  // namespace keypose::capture
