#include "capture/shoot/session/stand.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/shoot/session/landing.h"
#include "core/values/errors.h"
#include "core/io/text/files.h"

namespace keypose::capture::shoot {

using nlohmann::json;
namespace fs = std::filesystem;

Stand ReadStand(const fs::path& file) try {
  Stand stand;
  if (!fs::exists(file)) return stand;
  const std::string text = ReadFile(file);
  RequireShallowJson(text, file.string());
  const json root = json::parse(text);
  stand.table_deg = root.at("table_deg");
  stand.pose = root.value("pose", "");
  stand.ring = root.value("ring", 0);
  stand.flip = root.value("flip", 0);
  if (root.contains("turning_to")) {
    stand.turning_to = root.at("turning_to").get<double>();
    stand.memory = root.value("memory", "");
  }
  const bool fine = std::isfinite(stand.table_deg) && std::abs(stand.table_deg) < 1e6;
  return fine ? stand : Stand{};
} catch (const json::exception&) {
  return {};
} catch (const InputError&) {
  return {};
}

void WriteStand(const fs::path& file, const Stand& stand) {
  json root = {{"table_deg", stand.table_deg},
               {"pose", stand.pose},
               {"ring", stand.ring},
               {"flip", stand.flip}};
  if (stand.turning_to) root["turning_to"] = *stand.turning_to, root["memory"] = stand.memory;
  WriteDurably(file, root.dump() + "\n");
}

}  // namespace keypose::capture::shoot
