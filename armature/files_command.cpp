// `keypose armature files`: which descriptions below a folder a take was recorded with, each with
// the chain file and the skeleton that go with it. A take holds only its joints' names.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "armature/armature_commands.h"
#include "armature/description/chain_file.h"
#include "armature/description/description_file.h"
#include "armature/puppet.h"
#include "armature/recording/joint_curves.h"
#include "core/io/meshes/bvh_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::armature {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Texts that are larger are no descriptions, and folders that are deeper are not looked into.
constexpr std::uintmax_t kLargestText = 4'000'000;
constexpr int kDeepest = 4;
constexpr std::size_t kMostFiles = 1000;

struct FilesFlags {
  std::string folder, curves;
};

/// Files of an ending below the folder, by name; takes and links are left out.
std::vector<fs::path> FilesOf(const fs::path& folder, const std::string& ending) {
  std::vector<fs::path> files;
  std::error_code error;
  fs::recursive_directory_iterator at(folder, error);
  if (error)
    throw DiskError(
        fmt::format("cannot read the folder {}: {}", PrintableName(folder), error.message()));
  for (; !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
    if (at->is_directory(error)) {
      const bool take = fs::exists(at->path() / "curves.json", error);
      if (take || at.depth() >= kDeepest) at.disable_recursion_pending();
    } else if (files.size() < kMostFiles && !at->is_symlink(error) && at->is_regular_file(error) &&
               at->path().extension() == ending) {
      files.push_back(at->path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// What `read` makes of the file; nothing if that is no such file.
template <class Read>
auto Tried(const fs::path& file, const Read& read) -> std::optional<decltype(read())> {
  std::error_code error;
  if (fs::file_size(file, error) > kLargestText || error) return std::nullopt;
  try {
    return read();
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// Whether the curves are of exactly this armature's joints.
bool AreOf(const std::string& curves, const std::string& file, const Armature& armature) {
  ParseCurvesJson(curves, file, armature);
  return json::parse(curves).at("joints").size() == armature.joints.size();
}

bool HasJointsOf(const MotionClip& clip, const ChainPlan& plan) {
  const auto has = [&](const std::string& name) { return clip.Find(name) >= 0; };
  return std::all_of(plan.anchors.begin(), plan.anchors.end(),
                     [&](const Anchor& anchor) { return has(anchor.computer); }) &&
         std::all_of(plan.chains.begin(), plan.chains.end(), [&](const Chain& chain) {
           return std::all_of(chain.computer.begin(), chain.computer.end(), has);
         });
}

/// Those in the folder of `beside` first.
std::vector<fs::path> NearestFirst(std::vector<fs::path> files, const fs::path& beside) {
  std::stable_partition(files.begin(), files.end(), [&](const fs::path& file) {
    return file.parent_path() == beside.parent_path();
  });
  return files;
}

/// The puppet of a description, as far as there are files for it; nothing without chains.
std::optional<json> PuppetOf(const FilesFlags& flags, const fs::path& description,
                             const Armature& armature) {
  for (const fs::path& file : NearestFirst(FilesOf(flags.folder, ".txt"), description)) {
    const auto plan =
        Tried(file, [&] { return ParseChains(ReadFile(file), PrintableName(file), armature); });
    if (file == description || !plan || plan->anchors.empty()) continue;
    json puppet = {
        {"description", description.string()}, {"chains", file.string()}, {"skeleton", ""}};
    for (const fs::path& bvh : NearestFirst(FilesOf(flags.folder, ".bvh"), description)) {
      if (!Tried(bvh, [&] { return HasJointsOf(ReadBvh(bvh), *plan); }).value_or(false)) continue;
      puppet["skeleton"] = bvh.string();
      break;
    }
    return puppet;
  }
  return std::nullopt;
}

int TellFiles(const FilesFlags& flags) {
  const std::string curves = ReadFile(flags.curves), name = PrintableName(flags.curves);
  json puppets = json::array();
  for (const fs::path& file : FilesOf(flags.folder, ".txt")) {
    const auto armature = Tried(file, [&] { return LoadArmature(file); });
    if (!armature || !Tried(file, [&] { return AreOf(curves, name, *armature); }).value_or(false))
      continue;
    if (const auto puppet = PuppetOf(flags, file, *armature)) puppets.push_back(*puppet);
  }
  fmt::print("{}\n",
             json{{"puppets", puppets}}.dump(-1, ' ', false, json::error_handler_t::replace));
  return static_cast<int>(ExitCode::kOk);
}

}  // namespace

int FilesCommand(int argc, char** argv) {
  CLI::App app("Finds the puppet's files that a take was recorded with.", "keypose armature files");
  FilesFlags flags;
  app.add_option("--folder", flags.folder, "where descriptions, chains and skeletons are")
      ->required();
  app.add_option("--curves", flags.curves, "recorded curves (curves.json of a session)")
      ->required();
  app.footer(
      "It writes {\"puppets\": [{\"description\", \"chains\", \"skeleton\"}]}: a description whose "
      "joints are those of the curves, the chain file that fits it, and the skeleton (\"\": none) "
      "that has the joints of the chains.");
  return RunCommandLine(app, argc, argv, [&] { return TellFiles(flags); });
}

}  // namespace keypose::armature
