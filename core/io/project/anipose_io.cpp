#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <toml.hpp>
#include <vector>

#include "core/io/project/lens_use.h"
#include "core/io/project/opencv_lens.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/project/rig_parts.h"
#include "core/io/project/rig_programs.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

/// Numbers of lists in lists; a whole one may be written without a point.
void CollectToml(const toml::value& value, int depth, std::vector<double>* numbers) {
  constexpr int kDeepest = 4;
  if (value.is_floating()) {
    numbers->push_back(value.as_floating());
  } else if (value.is_integer()) {
    numbers->push_back(static_cast<double>(value.as_integer()));
  } else if (value.is_array() && depth < kDeepest) {
    for (const toml::value& part : value.as_array()) CollectToml(part, depth + 1, numbers);
  }
}

std::vector<double> TableNumbers(const toml::value& table, const char* name, std::size_t count,
                                 const std::string& where) {
  std::vector<double> numbers;
  if (table.contains(name)) CollectToml(table.at(name), 0, &numbers);
  if (count > 0 && numbers.size() != count)
    throw InputError(fmt::format("{}: `{}` must hold {} numbers", where, name, count));
  return numbers;
}

bool IsFisheye(const toml::value& table) {
  if (!table.contains("fisheye")) return false;
  const toml::value& flag = table.at("fisheye");
  return flag.is_boolean() ? flag.as_boolean() : flag.is_integer() && flag.as_integer() != 0;
}

void AddCamera(const std::string& key, const toml::value& table, const std::string& file,
               RigCalibration* rig) {
  std::string name = key;
  if (table.contains("name") && table.at("name").is_string())
    name = table.at("name").as_string().str;
  const std::string where = file + ", camera " + name;
  const std::vector<double> k = TableNumbers(table, "matrix", 9, where),
                            d = TableNumbers(table, "distortions", 0, where),
                            size = TableNumbers(table, "size", 0, where),
                            turn = TableNumbers(table, "rotation", 3, where),
                            t = TableNumbers(table, "translation", 3, where);
  RequireUpperTriangle(k.data(), where);
  Lens lens =
      OpenCvLens(IsFisheye(table) ? "fisheye" : "", {k[0], k[4], k[2], k[5], k[1]}, d, where);
  if (size.size() == 2) {
    lens.width = SideOf(size[0]);
    lens.height = SideOf(size[1]);
  }
  View view{name,
            UsableCamera(lens, where),
            {ExactRotation(RotationOf(turn, where), where), {t[0], t[1], t[2]}}};
  RequireUsable(view, where);
  rig->views.push_back(view);
}

/// The library reads lists in lists recursively.
void RequireShallow(const std::string& text, const std::string& file) {
  constexpr int kMostOpen = 50;
  int open = 0;
  for (const char c : text) {
    if (c == '[' || c == '{') ++open;
    if ((c == ']' || c == '}') && open > 0) --open;
    if (open > kMostOpen) throw InputError(file + ": its lists are nested too deeply");
  }
}

}  // namespace

void AddAnipose(const std::string& text, const std::string& file, RigCalibration* rig) {
  RequireShallow(text, file);
  // What TOML requires; the library checks it late and reads beyond its memory to say where.
  if (!IsValidUtf8(text)) throw InputError(file + " is not UTF-8 text, as TOML must be");
  toml::value root;
  try {
    std::istringstream in(text);
    root = toml::parse(in, file);
  } catch (const std::exception& error) {
    std::string why = error.what();
    throw InputError(file + " is not whole TOML (" + why.substr(0, why.find('\n')) + ")");
  }
  for (const auto& [key, table] : root.as_table())
    if (table.is_table() && table.contains("matrix")) AddCamera(key, table, file, rig);
  std::sort(rig->views.begin(), rig->views.end(),
            [](const View& a, const View& b) { return NumberedBefore(a.name, b.name); });
  rig->format = "anipose";
}

}  // namespace keypose
