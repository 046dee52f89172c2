#include "core/values/board_print.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>

#include "core/values/errors.h"

namespace keypose {
namespace {

struct NamedDictionary {
  const char* name;
  int markers;
};

// by OpenCV's number
constexpr std::array<NamedDictionary, 21> kDictionaries{
    {{"DICT_4X4_50", 50},        {"DICT_4X4_100", 100},         {"DICT_4X4_250", 250},
     {"DICT_4X4_1000", 1000},    {"DICT_5X5_50", 50},           {"DICT_5X5_100", 100},
     {"DICT_5X5_250", 250},      {"DICT_5X5_1000", 1000},       {"DICT_6X6_50", 50},
     {"DICT_6X6_100", 100},      {"DICT_6X6_250", 250},         {"DICT_6X6_1000", 1000},
     {"DICT_7X7_50", 50},        {"DICT_7X7_100", 100},         {"DICT_7X7_250", 250},
     {"DICT_7X7_1000", 1000},    {"DICT_ARUCO_ORIGINAL", 1024}, {"DICT_APRILTAG_16h5", 30},
     {"DICT_APRILTAG_25h9", 35}, {"DICT_APRILTAG_36h10", 2320}, {"DICT_APRILTAG_36h11", 587}}};
constexpr int kFamilies = 16;  // of these, four sizes each begin alike

std::string InCapitals(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

[[noreturn]] void Refuse(const std::string& text, const std::string& why) {
  throw UsageError("the board '" + text + "' cannot be read: " + why +
                   "; say its squares, the side of one, and its dictionary, as in "
                   "8x11:22mm:DICT_4X4_50 (then, where it is so, legacy, first_white or inverted)");
}

std::optional<double> NumberIn(const std::string& word) {
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return {};
  return value;
}

std::optional<int> CountIn(const std::string& word) {
  int value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return {};
  return value;
}

std::vector<std::string> WordsOf(const std::string& text, char between) {
  std::vector<std::string> words(1);
  for (const char c : text)
    if (c == between)
      words.emplace_back();
    else
      words.back() += c;
  return words;
}

/// "11x8"
bool ReadSquares(const std::string& word, SaidBoard* board) {
  const std::vector<std::string> sides = WordsOf(InCapitals(word), 'X');
  if (sides.size() != 2) return false;
  const std::optional<int> columns = CountIn(sides[0]), rows = CountIn(sides[1]);
  if (!columns || !rows) return false;
  board->columns = *columns;
  board->rows = *rows;
  return true;
}

/// "22mm" or "22/16.5mm"
bool ReadSides(const std::string& word, SaidBoard* board) {
  if (word.size() < 3 || InCapitals(word.substr(word.size() - 2)) != "MM") return false;
  const std::vector<std::string> sides = WordsOf(word.substr(0, word.size() - 2), '/');
  const std::optional<double> square = NumberIn(sides[0]);
  if (!square || !(*square > 0) || sides.size() > 2) return false;
  board->square_m = *square / 1000;
  if (sides.size() == 1) return true;
  const std::optional<double> marker = NumberIn(sides[1]);
  if (!marker || !(*marker > 0 && *marker < *square)) return false;
  board->marker_m = *marker / 1000;
  return true;
}

bool ReadKind(const std::string& word, SaidBoard* board) {
  const std::string kind = InCapitals(word);
  if (kind == "LEGACY") {
    board->legacy = true;
  } else if (kind == "FIRST_WHITE" || kind == "FIRST_BLACK") {
    board->legacy = false;
    board->first_white = kind == "FIRST_WHITE";
  } else if (kind == "INVERTED")
    board->inverted = true;
  else if (const std::optional<int> dictionary = DictionaryNamed(word))
    board->dictionary = dictionary;
  else
    return false;
  return true;
}

}  // namespace

std::string DictionaryName(int dictionary) { return kDictionaries.at(dictionary).name; }

std::optional<int> DictionaryNamed(const std::string& name) {
  const std::string capitals = InCapitals(name);
  for (std::size_t i = 0; i < kDictionaries.size(); ++i) {
    const std::string full = InCapitals(kDictionaries[i].name);
    if (capitals == full || "DICT_" + capitals == full) return static_cast<int>(i);
  }
  return {};
}

int MarkersOfDictionary(int dictionary) { return kDictionaries.at(dictionary).markers; }

bool BeginAlike(int dictionary, int other) {
  constexpr int kSizes = 4;
  if (dictionary >= kFamilies || other >= kFamilies) return dictionary == other;
  return dictionary / kSizes == other / kSizes;
}

int MarkersOfBoard(const BoardLayout& layout, const BoardPrint& print) {
  return (layout.columns * layout.rows + (print.first_white ? 1 : 0)) / 2;
}

std::vector<std::string> BoardProblems(const BoardLayout& layout, const BoardPrint& print) {
  std::vector<std::string> problems = layout.Problems();
  if (!problems.empty()) return problems;  // among them sides whose markers nobody can count
  const int has = MarkersOfDictionary(print.dictionary);
  if (MarkersOfBoard(layout, print) > has)
    problems.push_back(
        fmt::format("a calibration board of {} x {} squares has more markers than the {} of {}; "
                    "use fewer squares",
                    layout.columns, layout.rows, has, DictionaryName(print.dictionary)));
  return problems;
}

bool SaidBoard::Allows(const BoardLayout& seen, const BoardPrint& print) const {
  const bool fits = seen.columns == columns && seen.rows <= rows,
             turned = seen.columns == rows && seen.rows <= columns;
  if (columns > 0 && !fits && !turned) return false;
  if (dictionary && !BeginAlike(*dictionary, print.dictionary)) return false;
  const std::optional<bool> begins_white = FirstWhite(fits ? rows : columns);
  return begins_white.value_or(print.first_white) == print.first_white &&
         inverted <= print.inverted;
}

SaidBoard ParseBoard(const std::string& text) {
  SaidBoard board;
  const std::vector<std::string> words = WordsOf(text, ':');
  if (!ReadSquares(words.front(), &board))
    Refuse(text, "it does not begin with its columns and rows of squares");
  for (std::size_t i = 1; i < words.size(); ++i)
    if (!ReadSides(words[i], &board) && !ReadKind(words[i], &board))
      Refuse(text, "'" + words[i] + "' is no side in mm, no dictionary of OpenCV, and no layout");
  BoardLayout layout{board.columns, board.rows, 1, BoardLayout::kMarkerShare};
  BoardPrint print;
  print.first_white = board.FirstWhite(board.rows).value_or(false);
  constexpr int kLargest = 19;  // with the most markers, where none is said
  print.dictionary = board.dictionary.value_or(kLargest);
  if (const auto problems = BoardProblems(layout, print); !problems.empty())
    Refuse(text, problems.front());
  return board;
}

std::string BoardText(const BoardLayout& layout, const BoardPrint& print) {
  std::string text = fmt::format("{}x{}:{:g}mm:{}", layout.columns, layout.rows,
                                 1000 * layout.square_m, DictionaryName(print.dictionary));
  if (print.first_white) text += layout.rows % 2 == 0 ? ":legacy" : ":first_white";
  if (print.inverted) text += ":inverted";
  return text;
}

}  // namespace keypose
