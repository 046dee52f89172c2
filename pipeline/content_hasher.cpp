#include "pipeline/content_hasher.h"

#include <nlohmann/json.hpp>

#include "core/errors.h"

namespace keypose::pipeline {
namespace {

using nlohmann::json;

bool Ignored(const std::string& name) {
  const std::string base = name.substr(name.rfind('/') + 1);
  return name.starts_with('.') || name.find("/.") != std::string::npos || base == "Thumbs.db" || base == "desktop.ini";
}

}  // namespace

ContentHasher::ContentHasher(Disk& disk, std::filesystem::path memory_file, std::filesystem::path root)
    : disk_(disk), memory_file_(std::move(memory_file)), root_(std::move(root)) {}

Content ContentHasher::Of(const std::filesystem::path& path) {
  const auto stat = disk_.Stat(path);
  if (!stat) throw InputError(path.string() + " does not exist");
  if (!stat->folder) return {OfFile(path), {}};
  std::map<std::string, std::string> files;
  for (const std::string& name : disk_.FilesBelow(path)) {
    if (!Ignored(name)) files[name] = OfFile(path / name);
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
  if (cancelled_ && cancelled_()) throw Cancelled();
  ++files_read_;
  changed_ = true;
  return (entries_[key] = {*stat, disk_.ContentHash(path)}).hash;
}

void ContentHasher::Load() {
  if (loaded_) return;
  loaded_ = true;
  if (!disk_.Stat(memory_file_)) return;
  const json memory = json::parse(disk_.Read(memory_file_), nullptr, false);
  if (!memory.is_object()) return;  // only a memory: without it, files are read again
  for (const auto& [name, entry] : memory.items()) {
    if (!entry.is_array() || entry.size() != 4) continue;
    entries_[name] = {{false, entry[0].get<std::uint64_t>(), entry[1].get<std::int64_t>(), entry[2].get<std::uint64_t>()},
                      entry[3].get<std::string>()};
  }
}

void ContentHasher::Save() {
  if (!changed_) return;
  json memory = json::object();
  for (const auto& [name, entry] : entries_) memory[name] = {entry.stat.size, entry.stat.mtime_ns, entry.stat.inode, entry.hash};
  changed_ = false;
  try {
    disk_.Write(memory_file_, memory.dump(0, ' ', false, json::error_handler_t::replace));
  } catch (const DiskError&) {
    // Only a memory: on a full or read-only disk the files are read again next time.
  }
}

}  // namespace keypose::pipeline
