// How a calibration board of any program is printed, and the words that people give for it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/values/calibration_board.h"

namespace keypose {

/// OpenCV's number of the dictionary of Keypose's own board, DICT_5X5_100.
inline constexpr int kOwnDictionary = 5;

/// What a board's layout of squares leaves open.
struct BoardPrint {
  int dictionary = kOwnDictionary;  ///< OpenCV's number
  /// The square at the top left is white and holds marker 0. OpenCV before 4.6 printed boards of an
  /// even number of rows so.
  bool first_white = false;
  bool inverted = false;  ///< white ink on black paper
};

/// "DICT_5X5_100"
/// @pre a number of OpenCV 4.6
std::string DictionaryName(int dictionary);
/// The number of a name, with or without DICT_, in capitals or not; none for other names.
std::optional<int> DictionaryNamed(const std::string& name);
/// How many markers it has.
int MarkersOfDictionary(int dictionary);
/// Whether the one dictionary begins with all markers of the other, as DICT_4X4_1000 with those of
/// DICT_4X4_50.
bool BeginAlike(int dictionary, int other);

/// Markers of a board: one in each white square.
int MarkersOfBoard(const BoardLayout& layout, const BoardPrint& print);
/// One sentence for each fault of a board with markers; empty when valid. The markers of a layout
/// that is faulty itself are not counted.
std::vector<std::string> BoardProblems(const BoardLayout& layout, const BoardPrint& print);

/// What a person says of a board; the rest is found in the pictures.
struct SaidBoard {
  int columns = 0, rows = 0;          ///< squares; 0: not said
  double square_m = 0, marker_m = 0;  ///< 0: not said
  std::optional<int> dictionary;
  std::optional<bool> first_white;
  bool legacy = false;  ///< as OpenCV before 4.6: it depends on the rows which square is white
  bool inverted = false;

  /// What was said of the first square; none: nothing.
  /// @param of_rows  the board's rows, which may be the columns that were said
  std::optional<bool> FirstWhite(int of_rows) const {
    return legacy ? of_rows % 2 == 0 : first_white;
  }
  /// Whether a board that was seen may be this one. Its last rows may be out of sight, and its rows
  /// and columns are often taken for one another.
  bool Allows(const BoardLayout& seen, const BoardPrint& print) const;
};

/// Reads COLUMNSxROWS and then, in any order and each only where it is known, separated by colons:
/// SIDEmm of a square or SIDE/MARKERmm, a dictionary's name, `legacy` (as OpenCV before 4.6),
/// `first_white` or `first_black`, `inverted`: "8x11:22mm:DICT_4X4_50:legacy".
/// @throws UsageError  a word that is none of these; a board that is not possible
SaidBoard ParseBoard(const std::string& text);

/// The text for ParseBoard that says this of a board: its squares, their side, the dictionary, and
/// a first white square or white ink; nothing of the markers' size, or of a black square.
std::string BoardText(const BoardLayout& layout, const BoardPrint& print);

}  // namespace keypose
