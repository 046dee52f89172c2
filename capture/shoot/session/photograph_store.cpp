#include "capture/shoot/session/photograph_store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <set>

#include "core/io/pictures/photograph_files.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose::capture::shoot {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void Fail(const fs::path& path, const char* doing) {
  throw DiskError(fmt::format("cannot {} {}: {}{}", doing, path.string(), std::strerror(errno),
                              errno == ENOSPC ? "; free some space and start again" : ""));
}

/// To the disk itself, so that a name never stands for half a file, not even after a power cut.
void Sync(const fs::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) Fail(path, "open");
  const bool fine = ::fsync(fd) == 0;
  ::close(fd);
  if (!fine) Fail(path, "write");
}

/// A file's time is the photograph's: it is there again when the side file's entry was lost.
void SetTime(const fs::path& path, std::int64_t time) {
  const timespec times[2] = {{time, 0}, {time, 0}};
  if (::utimensat(AT_FDCWD, path.c_str(), times, 0) != 0) Fail(path, "set the time of");
}

/// ".jpg" of ".JPEG"; others in lower case.
std::string PlainExtension(const fs::path& file) {
  const std::string extension = LowerExtension(file);
  if (extension == ".jpeg") return ".jpg";
  return extension == ".tiff" ? ".tif" : extension;
}

void Rename(const fs::path& from, const fs::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) Fail(to, "write");
}

void MakeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw DiskError(fmt::format("cannot make the folder {}: {}", folder.string(), error.message()));
}

}  // namespace

PhotographStore::PhotographStore(const fs::path& folder) : folder_(folder) {
  MakeFolder(folder_);
  std::error_code ignored;
  fs::remove_all(folder_ / ".incoming", ignored);
}

PhotographStore::~PhotographStore() {
  std::error_code ignored;
  fs::remove_all(folder_ / ".incoming", ignored);
}

fs::path PhotographStore::Incoming() const {
  const fs::path incoming = folder_ / ".incoming";
  std::error_code ignored;
  fs::remove_all(incoming, ignored);
  MakeFolder(incoming);
  return incoming;
}

std::vector<fs::path> PhotographStore::AllOf(const std::string& name) const {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder_, ignored)) {
    const fs::path& file = entry.path();
    if (file.stem() == name && (IsPhotographName(file) || IsRawName(file))) files.push_back(file);
  }
  std::sort(files.begin(), files.end());
  return files;
}

fs::path PhotographStore::FileOf(const std::string& name) const {
  fs::path raw;
  for (const fs::path& file : AllOf(name)) {
    if (!IsRawName(file)) return file;
    raw = file;
  }
  return raw;
}

fs::path PhotographStore::RawOf(const std::string& name) const {
  for (const fs::path& file : AllOf(name))
    if (IsRawName(file)) return file;
  return {};
}

void PhotographStore::Add(const std::string& name, const Exposure& exposure, std::int64_t time) {
  // RAW first: a JPEG that is there means that the whole pair is.
  std::vector<fs::path> files = exposure.files;
  std::stable_partition(files.begin(), files.end(),
                        [](const fs::path& file) { return IsRawName(file); });
  std::set<fs::path> landed;
  for (const fs::path& file : files) {
    const fs::path to = folder_ / (name + PlainExtension(file));
    if (landed.contains(to))
      throw InputError(fmt::format("the camera gave two files of one kind for one photograph, {}",
                                   file.filename().string()));
    SetTime(file, time);
    Sync(file);
    Rename(file, to);
    landed.insert(to);
  }
  Sync(folder_);
  for (const fs::path& file : AllOf(name))
    if (!landed.contains(file)) fs::remove(file);
}

void PhotographStore::AddStack(const std::string& name, const std::vector<Exposure>& exposures,
                               const fs::path& merged, std::int64_t time) {
  const fs::path stacks = folder_ / "stacks";
  MakeFolder(stacks);
  for (std::size_t i = 0; i < exposures.size(); ++i)
    for (const fs::path& file : exposures[i].files) {
      SetTime(file, time);
      Sync(file);
      Rename(file, stacks / fmt::format("{}_f{}{}", name, i + 1, PlainExtension(file)));
    }
  Sync(stacks);
  Add(name, {{merged}, time}, time);
}

void WriteDurably(const fs::path& file, const std::string& text) {
  const fs::path beside = file.parent_path() / ("." + file.filename().string() + ".part");
  WriteFile(beside, text);
  Sync(beside);
  Rename(beside, file);
}

std::int64_t TimeOfFile(const fs::path& file) {
  struct stat status = {};
  if (::stat(file.c_str(), &status) != 0) Fail(file, "read");
  return status.st_mtim.tv_sec;
}

}  // namespace keypose::capture::shoot
