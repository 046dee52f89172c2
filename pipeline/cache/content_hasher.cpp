#include "pipeline/cache/content_hasher.h"

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "core/io/pictures/photograph_files.h"
#include "core/values/errors.h"

namespace keypose::pipeline {
namespace {

using nlohmann::json;

/// Whether a file's last change is longer ago than the coarsest time step of a file system.
bool SettledAt(const FileStat& stat) {
  constexpr std::int64_t kTickNs = 100'000'000;
  const auto now = std::chrono::duration_cast<std::chrono::nanoseconds>(
                       std::chrono::system_clock::now().time_since_epoch())
                       .count();
  return now - std::max(stat.mtime_ns, stat.ctime_ns) > kTickNs;
}

}  // namespace

bool CountsAsContent(const std::string& name) {
  const std::filesystem::path path = name;
  return std::none_of(path.begin(), path.end(), IsLitterName);
}

ContentHasher::ContentHasher(Disk& disk, std::filesystem::path memory_file,
                             std::filesystem::path root)
    : disk_(disk), memory_file_(std::move(memory_file)), root_(std::move(root)) {}

Content ContentHasher::Of(const std::filesystem::path& path) {
  const auto stat = disk_.Stat(path);
  if (!stat) throw InputError(path.string() + " does not exist");
  if (!stat->folder) return {OfFile(path), {}};
  std::map<std::string, std::string> files;
  for (const std::string& name : disk_.FilesBelow(path)) {
    if (CountsAsContent(name)) files[name] = OfFile(path / name);
  }
  return FolderContent(std::move(files));
}

std::string ContentHasher::OfFile(const std::filesystem::path& path) {
  Load();
  const auto stat = disk_.Stat(path);
  if (!stat) throw InputError(path.string() + " does not exist (or is a link to nowhere)");
  const std::string key = path.lexically_proximate(root_).generic_string();
  const auto it = entries_.find(key);
  if (it != entries_.end() && it->second.stat == *stat) return it->second.hash;
  return Read(path, key);
}

/// Hashes until the file's stamp is the same before and after.
std::string ContentHasher::Read(const std::filesystem::path& path, const std::string& key) {
  constexpr int kTries = 5;
  for (int i = 0; i < kTries; ++i) {
    if (cancelled_ && cancelled_()) throw Cancelled();
    const auto before = disk_.Stat(path);
    if (!before) break;
    ++files_read_;
    const std::string hash = disk_.ContentHash(path);
    if (disk_.Stat(path) != before) continue;
    // File systems have coarse clocks: a file that was written a moment ago may change again
    // without a new time.
    if (SettledAt(*before)) {
      entries_[key] = {*before, hash};
      changed_ = true;
    }
    return hash;
  }
  throw InputError(path.string() +
                   " was written to while it was read; wait until it is copied, and run again");
}

void ContentHasher::Load() {
  if (loaded_) return;
  loaded_ = true;
  if (!disk_.Stat(memory_file_)) return;
  const json memory = json::parse(disk_.Read(memory_file_), nullptr, false);
  if (!memory.is_object()) return;  // without stored hashes, files are read again
  for (const auto& [name, entry] : memory.items()) {
    if (!entry.is_array() || entry.size() != 5 || !entry[4].is_string()) continue;
    if (!std::all_of(entry.begin(), entry.begin() + 4,
                     [](const json& number) { return number.is_number_integer(); }))
      continue;
    entries_[name] = {{false, entry[0].get<std::uint64_t>(), entry[1].get<std::int64_t>(),
                       entry[2].get<std::uint64_t>(), entry[3].get<std::int64_t>()},
                      entry[4].get<std::string>()};
  }
}

void ContentHasher::Save() {
  if (!changed_) return;
  json memory = json::object();
  for (const auto& [name, entry] : entries_)
    memory[name] = {entry.stat.size, entry.stat.mtime_ns, entry.stat.inode, entry.stat.ctime_ns,
                    entry.hash};
  changed_ = false;
  try {
    disk_.Write(memory_file_, memory.dump(0, ' ', false, json::error_handler_t::replace));
  } catch (const DiskError&) {
    // Not an error: if this cannot be saved (full or read-only disk), the files are read again next
    // time.
  }
}

}  // namespace keypose::pipeline
