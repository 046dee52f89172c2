#include "core/io/project/frame_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>

namespace keypose {
namespace {

constexpr std::size_t kMostDigits = 18;
constexpr std::size_t kMostCounted = 9;  // digits; longer numbers are times
constexpr double kEven = 0.9;            // of the steps of a counter

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

/// A number in a name.
struct Field {
  std::size_t at = 0, length = 0;
  long value = 0;
};

struct Name {
  const std::string* stem = nullptr;
  std::vector<Field> fields;
};

/// @return without fields of more digits than a number can have
Name Parsed(const std::string& stem) {
  Name name{&stem, {}};
  for (std::size_t i = 0; i < stem.size();) {
    std::size_t end = i;
    while (end < stem.size() && IsDigit(stem[end])) ++end;
    if (end > i && end - i <= kMostDigits)
      name.fields.push_back({i, end - i, std::stol(stem.substr(i, end - i))});
    i = std::max(end, i + 1);
  }
  return name;
}

/// Alone between marks, as in f_-2; in shot-2 and 2024-05 it parts.
bool HasMinus(const Name& name, const Field& field) {
  const std::string& stem = *name.stem;
  if (field.at == 0 || stem[field.at - 1] != '-') return false;
  return field.at == 1 || !std::isalnum(static_cast<unsigned char>(stem[field.at - 2]));
}

/// Values of one field in all names.
std::vector<long> Values(const std::vector<Name>& names, std::size_t field) {
  std::vector<long> values;
  for (const Name& name : names) {
    const Field& one = name.fields[field];
    values.push_back(HasMinus(name, one) ? -one.value : one.value);
  }
  return values;
}

std::vector<std::size_t> Differing(const std::vector<Name>& names) {
  std::vector<std::size_t> differing;
  for (std::size_t f = 0; f < names.front().fields.size(); ++f) {
    const std::vector<long> values = Values(names, f);
    if (std::any_of(values.begin(), values.end(), [&](long v) { return v != values[0]; }))
      differing.push_back(f);
  }
  return differing;
}

/// All different, and most steps between them are the same.
bool RunsEvenly(std::vector<long> values) {
  std::sort(values.begin(), values.end());
  std::map<long, int> steps;
  for (std::size_t i = 1; i < values.size(); ++i) ++steps[values[i] - values[i - 1]];
  if (steps.contains(0)) return false;
  const auto most = std::max_element(
      steps.begin(), steps.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most->second >= kEven * static_cast<double>(values.size() - 1);
}

/// The places of values in their order; equal ones share one.
template <class T>
std::vector<long> Ranks(const std::vector<T>& values) {
  std::vector<T> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  std::vector<long> ranks;
  for (const T& value : values)
    ranks.push_back(std::lower_bound(sorted.begin(), sorted.end(), value) - sorted.begin());
  return ranks;
}

/// A counter of so many digits that ran over goes on behind its largest number.
void UnrollCounter(const std::vector<Name>& names, std::size_t field, std::vector<long>* values) {
  const std::size_t digits = names.front().fields[field].length;
  if (digits < 4 || digits > kMostCounted) return;
  for (const Name& name : names)
    if (name.fields[field].length != digits) return;
  long limit = 1;
  for (std::size_t i = 0; i < digits; ++i) limit *= 10;
  std::vector<long> sorted = *values;
  std::sort(sorted.begin(), sorted.end());
  if (sorted.front() < 0 || sorted.front() > 1 || sorted.back() != limit - 1) return;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i] - sorted[i - 1] <= limit / 2) continue;
    for (long& value : *values)
      if (value < sorted[i]) value += limit - sorted.front();
  }
}

/// @param hhmmss  as a whole number
bool IsTime(long hhmmss) {
  return hhmmss / 10000 < 24 && hhmmss / 100 % 100 < 60 && hhmmss % 100 < 60;
}

/// The fields of a date and a time of day from `first` on: 2024 05 03 14 03 57, 20240503 140357,
/// 20240503140357, each with parts of a second or without. @return how many; 0: none
std::size_t DateAt(const Name& name, std::size_t first) {
  const auto digits = [&](std::size_t i) {
    return first + i < name.fields.size() ? name.fields[first + i].length : 0;
  };
  const auto value = [&](std::size_t i) { return name.fields[first + i].value; };
  const auto year = [](long v) { return v >= 1900 && v < 2200; };
  std::size_t date = 0;
  if (digits(0) == 4 && year(value(0)) && digits(1) == 2 && digits(2) == 2) date = 3;
  if (digits(0) == 8 && year(value(0) / 10000)) date = 1;
  if ((digits(0) == 14 || digits(0) == 17) &&
      year(std::stol(name.stem->substr(name.fields[first].at, 4))))
    return 1;
  if (date == 0) return 0;
  if (digits(date) == 6) return IsTime(value(date)) ? date + 1 : 0;
  if (digits(date) == 9) return IsTime(value(date) / 1000) ? date + 1 : 0;
  const bool clock =
      digits(date) >= 1 && digits(date) <= 2 && digits(date + 1) == 2 && digits(date + 2) == 2;
  if (!clock) return 0;
  return date + (digits(date + 3) > 0 && digits(date + 3) != 4 ? 4 : 3);
}

/// Hours of clocks of twice twelve.
long HourShift(const std::string& stem, long hour) {
  if (stem.find("PM") != std::string::npos || stem.find("pm") != std::string::npos)
    return hour < 12 ? 12 : 0;
  if (stem.find("AM") != std::string::npos || stem.find("am") != std::string::npos)
    return hour == 12 ? -12 : 0;
  return 0;
}

/// The order of names whose numbers differ only within a date with a time; nothing where they do
/// elsewhere too.
std::optional<std::vector<long>> OrderByDate(const std::vector<Name>& names,
                                             const std::vector<std::size_t>& differing) {
  std::size_t first = 0, count = 0;
  for (std::size_t f = 0; f < names.front().fields.size() && count == 0; ++f) {
    first = f;
    count = DateAt(names.front(), f);
  }
  if (count == 0 || differing.front() < first || differing.back() >= first + count) return {};
  std::vector<std::vector<long>> moments;
  for (const Name& name : names) {
    if (DateAt(name, first) != count) return {};
    std::vector<long> moment;
    for (std::size_t f = first; f < first + count; ++f) moment.push_back(name.fields[f].value);
    if (count >= 6) moment[3] += HourShift(*name.stem, moment[3]);
    moments.push_back(std::move(moment));
  }
  return Ranks(moments);
}

/// The words for two numbers of a name.
std::string Ambiguous(const Name& name, const std::vector<std::size_t>& fields) {
  const auto text = [&](std::size_t f) {
    return name.stem->substr(name.fields[f].at, name.fields[f].length);
  };
  return fmt::format(
      "the names differ in more than one number (of {}: {} and {}), and none of them counts frames "
      "by itself; move pictures of other takes, exposures or cameras to folders of their own",
      *name.stem, text(fields.front()), text(fields.back()));
}

FrameNumbering ByField(const std::vector<Name>& names, std::size_t field) {
  FrameNumbering numbering{Values(names, field), true, ""};
  numbering.counted = std::all_of(names.begin(), names.end(), [&](const Name& name) {
    return name.fields[field].length <= kMostCounted;
  });
  if (numbering.counted)
    UnrollCounter(names, field, &numbering.numbers);
  else
    numbering.numbers = Ranks(numbering.numbers);
  return numbering;
}

FrameNumbering OfLikeNames(const std::vector<Name>& names) {
  const std::vector<std::size_t> differing = Differing(names);
  if (differing.empty()) return ByField(names, names.front().fields.size() - 1);
  if (const auto order = OrderByDate(names, differing)) return {*order, false, ""};
  if (differing.size() == 1) return ByField(names, differing.front());
  std::vector<std::size_t> even;
  for (const std::size_t f : differing)
    if (RunsEvenly(Values(names, f))) even.push_back(f);
  for (const std::size_t f : even)
    if (Ranks(Values(names, f)) != Ranks(Values(names, even.back())))
      return {{}, true, Ambiguous(names.front(), differing)};
  if (even.empty()) return {{}, true, Ambiguous(names.front(), differing)};
  return ByField(names, even.back());
}

/// By the last number of each name.
FrameNumbering ByLast(std::vector<Name> names) {
  for (Name& name : names) name.fields = {name.fields.back()};
  return ByField(names, 0);
}

}  // namespace

FrameNumbering NumberNames(const std::vector<std::string>& stems) {
  std::vector<Name> names;
  std::map<std::size_t, int> counts;
  for (const std::string& stem : stems) {
    names.push_back(Parsed(stem));
    if (names.back().fields.empty())
      return {{},
              true,
              fmt::format("{} has no frame number in its name, such as 0012; rename it, or move it "
                          "elsewhere",
                          stem)};
    ++counts[names.back().fields.size()];
  }
  if (names.empty()) return {};
  if (counts.size() == 1) return OfLikeNames(names);
  const auto most =
      std::max_element(counts.begin(), counts.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  if (2 * most->second <= static_cast<int>(names.size())) return ByLast(std::move(names));
  const auto is_like = [&](const Name& name) { return name.fields.size() == most->first; };
  const auto odd = std::find_if_not(names.begin(), names.end(), is_like);
  const auto like = std::find_if(names.begin(), names.end(), is_like);
  return {{},
          true,
          fmt::format("{} is not numbered as the others are, such as {}; rename it, or move it "
                      "elsewhere",
                      *odd->stem, *like->stem)};
}

}  // namespace keypose
