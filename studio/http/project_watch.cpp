#include "studio/http/project_watch.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <chrono>
#include <set>

#include "core/numbers/sha256.h"
#include "pipeline/disk/real_disk.h"

namespace keypose::studio {

namespace fs = std::filesystem;

namespace {

constexpr auto kEvery = std::chrono::milliseconds(700);
constexpr int kDepth = 3;  // photos/POSE/lying

std::string StampOf(const fs::path& path) {
  struct stat stat;
  if (::stat(path.c_str(), &stat) != 0) return "-";
  return fmt::format("{} {} {}.{}", static_cast<unsigned long>(stat.st_ino), stat.st_size,
                     stat.st_mtim.tv_sec, stat.st_mtim.tv_nsec);
}

/// The stamps of a folder's files, and of folders in it. A folder's own stamp tells of new and
/// deleted files, those of the files of changed ones.
void AddBelow(const fs::path& folder, int depth, Sha256& all) {
  all.Add(StampOf(folder));
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    all.Add(entry.path().filename().string());
    if (entry.is_directory(error) && depth > 0)
      AddBelow(entry.path(), depth - 1, all);
    else
      all.Add(StampOf(entry.path()));
  }
}

/// Whether the project keeps its own results, or what is looked at closer, in a folder of this
/// name.
bool IsKnownFolder(const std::string& name) {
  static const std::set<std::string> kKnown = {"out", "photos", "masks", "landmarks", "mending"};
  return name.starts_with(".") || kKnown.contains(name);
}

/// The stamps of folders alone, which tell of new and deleted files: a film may have thousands.
void AddFolders(const fs::path& folder, int depth, Sha256& all) {
  std::error_code error;
  all.Add(StampOf(folder));
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (depth > 0 && entry.is_directory(error) && !entry.is_symlink(error))
      AddFolders(entry.path(), depth - 1, all);
}

/// Films, and JSON files such as clicks, wherever the project has them.
void AddOthers(const fs::path& project, Sha256& all) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(project, error)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_directory(error) && !entry.is_symlink(error) && !IsKnownFolder(name))
      AddFolders(entry.path(), kDepth - 1, all);
    if (entry.path().extension() == ".json") all.Add(name + StampOf(entry.path()));
  }
}

}  // namespace

ProjectWatch::ProjectWatch(fs::path project, std::function<void()> changed)
    : project_(std::move(project)), changed_(std::move(changed)), seen_(Look()) {
  thread_ = std::thread([this] { Watch(); });
}

ProjectWatch::~ProjectWatch() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    end_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void ProjectWatch::Forget() {
  const std::string now = Look();
  const std::lock_guard<std::mutex> lock(mutex_);
  seen_ = now;
}

std::string ProjectWatch::Look() const {
  Sha256 all;
  for (const char* file : {"pipeline.yaml", "stiffness.json", "regions.json", ".keypose/out.json"})
    all.Add(StampOf(project_ / file));
  for (const char* folder : {"photos", "masks", "landmarks", "mending", ".keypose/steps"})
    AddBelow(project_ / folder, kDepth, all);
  AddOthers(project_, all);
  return all.Hex();
}

void ProjectWatch::Watch() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!wake_.wait_for(lock, kEvery, [&] { return end_; })) {
    const std::string before = seen_;
    lock.unlock();
    const std::string now = Look();
    lock.lock();
    if (now == before || seen_ != before) continue;
    seen_ = now;
    lock.unlock();
    changed_();
    lock.lock();
  }
}

}  // namespace keypose::studio
