#include "pipeline/graph/pair_sources.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/values/errors.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

/// Words are plural or singular: the landmarks, the armature.
bool IsPlural(const std::string& word) { return word.ends_with("s"); }

/// The folders of defaults whose files bear a pose's name, each with the endings there.
std::vector<std::pair<fs::path, std::set<std::string>>> NamedFolders(const SourceRule& rule) {
  std::vector<std::pair<fs::path, std::set<std::string>>> folders;
  for (const Setting& pattern : rule.defaults) {
    const fs::path path = pattern.text;
    if (path.stem() != "{pose}" || path.parent_path().string().find('{') != std::string::npos)
      continue;
    const auto same = [&](const auto& folder) { return folder.first == path.parent_path(); };
    auto it = std::find_if(folders.begin(), folders.end(), same);
    if (it == folders.end()) it = folders.insert(it, {path.parent_path(), {}});
    it->second.insert(path.extension().string());
  }
  return folders;
}

/// What is said of a file that bears no pose's name: a pose that was renamed left it.
std::string Strays(const Sources& sources, const SourceRule& rule,
                   const std::vector<PoseRule>& all) {
  std::string strays;
  for (const auto& [folder, endings] : NamedFolders(rule)) {
    for (const fs::path file : sources.Children(folder)) {
      const std::string name = file.stem().string(), whole = (folder / file).generic_string();
      const bool named = std::any_of(all.begin(), all.end(), [&](const PoseRule& pose) {
        const Setting* given = pose.Given(rule.word);
        return pose.name == name || (given && given->text == whole);
      });
      if (!named && endings.contains(file.extension().string()))
        strays += (strays.empty() ? "" : ", ") + whole;
    }
  }
  if (strays.empty()) return "";
  return fmt::format("; {} bears the name of no pose: if this pose was called so, rename the file",
                     strays);
}

/// Of a file that lies at a later default, while another one is taken.
void AddSecondFiles(const Sources& sources, const SourceRule& rule, const PoseRule& pose,
                    const Setting& taken, std::vector<std::string>* warnings) {
  for (std::size_t i = 1; i < rule.defaults.size(); ++i) {
    const std::string second = sources.Filled(rule.defaults[i].text, rule, &pose).value_or("");
    if (second.empty() || second == taken.text || !sources.IsThere({second, pose.where})) continue;
    warnings->push_back(
        fmt::format("{} is not used, because {} is there too; delete the one that is not meant",
                    second, taken.text));
  }
}

}  // namespace

void RequireNamedFiles(const Sources& sources, const SourceRule& rule,
                       const std::vector<const PoseRule*>& poses) {
  for (const PoseRule* pose : poses) {
    const Setting* named = pose->Given(rule.word);
    if (!named || sources.IsThere(*named)) continue;
    const bool plural = IsPlural(rule.word);
    throw InputError(
        fmt::format("{}: the {} {} of pose '{}' {} not exist; put {} there, or correct the line",
                    named->where.Text(), rule.word, named->text, pose->name, plural ? "do" : "does",
                    plural ? "them" : "it"));
  }
}

std::vector<std::string> PairWarnings(const Sources& sources, const SourceRule& rule,
                                      const std::vector<const PoseRule*>& poses,
                                      const std::vector<PoseRule>& all) {
  std::vector<std::string> warnings;
  for (const PoseRule* pose : poses) {
    const std::optional<Setting> file = sources.PathOf(rule, pose);
    if (!file) continue;
    AddSecondFiles(sources, rule, *pose, *file, &warnings);
    for (const PoseRule* other : poses) {
      if (sources.PathOf(rule, other)) continue;
      const std::string todo = rule.unpaired.empty()
                                   ? ""
                                   : "; " + sources.Filled(rule.unpaired, rule, other).value_or("");
      warnings.push_back(fmt::format(
          "{} is not used: pose '{}' has no {} to pair {} with{}{}", file->text, other->name,
          rule.word, IsPlural(rule.word) ? "them" : "it", todo, Strays(sources, rule, all)));
    }
  }
  return warnings;
}

}  // namespace keypose::pipeline
