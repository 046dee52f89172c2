#include "studio/routes/take_puppet.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <nlohmann/json.hpp>

#include "core/values/errors.h"
#include "studio/runs/armature_control.h"
#include "studio/runs/children.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kPatience_s = 60;

json FittingPuppets(const fs::path& project, const std::string& take) {
  const std::string curves = "armature/" + take + "/curves.json";
  const ChildResult result =
      RunChild({ArmatureProgram().string(), "files", "--folder", "armature", "--curves", curves},
               project, kPatience_s);
  if (result.exit_code != 0) throw UsageError(ErrorIn(result.output, result.exit_code));
  return json::parse(result.output).at("puppets");
}

/// The first of these that is there; "" for none.
std::string FirstOf(const fs::path& project, const fs::path& stem,
                    std::initializer_list<const char*> endings) {
  std::error_code error;
  for (const char* ending : endings) {
    fs::path file = stem;
    file += ending;
    if (fs::is_regular_file(project / file, error)) return file.generic_string();
  }
  return "";
}

json WithFilesBeside(const fs::path& project, json setup) {
  const fs::path description = setup.at("description").get<std::string>(),
                 skeleton = setup.at("skeleton").get<std::string>();
  const fs::path named = skeleton.empty() ? description : skeleton;
  const fs::path stem = named.parent_path() / named.stem(), folder = description.parent_path();
  setup["mesh"] = FirstOf(project, stem, {".ply", ".obj", ".off", ".stl"});
  setup["texture"] = setup["mesh"] == "" ? "" : FirstOf(project, stem, {".png", ".jpg", ".jpeg"});
  setup["plate"] = FirstOf(project, folder / "plate", {".png", ".jpg", ".jpeg"});
  setup["shot"] = FirstOf(project, folder / "shot", {".json"});
  setup["set"] = FirstOf(project, folder / "set", {".ply", ".obj", ".off", ".stl"});
  return setup;
}

}  // namespace

json PuppetOfTake(const fs::path& project, const std::string& take, const json& last) {
  const json puppets = FittingPuppets(project, take);
  const auto is_last = [&](const json& puppet) {
    return last.is_object() && puppet.at("description") == last.value("description", "");
  };
  if (std::any_of(puppets.begin(), puppets.end(), is_last)) return last;
  if (puppets.empty())
    throw UsageError(
        fmt::format("no description below the folder 'armature' has the joints of the take {0}, or "
                    "it has no chain file: put there the files that {0} was recorded with",
                    take));
  json setup = WithFilesBeside(project, puppets.front());
  setup.update({{"port", "simulated"}, {"fps", 24}, {"step", 1}});
  return setup;
}

}  // namespace keypose::studio
