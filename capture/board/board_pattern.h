// A calibration board as any program may have printed it.
#pragma once

#include <string>
#include <vector>

#include "core/values/calibration_board.h"

namespace keypose::capture {

/// OpenCV's number of the dictionary of Keypose's own board, DICT_5X5_100.
inline constexpr int kOwnDictionary = 5;

struct BoardPattern {
  enum class Kind { kCharuco, kCheckerboard };

  BoardPattern() = default;
  /// The board that `capture` prints.
  explicit BoardPattern(const BoardLayout& own) : layout(own) {}

  Kind kind = Kind::kCharuco;
  BoardLayout layout;  ///< squares; a checkerboard has no markers
  int dictionary = kOwnDictionary;
  /// The square at the top left is white and holds marker 0. OpenCV before 4.6 printed boards of an
  /// even number of rows so.
  bool first_white = false;
  bool inverted = false;  ///< white ink on black paper
  /// Some pictures show the board in a mirror: its back, printed as well, or a camera that mirrors.
  bool mirrored = false;

  int MarkerCount() const;
  /// The square that holds a marker: column, row.
  std::pair<int, int> SquareOf(int marker) const;
  /// How many ways of turning a checkerboard in its plane nobody can tell apart: 1, 2 or 4.
  int Turns() const;
  /// "a ChArUco board of 11 x 8 squares, DICT_5X5_100"
  std::string Name() const;
  /// One sentence for each fault; empty when valid.
  std::vector<std::string> Problems() const;
};

/// "DICT_5X5_100"
std::string DictionaryName(int dictionary);

/// Numbers of the dictionaries that contain all others of OpenCV: DICT_4X4_1000 begins with the
/// markers of DICT_4X4_50.
const std::vector<int>& LargestDictionaries();

/// The smallest dictionary that begins like this one and has so many markers. Fewer markers allow
/// more wrong bits.
int SmallestDictionary(int largest, int markers);

/// Ink of a marker, rows from the top, its black border included: 1 for ink.
std::vector<std::vector<int>> MarkerInk(int dictionary, int marker);

}  // namespace keypose::capture
