#include "pipeline/graph/sources.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/values/errors.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/graph/stage_info.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void FailAt(const Where& where, const std::string& message) {
  throw UsageError(fmt::format("{}: {}", where.Text(), message));
}

/// Which part of a project's file names a source.
enum class Part { kFile, kPose, kFilmedShot };

Part PartOf(const SourceRule& rule, ProjectKind kind) {
  if (rule.of == SourceOf::kProject) return Part::kFile;
  const bool filmed = rule.of == SourceOf::kShot && kind == ProjectKind::kPoses;
  return filmed ? Part::kFilmedShot : Part::kPose;
}

const SourceRule* FindIn(const std::vector<SourceRule>& rules, const std::string& word) {
  const auto it = std::find_if(rules.begin(), rules.end(),
                               [&](const SourceRule& rule) { return rule.word == word; });
  return it == rules.end() ? nullptr : &*it;
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

std::string InBraces(const std::string& word) { return "{" + word + "}"; }

/// A default may name what is known before it.
void CheckDefault(const PipelineFile& file, const SourceRule& rule, const Setting& path) {
  std::string left = path.text;
  std::vector<std::string> known;
  const Part part = PartOf(rule, file.kind);
  if (part == Part::kPose) known = {"pose", "shot"};
  for (const SourceRule& earlier : file.sources) {
    if (&earlier == &rule) break;
    if (PartOf(earlier, file.kind) == part) known.push_back(earlier.word);
  }
  for (const std::string& word : known) left = Replaced(left, InBraces(word), "");
  const std::size_t open = left.find('{');
  if (open == std::string::npos) return;
  const std::string word = left.substr(open + 1, left.find('}') - open - 1);
  FailAt(path.where, fmt::format("the default of source '{}' has {{{}}}, which is not known{}",
                                 rule.word, word, Suggestion(word, known)));
}

void CheckTable(const PipelineFile& file) {
  for (const SourceRule& rule : file.sources) {
    const SourceRule* first = FindIn(file.sources, rule.word);
    if (first != &rule)
      FailAt(rule.where, fmt::format("there is a source '{}' already, at {}; choose another word",
                                     rule.word, first->where.Text()));
    if (rule.always && rule.defaults.size() != 1)
      FailAt(rule.where,
             fmt::format("source '{}' has `always`, so it needs one default", rule.word));
    for (const Setting& path : rule.defaults) CheckDefault(file, rule, path);
  }
}

const char* Owner(const SourceRule& rule, ProjectKind kind) {
  const Part part = PartOf(rule, kind);
  if (part == Part::kFile) return "the project: it stands at the top of the file";
  if (part == Part::kFilmedShot) return "the filmed shot: it stands below `shot`";
  return kind == ProjectKind::kPoses ? "a pose: it stands below one in `poses`"
                                     : "a shot: it stands below one in `shots`";
}

/// @param what   the part of the file, for messages
/// @param fixed  its keys that are no words of the table
void CheckGiven(const PipelineFile& file, const GivesSources& from, Part part,
                const std::string& what, const std::vector<std::string>& fixed) {
  for (const GivenSource& given : from.given) {
    const SourceRule* rule = FindIn(file.sources, given.word);
    if (rule && PartOf(*rule, file.kind) != part)
      FailAt(given.key, fmt::format("{} has no key '{}'; that is of {}", what, given.word,
                                    Owner(*rule, file.kind)));
    if (!rule) {
      std::vector<std::string> known;
      for (const SourceRule& other : file.sources)
        if (PartOf(other, file.kind) == part) known.push_back(other.word);
      known.insert(known.end(), fixed.begin(), fixed.end());
      FailAt(given.key,
             fmt::format("{} has no key '{}'{}", what, given.word, Suggestion(given.word, known)));
    }
    if (!rule->kind.empty() && rule->kind != NameOf(file.kind))
      FailAt(given.key, OfOtherKind(given.word, file.kind));
    if (!given.fault.empty()) throw UsageError(given.fault);
  }
}

}  // namespace

std::string PhotographsOf(const PoseRule& pose) {
  const Setting* given = pose.Given(kPhotosWord);
  return WithHome(given ? given->text : "photos/" + pose.name);
}

std::string VideoOf(const PoseRule& shot) {
  const Setting* given = shot.Given(kVideoWord);
  return WithHome(given ? given->text : "shots/" + shot.name);
}

void CheckSources(const PipelineFile& file) {
  CheckTable(file);
  CheckGiven(file, file, Part::kFile, "the pipeline", kFileKeys);
  if (file.shot) CheckGiven(file, *file.shot, Part::kFilmedShot, "shot", kFilmedShotKeys);
  const bool shots = file.kind == ProjectKind::kPerformance;
  for (const PoseRule& pose : file.poses)
    CheckGiven(file, pose, Part::kPose, fmt::format("{} '{}'", shots ? "shot" : "pose", pose.name),
               shots ? kShotKeys : kPoseKeys);
}

Sources::Sources(const PipelineFile& file, const Disk& disk, fs::path project,
                 const std::string& template_pose)
    : file_(file),
      disk_(disk),
      project_(std::move(project)),
      template_(file.FindPose(template_pose)) {}

const SourceRule* Sources::Find(const std::string& word) const {
  return FindIn(file_.sources, word);
}

std::vector<std::string> Sources::Words() const {
  std::vector<std::string> words;
  for (const SourceRule& rule : file_.sources) words.push_back("$" + rule.word);
  if (Knows(kUnmaskedWord)) words.push_back(std::string("$") + kUnmaskedWord);
  return words;
}

bool Sources::Knows(const std::string& word) const {
  return Find(word == kUnmaskedWord ? kVideoWord : word) != nullptr;
}

bool Sources::IsOfPose(const std::string& word) const {
  if (word == kUnmaskedWord) return true;
  const SourceRule* rule = Find(word);
  return rule && PartOf(*rule, file_.kind) == Part::kPose;
}

std::optional<Setting> Sources::PathOf(const SourceRule& rule, const PoseRule* pose) const {
  const Part part = PartOf(rule, file_.kind);
  const GivesSources* from = &file_;
  if (part == Part::kPose) from = pose;
  if (part == Part::kFilmedShot) from = file_.shot ? &*file_.shot : nullptr;
  if (!from) return std::nullopt;
  if (const Setting* given = from->Given(rule.word)) return *given;
  return DefaultOf(rule, part == Part::kPose ? pose : nullptr);
}

std::optional<Setting> Sources::DefaultOf(const SourceRule& rule, const PoseRule* pose) const {
  for (const Setting& pattern : rule.defaults) {
    const std::optional<std::string> filled = Filled(pattern.text, rule, pose);
    if (!filled) continue;
    const Setting path{*filled, pose ? pose->where : pattern.where};
    if (path.text.ends_with(".*")) {
      if (auto found = WithAnyEnding(path)) return found;
    } else if (rule.always || IsThere(path)) {
      return path;
    }
  }
  return std::nullopt;
}

std::optional<Setting> Sources::WithAnyEnding(const Setting& pattern) const {
  const fs::path path = WithHome(pattern.text);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const auto stat = disk_.Stat(project_ / folder);
  if (!stat || !stat->folder) return std::nullopt;
  for (const std::string& name : disk_.Children(project_ / folder))
    if (fs::path(name).stem() == path.stem())
      return Setting{(folder / name).lexically_normal().string(), pattern.where};
  return std::nullopt;
}

std::vector<const PoseRule*> Sources::PosesOf(const SourceRule& rule, const PoseRule* pose) const {
  if (rule.of == SourceOf::kPair && template_ && pose != template_) return {template_, pose};
  return {pose};
}

std::vector<Setting> Sources::PathsOf(const SourceRule& rule, const PoseRule* pose) const {
  std::vector<Setting> paths;
  for (const PoseRule* of : PosesOf(rule, pose)) {
    const std::optional<Setting> path = PathOf(rule, of);
    if (!path) return {};
    paths.push_back(*path);
  }
  return paths;
}

bool Sources::Gives(const std::string& word, const PoseRule* pose) const {
  if (word == kUnmaskedWord) return pose && IsUnmasked(*pose);
  const SourceRule* rule = Find(word);
  return rule && !PathsOf(*rule, pose).empty();
}

bool Sources::IsUnmasked(const PoseRule& shot) const {
  const SourceRule* video = Find(kVideoWord);
  const std::optional<Setting> films = video ? PathOf(*video, &shot) : std::nullopt;
  return films && !disk_.Stat(project_ / WithHome(films->text) / "masks");
}

std::optional<std::string> Sources::Filled(const std::string& text, const SourceRule& rule,
                                           const PoseRule* pose) const {
  std::string filled = text;
  for (const SourceRule& earlier : file_.sources) {
    if (earlier.word == rule.word) break;
    if (filled.find(InBraces(earlier.word)) == std::string::npos) continue;
    const std::optional<Setting> path = PathOf(earlier, pose);
    if (!path) return std::nullopt;
    filled = Replaced(filled, InBraces(earlier.word), WithHome(path->text));
  }
  if (!pose) return filled;
  return Replaced(Replaced(filled, "{pose}", pose->name), "{shot}", pose->name);
}

fs::path Sources::Located(const Setting& path) const {
  return OnDisk(disk_, project_, fs::path(WithHome(path.text)).lexically_normal());
}

bool Sources::IsThere(const Setting& path) const {
  return disk_.Stat(project_ / Located(path)).has_value();
}

std::vector<std::string> Sources::Children(const fs::path& folder) const {
  return disk_.Children(project_ / folder);
}

}  // namespace keypose::pipeline
