#include "studio/project/bin.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/io/pictures/photograph_files.h"
#include "core/io/text/files.h"
#include "core/io/text/pose_yaml.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/disk/real_disk.h"
#include "studio/project/changes.h"
#include "studio/project/left_out_photographs.h"
#include "studio/project/not_found.h"
#include "studio/project/own_masks.h"
#include "studio/project/pose_list.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* kBin = "bin";
constexpr const char* kDeleted = "deleted.json";

bool IsNumber(const std::string& name) {
  return !name.empty() && name.size() < 9 &&
         std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; });
}

std::vector<std::string> EntryIds(const fs::path& project) {
  std::vector<std::string> ids;
  for (const std::string& name : pipeline::RealDisk().Children(project / kBin))
    if (IsNumber(name)) ids.push_back(name);
  std::sort(ids.begin(), ids.end(),
            [](const auto& a, const auto& b) { return std::stoi(a) > std::stoi(b); });
  return ids;
}

json DeletedJson(const fs::path& project, const std::string& id) {
  const fs::path file = project / kBin / id / kDeleted;
  if (!fs::is_regular_file(file)) return json::object();
  const std::string text = ReadFile(file);
  json what = IsShallowJson(text) ? json::parse(text, nullptr, false) : json();
  return what.is_object() ? what : json::object();
}

std::vector<std::string> FilesOfEntry(const fs::path& project, const std::string& id) {
  std::vector<std::string> files = pipeline::RealDisk().FilesBelow(project / kBin / id);
  std::erase(files, kDeleted);
  return files;
}

/// Relative to the project. @throws UsageError  it lies outside
fs::path BelowProject(const Snapshot& snapshot, const fs::path& file) {
  const fs::path below = file.lexically_normal().lexically_relative(snapshot.project());
  if (!StaysBelow(below.generic_string()))
    throw UsageError(fmt::format("{} is outside of the project; delete it there", file.string()));
  return below;
}

/// The photograph's file, the RAW file of its shot, and the mask that was painted over it.
std::vector<fs::path> FilesOfPhotograph(Snapshot& snapshot, const OwnMasks& masks,
                                        const std::string& pose, const std::string& name) {
  const fs::path file = masks.originals().FileOf(name);
  if (file.empty() || !fs::is_regular_file(file))
    throw UsageError(fmt::format("pose '{}' has no photograph '{}'", pose, name));
  std::vector<fs::path> files = {file};
  for (const fs::path other : pipeline::RealDisk().Children(file.parent_path()))
    if (IsRawName(other) && other.stem() == file.stem() && other != file.filename())
      files.push_back(file.parent_path() / other);
  const fs::path mask = masks.FileOf(name);
  if (!mask.empty() && !pipeline::RealDisk().LeadsOutside(mask, snapshot.project()))
    files.push_back(mask);
  return files;
}

void WriteText(Snapshot& snapshot, const std::string& before, const std::string& edited) {
  if (edited == before) return;
  const std::string revision = RevisionOf(snapshot.project() / "pipeline.yaml");
  WriteCheckedPipeline(snapshot.project(), before, edited, revision);
}

/// The folders on the way go too where nothing else is in them.
void RemoveEmptyFolders(const fs::path& folder) {
  std::error_code ignored;
  std::vector<fs::path> folders = {folder};
  for (fs::recursive_directory_iterator it(folder, ignored), end; it != end; it.increment(ignored))
    if (it->is_directory() && !it->is_symlink()) folders.push_back(it->path());
  for (auto one = folders.rbegin(); one != folders.rend(); ++one) fs::remove(*one, ignored);
}

}  // namespace

BinEntry::BinEntry(const fs::path& project, Moves& moves, const json& what)
    : project_(project), moves_(moves) {
  const auto ids = EntryIds(project);
  int number = ids.empty() ? 1 : std::stoi(ids.front()) + 1;
  while (fs::exists(project / kBin / fmt::format("{:04}", number))) ++number;
  folder_ = fs::path(kBin) / fmt::format("{:04}", number);
  fs::create_directories(project_ / folder_);
  WriteFileAtomically(project_ / folder_ / kDeleted, what.dump(1) + "\n");
}

BinEntry::~BinEntry() {
  if (kept_) return;
  std::error_code ignored;
  fs::remove(project_ / folder_ / kDeleted, ignored);  // an entry without it holds nothing
}

void BinEntry::Take(const fs::path& file) { moves_.Do(file, folder_ / file); }

std::string BinEntry::Keep() {
  kept_ = true;
  return folder_.filename();
}

json BinJson(const fs::path& project) {
  json all = json::array();
  for (const std::string& id : EntryIds(project)) {
    const auto files = FilesOfEntry(project, id);
    if (files.empty()) continue;
    const json what = DeletedJson(project, id);
    all.push_back({{"id", id},
                   {"what", what.value("what", "files")},
                   {"pose", what.value("pose", "")},
                   {"names", what.value("names", json::array())},
                   {"files", files}});
  }
  return all;
}

fs::path BinFile(const fs::path& project, const std::string& id, const std::string& path) {
  const fs::path folder = project / kBin / id, file = folder / path;
  if (!IsNumber(id) || !StaysBelow(path) || !fs::is_regular_file(file) ||
      pipeline::RealDisk().LeadsOutside(file, project))
    throw NotFound(fmt::format("the bin has no {}/{}", id, path));
  return file;
}

std::string BinPhotographs(Snapshot& snapshot, const std::string& pose,
                           const std::vector<std::string>& names) {
  if (!snapshot.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
  if (names.empty()) throw UsageError("name a photograph");
  const OwnMasks masks(snapshot, pose);
  std::vector<fs::path> files;
  for (const std::string& name : names)
    for (const fs::path& file : FilesOfPhotograph(snapshot, masks, pose, name))
      files.push_back(BelowProject(snapshot, file));
  const std::string before = ReadFile(snapshot.project() / "pipeline.yaml");
  const auto out = LeftOutAmong(snapshot, pose, names);
  Moves moves(snapshot.project());
  BinEntry entry(snapshot.project(), moves,
                 {{"schema", 1},
                  {"what", "photographs"},
                  {"pose", pose},
                  {"names", names},
                  {"left_out", out}});
  const std::string edited = WithLeftOut(snapshot, before, pose, out, false);
  for (const fs::path& file : files) entry.Take(file);
  WriteText(snapshot, before, edited);
  moves.Keep();
  return entry.Keep();
}

std::string BinPose(Snapshot& snapshot, const std::string& pose) {
  if (!snapshot.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
  if (snapshot.graph().poses.size() < 2)
    throw UsageError(fmt::format("'{}' is the only pose; add another one first", pose));
  if (snapshot.IsTemplate(pose))
    throw UsageError(
        fmt::format("'{}' gives the other poses their mesh; choose another template first", pose));
  const std::string before = ReadFile(snapshot.project() / "pipeline.yaml");
  const std::string edited = Edited([&] { return WithoutPose(before, pose); });
  const json what = {{"schema", 1},
                     {"what", "pose"},
                     {"pose", pose},
                     {"names", json::array()},
                     {"yaml", Edited([&] { return PoseValue(before, pose); })},
                     {"on_timeline", TimelineOnlyListsPoses(before)},
                     {"pipeline", before}};
  Moves moves(snapshot.project());
  BinEntry entry(snapshot.project(), moves, what);
  for (const fs::path& file : FilesOfPose(snapshot, pose)) entry.Take(file);
  WriteText(snapshot, before, edited);
  moves.Keep();
  return entry.Keep();
}

void TakeBack(Snapshot& snapshot, const std::string& id) {
  const fs::path project = snapshot.project();
  const fs::path folder = project / kBin / id;
  const auto files = IsNumber(id) ? FilesOfEntry(project, id) : std::vector<std::string>();
  const json what = IsNumber(id) ? DeletedJson(project, id) : json::object();
  const std::string pose = what.value("pose", ""), before = ReadFile(project / "pipeline.yaml");
  const bool of_pose = what.value("what", "") == "pose";
  if (files.empty() && !of_pose) throw UsageError("this is not in the bin any more");
  std::string edited = before;
  if (of_pose) {
    edited = Edited([&] { return WithPoseBack(before, pose, what); });
  } else {
    if (!snapshot.HasPose(pose))
      throw UsageError(fmt::format(
          "pose '{}' is gone or has another name: take it back, or make one, first", pose));
  }
  Moves moves(project);
  for (const std::string& file : files) moves.Do(fs::path(kBin) / id / file, file);
  WriteText(snapshot, before, edited);
  moves.Keep();
  std::error_code ignored;
  fs::remove(folder / kDeleted, ignored);
  RemoveEmptyFolders(folder);
  if (of_pose) return;
  const auto out = what.value("left_out", std::vector<std::string>());
  if (out.empty()) return;
  const std::string now = ReadFile(project / "pipeline.yaml");
  WriteText(snapshot, now, WithLeftOut(snapshot, now, pose, out, true));
}

}  // namespace keypose::studio
