#include "studio/project/added_photographs.h"

#include <fmt/format.h>

#include "core/io/pictures/image_kind.h"
#include "core/io/pictures/photograph_files.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "studio/project/bin.h"
#include "studio/project/changes.h"
#include "studio/project/originals.h"

namespace keypose::studio {

namespace fs = std::filesystem;

namespace {

void RequirePicture(const std::string& name, const std::string& bytes) {
  if (!IsPhotographName(name))
    throw UsageError(
        fmt::format("'{}' is no photograph that can be read ({})", name, kReadablePhotographs));
  if (const std::string fault = PhotographFault(bytes); !fault.empty())
    throw UsageError(fmt::format("'{}' {}", name, fault));
}

bool HasBytes(const fs::path& file, const std::string& bytes) {
  return fs::file_size(file) == bytes.size() && ReadFile(file) == bytes;
}

void ReplacePhotograph(Snapshot& snapshot, const std::string& pose, const std::string& replaces,
                       const std::string& name, const std::string& bytes) {
  const fs::path old = Originals(snapshot, pose).FileOf(replaces);
  if (old.empty())
    throw UsageError(fmt::format("pose '{}' has no photograph '{}'", pose, replaces));
  fs::path file = old;
  file.replace_extension(fs::path(name).extension());
  if (HasBytes(old, bytes)) return;
  if (file != old && fs::exists(file))
    throw UsageError(fmt::format("pose '{}' has another photograph called '{}'", pose,
                                 file.filename().string()));
  BinPhotographs(snapshot, pose, {replaces});
  WriteFileAtomically(file, bytes);
}

}  // namespace

void AddPhotograph(Snapshot& snapshot, const std::string& pose, const std::string& name,
                   const std::string& bytes, const std::string& replaces) {
  RequirePhotograph(snapshot, pose, name);
  RequirePicture(name, bytes);
  const fs::path folder = snapshot.PhotoFolder(pose), file = folder / name;
  if (!IsWithin(fs::weakly_canonical(folder), fs::canonical(snapshot.project())))
    throw UsageError(
        fmt::format("the photographs of '{}' are outside of the project; add them there", pose));
  if (!replaces.empty()) return ReplacePhotograph(snapshot, pose, replaces, name, bytes);
  if (fs::exists(file)) {
    if (HasBytes(file, bytes)) return;
    throw UsageError(fmt::format("pose '{}' has another photograph called '{}'", pose, name));
  }
  fs::create_directories(folder);
  WriteFileAtomically(file, bytes);
}

}  // namespace keypose::studio
