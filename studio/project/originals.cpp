#include "studio/project/originals.h"

#include <algorithm>
#include <set>

#include "core/io/pictures/photograph_files.h"
#include "core/io/pictures/raw_io.h"
#include "pipeline/disk/real_disk.h"

namespace keypose::studio {

namespace fs = std::filesystem;

namespace {

/// How well a file answers to a name that a page knows: 0 not at all.
int MatchOf(const fs::path& file, const std::string& name) {
  const std::string written = WrittenName(file);
  const std::string group = file.parent_path().filename().string();
  if (file.generic_string() == name || (!group.empty() && group + "_" + written == name)) return 3;
  if (file.filename() == name) return 2;
  return written == name ? 1 : 0;
}

}  // namespace

std::vector<std::string> OriginalPhotographs(const fs::path& folder) {
  std::vector<std::string> names, raw;
  std::set<fs::path> stems;
  for (const fs::path file : pipeline::RealDisk().Children(folder)) {
    if (IsLitterName(file)) continue;
    if (IsPhotographName(file)) {
      names.push_back(file.string());
      stems.insert(file.stem());
    } else if (IsRawName(file)) {
      raw.push_back(file.string());
    }
  }
  for (const std::string& name : raw)
    if (!stems.contains(fs::path(name).stem())) names.push_back(name);
  return names;
}

ImageInfo OriginalInfo(const fs::path& file) {
  return IsRawName(file) ? ReadRawInfo(file) : ReadImageInfo(file);
}

Originals::Originals(Snapshot& snapshot, const std::string& pose)
    : snapshot_(snapshot), folder_(snapshot.PhotoFolder(pose)) {
  for (const fs::path file : pipeline::RealDisk().FilesBelow(folder_))
    if (IsShotName(file)) files_.push_back(file);
  if (const auto result = snapshot.Result("capture", pose))
    for (const pipeline::RecipeInput& input : result->recipe.inputs)
      if (input.port == "photos") captured_ = input.content;
}

fs::path Originals::FileOf(const std::string& name) const {
  const auto best = std::max_element(
      files_.begin(), files_.end(),
      [&](const fs::path& a, const fs::path& b) { return MatchOf(a, name) < MatchOf(b, name); });
  if (best == files_.end() || MatchOf(*best, name) == 0) return {};
  const fs::path file = folder_ / *best;
  return pipeline::RealDisk().LeadsOutside(file, folder_) ? fs::path() : file;
}

std::string Originals::HashOf(const std::string& name) const {
  const fs::path file = FileOf(name);
  return file.empty() ? "" : snapshot_.opened_project().workshop().hasher.OfFile(file);
}

bool Originals::WasShotAgain(const std::string& name) const {
  const fs::path file = FileOf(name);
  if (!captured_ || file.empty()) return false;
  const auto then = captured_->files.find(file.lexically_relative(folder_).generic_string());
  return then == captured_->files.end() || then->second != HashOf(name);
}

}  // namespace keypose::studio
