#include "capture/shoot/session/setup_state.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/shoot/session/photograph_store.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot {

using nlohmann::json;
namespace fs = std::filesystem;

SetupState ReadSetupState(const fs::path& file) try {
  SetupState setup_state;
  if (!fs::exists(file)) return setup_state;
  const std::string text = ReadFile(file);
  RequireShallowJson(text, file.string());
  const json root = json::parse(text);
  setup_state.table_deg = root.at("table_deg");
  setup_state.pose = root.value("pose", "");
  setup_state.ring = root.value("ring", 0);
  setup_state.flip = root.value("flip", 0);
  if (root.contains("turning_to")) {
    setup_state.turning_to = root.at("turning_to").get<double>();
    setup_state.memory = root.value("memory", "");
  }
  const bool fine = std::isfinite(setup_state.table_deg) && std::abs(setup_state.table_deg) < 1e6;
  return fine ? setup_state : SetupState{};
} catch (const json::exception&) {
  return {};
} catch (const InputError&) {
  return {};
}

void WriteSetupState(const fs::path& file, const SetupState& setup_state) {
  json root = {{"table_deg", setup_state.table_deg},
               {"pose", setup_state.pose},
               {"ring", setup_state.ring},
               {"flip", setup_state.flip}};
  if (setup_state.turning_to) {
    root["turning_to"] = *setup_state.turning_to;
    root["memory"] = setup_state.memory;
  }
  WriteDurably(file, root.dump() + "\n");
}

}  // namespace keypose::capture::shoot
