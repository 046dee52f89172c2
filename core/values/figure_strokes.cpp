#include "core/values/figure_strokes.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <string_view>
#include <utility>

#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose {
namespace {

constexpr double kLargest_px = 1e6;
constexpr std::size_t kMostPoints = 10'000;
constexpr const char* kForm =
    "a click is written as PICTURE:X,Y, as in IMG_0012.jpg:512,300 (of a film cam2/114:512,300), a "
    "stroke as PICTURE:X,Y-X,Y, and ! before it means: this is not the figure";

bool IsControl(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }

/// @param part  of the text, which is shown in the message
[[noreturn]] void Fail(std::string_view part, const std::string& fault) {
  constexpr std::size_t kShown = 60;
  std::size_t size = std::min(part.size(), kShown);
  // Not within a letter of UTF-8.
  while (size < part.size() && (static_cast<unsigned char>(part[size]) & 0xc0) == 0x80) ++size;
  std::string shown(part.substr(0, size));
  std::replace_if(shown.begin(), shown.end(), IsControl, '?');
  if (size < part.size()) shown += "...";
  throw UsageError(fmt::format("figure: '{}' {}; {}", shown, fault, kForm));
}

bool IsSeparator(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == ';'; }

int HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// The character that %XX at `i` stands for; -1: there is no %XX. Only those of ASCII are written
/// so, and no zero.
int CodeAt(std::string_view name, std::size_t i) {
  if (name[i] != '%' || i + 2 >= name.size()) return -1;
  const int high = HexDigit(name[i + 1]), low = HexDigit(name[i + 2]);
  return high < 0 || high > 7 || low < 0 || high + low == 0 ? -1 : high * 16 + low;
}

std::string Decoded(std::string_view name) {
  std::string text;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const int code = CodeAt(name, i);
    text += code < 0 ? name[i] : static_cast<char>(code);
    if (code >= 0) i += 2;
  }
  return text;
}

std::string Encoded(const std::string& name) {
  std::string text;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    const bool edge = i == 0 || i + 1 == name.size();
    if (c == '%' || c == ';' || c == ':' || IsControl(c) || (edge && (c == ' ' || c == '!')))
      text += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    else
      text += c;
  }
  return text;
}

/// A number at the begin of `text`, which is taken off. @return none: there is none
std::optional<double> TakeNumber(std::string_view* text) {
  double value = 0;
  // Without exponents, which could have a '-'.
  const auto [end, error] =
      std::from_chars(text->data(), text->data() + text->size(), value, std::chars_format::fixed);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  text->remove_prefix(static_cast<std::size_t>(end - text->data()));
  return value;
}

bool Take(std::string_view* text, char c) {
  if (text->empty() || text->front() != c) return false;
  text->remove_prefix(1);
  return true;
}

/// @param part  for messages
std::vector<Eigen::Vector2d> PointsOf(std::string_view text, std::string_view part) {
  std::vector<Eigen::Vector2d> points;
  do {
    const auto x = TakeNumber(&text);
    const bool comma = x && Take(&text, ',');
    const auto y = comma ? TakeNumber(&text) : std::nullopt;
    if (!y) Fail(part, "has no X,Y behind its ':'");
    if (!(*x >= 0 && *y >= 0 && *x <= kLargest_px && *y <= kLargest_px))
      Fail(part, fmt::format("has the place {},{}, which no picture has", *x, *y));
    points.emplace_back(*x, *y);
    if (points.size() > kMostPoints) Fail(part, "has too many points");
  } while (Take(&text, '-'));
  if (!text.empty()) Fail(part, "does not end after its X,Y");
  return points;
}

FigureStroke StrokeOf(std::string picture, bool figure, std::string_view points,
                      std::string_view part) {
  if (picture.empty()) Fail(part, "names no picture");
  if (picture.find('\0') != std::string::npos) Fail(part, "has a zero in the picture's name");
  return {std::move(picture), PointsOf(points, part), figure};
}

/// How well a captured picture's name answers to that of a photograph: 0 not at all.
int MatchOf(const std::string& photograph, const std::string& captured) {
  if (photograph == captured) return 4;
  const auto slash = photograph.rfind('/');
  const std::string name = slash == photograph.npos ? photograph : photograph.substr(slash + 1);
  std::string joined = photograph;
  std::replace(joined.begin(), joined.end(), '/', '_');
  if (joined == captured) return 4;
  if (name == captured) return 3;
  const auto dot = captured.rfind('.');
  if (dot == captured.npos || LowerCase(captured.substr(dot)) != ".jpg") return 0;
  const auto is_stem = [&](const std::string& text) {
    const auto end = text.rfind('.');
    return end != text.npos && text.substr(0, end) == captured.substr(0, dot);
  };
  if (is_stem(joined)) return 2;
  return is_stem(name) ? 1 : 0;
}

/// The part of a line that lies within the picture, as shares of `step`; empty (1, 0) if none does.
std::pair<double, double> ShareWithin(const Eigen::Vector2d& from, const Eigen::Vector2d& step,
                                      PictureSize picture) {
  double begin = 0, end = 1;
  for (const int axis : {0, 1}) {
    const double size = axis == 0 ? picture.width : picture.height;
    if (step[axis] == 0) {
      if (from[axis] < 0 || from[axis] > size) return {1, 0};
      continue;
    }
    const double a = -from[axis] / step[axis], b = (size - from[axis]) / step[axis];
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  return begin <= end ? std::pair(begin, end) : std::pair(1.0, 0.0);
}

bool IsTurned(PictureSize photograph, PictureSize captured) {
  return (photograph.width > photograph.height) != (captured.width > captured.height);
}

}  // namespace

std::vector<FigureStroke> ParseFigureStrokes(const std::string& text) {
  std::vector<FigureStroke> strokes;
  std::size_t points = 0;
  std::string_view rest = text;
  while (true) {
    while (!rest.empty() && IsSeparator(rest.front())) rest.remove_prefix(1);
    if (rest.empty()) return strokes;
    const std::string_view part = rest.substr(0, rest.find(';'));
    const bool figure = !Take(&rest, '!');
    const std::size_t colon = rest.substr(0, rest.find(';')).find(':');
    if (colon == rest.npos) Fail(part, "has no ':'");
    const auto* const end =
        std::find_if(rest.begin() + static_cast<std::ptrdiff_t>(colon), rest.end(), IsSeparator);
    const auto size = static_cast<std::size_t>(end - rest.begin());
    strokes.push_back(StrokeOf(Decoded(rest.substr(0, colon)), figure,
                               rest.substr(colon + 1, size - colon - 1), rest.substr(0, size)));
    points += strokes.back().points.size();
    if (points > kMostPoints) Fail(part, "is behind too many others: there are too many points");
    rest.remove_prefix(size);
  }
}

FigureStroke ParseTypedStroke(const std::string& text) {
  const auto colon = text.rfind(':');
  if (colon == text.npos) Fail(text, "has no ':'");
  return StrokeOf(text.substr(0, colon), true, std::string_view(text).substr(colon + 1), text);
}

std::string FigureText(const FigureStroke& stroke) {
  std::string text = (stroke.figure ? "" : "!") + Encoded(stroke.picture);
  char mark = ':';
  for (const Eigen::Vector2d& point : stroke.points) {
    // The shortest digits that give the same number, and never an exponent.
    char digits[800];
    for (const double value : {point.x(), point.y()}) {
      const auto end =
          std::to_chars(digits, digits + sizeof digits, value, std::chars_format::fixed);
      text += mark;
      text.append(digits, end.ptr);
      mark = ',';
    }
    mark = '-';
  }
  return text;
}

std::string FigureText(const std::vector<FigureStroke>& strokes) {
  std::string text;
  for (const FigureStroke& stroke : strokes)
    text += (text.empty() ? "" : "; ") + FigureText(stroke);
  return text;
}

std::vector<std::string> FigureTextProblems(const std::string& text) {
  try {
    ParseFigureStrokes(text);
  } catch (const UsageError& error) {
    return {error.what()};
  }
  return {};
}

int IndexOfPicture(const FigureStroke& stroke, const std::vector<std::string>& captured_names) {
  int best = -1, best_match = 0;
  for (std::size_t i = 0; i < captured_names.size(); ++i) {
    const int match = MatchOf(stroke.picture, captured_names[i]);
    if (match > best_match) {
      best = static_cast<int>(i);
      best_match = match;
    }
  }
  return best;
}

std::optional<FilmedPlace> FilmedPlaceOf(const FigureStroke& stroke) {
  const auto slash = stroke.picture.rfind('/');
  if (slash == stroke.picture.npos || slash == 0) return std::nullopt;
  FilmedPlace place;
  place.camera = stroke.picture.substr(0, slash);
  const char* const begin = stroke.picture.data() + slash + 1;
  const char* const end = stroke.picture.data() + stroke.picture.size();
  const auto [stopped, error] = std::from_chars(begin, end, place.frame);
  if (error != std::errc() || stopped != end || begin == end || place.frame < 0)
    return std::nullopt;
  return place;
}

Eigen::Vector2d InCaptured(const Eigen::Vector2d& in_photograph, PictureSize photograph,
                           PictureSize captured) {
  Eigen::Vector2d share(in_photograph.x() / photograph.width,
                        in_photograph.y() / photograph.height);
  // Clockwise, the upper left corner comes to the upper right.
  if (IsTurned(photograph, captured)) share = Eigen::Vector2d(1 - share.y(), share.x());
  return {share.x() * captured.width, share.y() * captured.height};
}

Eigen::Vector2d InPhotograph(const Eigen::Vector2d& in_captured, PictureSize captured,
                             PictureSize photograph) {
  Eigen::Vector2d share(in_captured.x() / captured.width, in_captured.y() / captured.height);
  if (IsTurned(photograph, captured)) share = Eigen::Vector2d(share.y(), 1 - share.x());
  return {share.x() * photograph.width, share.y() * photograph.height};
}

std::vector<Eigen::Vector2i> PixelsAlong(const std::vector<Eigen::Vector2d>& points,
                                         PictureSize picture) {
  std::vector<Eigen::Vector2i> pixels;
  std::set<std::pair<int, int>> seen;
  const auto add = [&](const Eigen::Vector2d& at) {
    if (!(at.x() >= 0 && at.y() >= 0 && at.x() <= picture.width && at.y() <= picture.height))
      return;
    // The right and lower border belong to the last column and row.
    const int x = std::min(static_cast<int>(at.x()), picture.width - 1);
    const int y = std::min(static_cast<int>(at.y()), picture.height - 1);
    if (seen.emplace(x, y).second) pixels.emplace_back(x, y);
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0) {
      const Eigen::Vector2d step = points[i] - points[i - 1];
      const double steps = std::ceil(2 * step.cwiseAbs().maxCoeff());
      const auto [begin, end] = ShareWithin(points[i - 1], step, picture);
      for (double k = std::max(1.0, std::floor(begin * steps)); k < steps && k <= end * steps; ++k)
        add(points[i - 1] + step * (k / steps));
    }
    add(points[i]);
  }
  return pixels;
}

}  // namespace keypose
