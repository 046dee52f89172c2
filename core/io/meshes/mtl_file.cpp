#include "core/io/meshes/mtl_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <utility>

#include "core/values/file_names.h"

namespace keypose {
namespace {

constexpr std::string_view kSpaces = " \t\r\v\f";

std::string_view Trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kSpaces);
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(kSpaces) + 1 - begin);
}

/// Takes the first word off a text.
std::string_view TakeWord(std::string_view* text) {
  *text = Trimmed(*text);
  const std::string_view word = text->substr(0, text->find_first_of(kSpaces));
  text->remove_prefix(word.size());
  return word;
}

bool IsNumber(std::string_view word, double* value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const char* const stop = word.data() + word.size();
  const auto [end, error] = std::from_chars(word.data(), stop, *value);
  return error == std::errc() && end == stop && std::isfinite(*value);
}

/// Takes up to `most` numbers off a text. A word is no number if nothing would remain for the
/// texture's name.
std::vector<double> TakeNumbers(std::string_view* text, std::size_t most) {
  std::vector<double> numbers;
  double value = 0;
  while (numbers.size() < most) {
    std::string_view rest = *text;
    const std::string_view word = TakeWord(&rest);
    if (!IsNumber(word, &value) || Trimmed(rest).empty()) break;
    numbers.push_back(value);
    *text = rest;
  }
  return numbers;
}

/// Numbers that an option may have at most, or -1: it has one word.
const std::map<std::string, int>& Options() {
  static const std::map<std::string, int> options = {
      {"-s", 3},       {"-o", 3},      {"-t", 3},        {"-mm", 2},         {"-bm", 1},
      {"-boost", 1},   {"-texres", 2}, {"-clamp", -1},   {"-cc", -1},        {"-blendu", -1},
      {"-blendv", -1}, {"-type", -1},  {"-imfchan", -1}, {"-colorspace", -1}};
  return options;
}

void Apply(const std::string& option, const std::vector<double>& numbers, MtlMap* map) {
  const auto into = [&](Eigen::Vector2d* value) {
    for (std::size_t k = 0; k < std::min<std::size_t>(2, numbers.size()); ++k)
      (*value)[static_cast<Eigen::Index>(k)] = numbers[k];
  };
  if (option == "-s") into(&map->scale);
  if (option == "-o") into(&map->offset);
  const bool mixed = option == "-mm" && numbers.size() == 2 && (numbers[0] != 0 || numbers[1] != 1);
  const bool rough = option == "-t" && std::any_of(numbers.begin(), numbers.end(),
                                                   [](double value) { return value != 0; });
  if (mixed || rough) map->left_out.push_back(option);
}

/// Takes one option off a text. @return whether there was one
bool TakeOption(std::string_view* text, MtlMap* map) {
  std::string_view rest = *text;
  const std::string option = LowerCase(std::string(TakeWord(&rest)));
  const auto known = Options().find(option);
  if (known == Options().end()) return false;
  if (known->second < 0) {
    const std::string value = LowerCase(std::string(TakeWord(&rest)));
    if (option == "-clamp") map->clamped = value == "on";
  } else {
    Apply(option, TakeNumbers(&rest, static_cast<std::size_t>(known->second)), map);
  }
  *text = rest;
  return true;
}

std::optional<Eigen::Vector3d> ColorOf(std::string_view text) {
  std::array<double, 3> numbers{};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string_view word = TakeWord(&text);
    if (k > 0 && word.empty()) {  // one number is grey
      numbers[k] = numbers[0];
      continue;
    }
    if (!IsNumber(word, &numbers[k])) return std::nullopt;
  }
  return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
}

/// Kd of a form that is not read: "Kd xyz"; empty: it has numbers.
std::string OtherColor(std::string_view text) {
  const std::string word = LowerCase(std::string(TakeWord(&text)));
  return word == "spectral" || word == "xyz" ? "Kd " + word : "";
}

/// The worth of a keyword as that of the colour texture; 0: it is none.
int WorthOf(const std::string& key) {
  constexpr std::array<std::pair<const char*, int>, 10> kKeys = {{{"map_emissive", 1},
                                                                  {"map_ke", 1},
                                                                  {"map_ka", 2},
                                                                  {"map_color", 3},
                                                                  {"map_albedo", 3},
                                                                  {"map_base_color", 3},
                                                                  {"map_basecolor", 3},
                                                                  {"map_basecolour", 3},
                                                                  {"map_diffuse", 3},
                                                                  {"map_kd", 4}}};
  for (const auto& [name, worth] : kKeys)
    if (key == name) return worth;
  return 0;
}

}  // namespace

MtlMap ParseMtlMap(std::string_view text) {
  MtlMap map;
  text = Trimmed(text);
  while (TakeOption(&text, &map)) text = Trimmed(text);
  if (text.size() > 1 && text.front() == '"' && text.back() == '"')
    text = text.substr(1, text.size() - 2);
  map.file = std::string(text);
  return map;
}

std::vector<MtlMaterial> ParseMtl(std::string_view text) {
  std::vector<MtlMaterial> materials;
  int worth = 0;
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::string key = LowerCase(std::string(TakeWord(&line)));
    if (key == "newmtl") {
      materials.push_back({std::string(Trimmed(line)), std::nullopt, {}, {}});
      worth = 0;
    }
    if (materials.empty()) continue;
    MtlMaterial& material = materials.back();
    if (key == "kd") {
      material.color = ColorOf(line);
      if (const std::string other = OtherColor(line); !other.empty())
        material.left_out.push_back(other);
    }
    if (WorthOf(key) <= worth) continue;
    const MtlMap map = ParseMtlMap(line);
    if (map.file.empty()) continue;
    material.map = map;
    worth = WorthOf(key);
  }
  return materials;
}

}  // namespace keypose
