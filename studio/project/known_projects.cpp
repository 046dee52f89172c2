#include "studio/project/known_projects.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::size_t kMostKnown = 50;

fs::path ListIn(const fs::path& state) { return state / "projects.json"; }

void Keep(const fs::path& state, const std::vector<KnownProject>& projects) {
  json list = json::array();
  for (const KnownProject& one : projects)
    list.push_back({{"folder", one.folder.string()}, {"opened", one.opened}});
  try {
    fs::create_directories(state);
    WriteFileAtomically(ListIn(state), json{{"projects", list}}.dump(1) + "\n");
  } catch (const std::exception&) {
    // A list of what was opened is no reason to keep somebody from a project.
  }
}

std::vector<KnownProject> Without(std::vector<KnownProject> projects, const fs::path& folder) {
  std::erase_if(projects, [&](const KnownProject& one) { return one.folder == folder; });
  return projects;
}

}  // namespace

fs::path UserStateFolder() {
  const auto folder_in = [](const char* name) {
    const char* value = std::getenv(name);
    return fs::path(value && value[0] == '/' ? value : "");
  };
  if (const fs::path own = folder_in("KEYPOSE_HOME"); !own.empty()) return own;
  if (const fs::path state = folder_in("XDG_STATE_HOME"); !state.empty()) return state / "keypose";
  const fs::path home = folder_in("HOME");
  return home.empty() ? home : home / ".local/state/keypose";
}

bool IsProject(const fs::path& folder) {
  std::error_code none;
  return fs::is_regular_file(folder / "pipeline.yaml", none) ||
         fs::is_directory(folder / "armature", none);
}

fs::path FolderToOpen(const std::string& given) {
  fs::path folder = fs::path(given).lexically_normal();
  if (!folder.is_absolute())
    throw UsageError(fmt::format("'{}' is no whole path: it begins with / or ~/", given));
  std::error_code none;
  if (folder.filename() == "pipeline.yaml" && fs::is_regular_file(folder, none))
    folder = folder.parent_path();
  if (!fs::is_directory(folder, none))
    throw UsageError(fmt::format("{} is not there, or is no folder", folder.string()));
  folder = fs::canonical(folder);
  if (IsProject(folder) || fs::is_empty(folder, none)) return folder;
  std::string within;
  for (fs::directory_iterator at(folder, none), end; !none && at != end; at.increment(none))
    if (within.empty() && IsProject(at->path())) within = at->path().filename().string();
  throw UsageError(
      fmt::format("{} is no project: it has no pipeline.yaml{}", folder.string(),
                  within.empty() ? "; make a new project, which copies photographs into its folder"
                                 : "; its folder '" + within + "' is one"));
}

std::vector<KnownProject> KnownProjects(const fs::path& state) {
  std::vector<KnownProject> projects;
  std::error_code none;
  if (state.empty() || !fs::is_regular_file(ListIn(state), none)) return projects;
  try {
    const json list = json::parse(ReadFile(ListIn(state))).at("projects");
    for (const json& one : list) {
      const fs::path folder = one.at("folder").get<std::string>();
      const bool there = IsProject(folder);
      projects.push_back({folder, one.at("opened").get<double>(), there});
    }
  } catch (const std::exception&) {
    return {};
  }
  return projects;
}

void Remember(const fs::path& state, const fs::path& folder, double now) {
  if (state.empty()) return;
  std::vector<KnownProject> projects = Without(KnownProjects(state), folder);
  projects.insert(projects.begin(), {folder, now, true});
  projects.resize(std::min(projects.size(), kMostKnown));
  Keep(state, projects);
}

void ForgetProject(const fs::path& state, const fs::path& folder) {
  if (!state.empty()) Keep(state, Without(KnownProjects(state), folder));
}

fs::path NewProjectFolder(const fs::path& base, const std::string& name) {
  constexpr std::size_t kLongest = 100;  // bytes
  if (name.size() > kLongest)
    throw UsageError(
        fmt::format("the name of a project has at most {} letters, this one more", kLongest));
  // What no other system takes in a folder's name is left out here too: projects travel.
  const bool odd =
      name.empty() || name.front() == '.' || std::any_of(name.begin(), name.end(), [](char one) {
        return static_cast<unsigned char>(one) < ' ' || std::strchr("/\\:*?\"<>|", one);
      });
  if (odd)
    throw UsageError(
        fmt::format("'{}' is no name for a project: letters, digits, spaces and dashes", name));
  const fs::path folder = base / name;
  std::error_code none;
  if (fs::exists(folder, none) && !(fs::is_directory(folder, none) && fs::is_empty(folder, none)))
    throw UsageError(fmt::format(
        "{} is there already; open it, or give the new project another name", folder.string()));
  fs::create_directories(folder, none);
  if (!fs::is_directory(folder, none))
    throw DiskError(fmt::format("cannot make the folder {}", folder.string()));
  return folder;
}

}  // namespace keypose::studio
