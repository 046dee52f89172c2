#include "pipeline/testing/memory_disk.h"

#include <algorithm>

#include "core/numbers/sha256.h"
#include "core/values/errors.h"

namespace keypose::pipeline {
namespace {

std::string Key(const std::filesystem::path& path) {
  std::string key = path.lexically_normal().generic_string();
  while (key.size() > 1 && key.back() == '/') key.pop_back();
  return key;
}

bool Below(const std::string& key, const std::string& folder) {
  return key.size() > folder.size() + 1 && key.starts_with(folder + "/");
}

}  // namespace

void MemoryDisk::CheckSpace(const Path& path) const {
  if (full_) throw DiskError("cannot write " + path.string() + ": No space left on device");
}

std::optional<FileStat> MemoryDisk::Stat(const Path& path) const {
  const std::string key = Key(path);
  if (const auto it = files_.find(key); it != files_.end()) {
    return FileStat{false, it->second.text.size(), it->second.mtime_ns, it->second.inode,
                    it->second.mtime_ns};
  }
  if (folders_.contains(key)) return FileStat{true, 0, 0, 0, 0};
  return std::nullopt;
}

std::vector<std::string> MemoryDisk::FilesBelow(const Path& folder) const {
  std::vector<std::string> names;
  const std::string key = Key(folder);
  for (const auto& [name, file] : files_) {
    if (Below(name, key)) names.push_back(name.substr(key.size() + 1));
  }
  return names;
}

std::vector<std::string> MemoryDisk::Children(const Path& folder) const {
  std::set<std::string> names;
  const std::string key = Key(folder);
  const auto add = [&](const std::string& name) {
    if (Below(name, key))
      names.insert(name.substr(key.size() + 1, name.find('/', key.size() + 1) - key.size() - 1));
  };
  for (const auto& [name, file] : files_) add(name);
  for (const std::string& name : folders_) add(name);
  return {names.begin(), names.end()};
}

std::string MemoryDisk::Read(const Path& path) const {
  const auto it = files_.find(Key(path));
  if (it == files_.end())
    throw DiskError("cannot read " + path.string() + ": No such file or directory");
  return it->second.text;
}

std::string MemoryDisk::ReadEnd(const Path& path, std::size_t most) const {
  const std::string text = Read(path);
  return text.substr(text.size() - std::min(most, text.size()));
}

std::string MemoryDisk::ContentHash(const Path& path) const {
  ++hashed_;
  return Sha256Of(Read(path));
}

void MemoryDisk::Write(const Path& path, std::string_view text) {
  CheckSpace(path);
  MakeFolder(path.parent_path());
  files_[Key(path)] = {std::string(text), ++time_ns_, next_inode_++};
}

void MemoryDisk::MakeFolder(const Path& path) {
  for (Path folder = path.lexically_normal(); folder.has_relative_path();
       folder = folder.parent_path())
    folders_.insert(Key(folder));
}

void MemoryDisk::Move(const Path& from, const Path& to) {
  if (!Stat(from)) throw DiskError("cannot move " + from.string() + ": No such file or directory");
  Remove(to);
  MakeFolder(to.parent_path());
  const std::string a = Key(from), b = Key(to);
  if (auto file = files_.extract(a)) {
    file.key() = b;
    files_.insert(std::move(file));
    return;
  }
  std::vector<std::string> names, folders;
  for (const auto& [name, file] : files_) {
    if (Below(name, a)) names.push_back(name);
  }
  for (const std::string& name : folders_) {
    if (name == a || Below(name, a)) folders.push_back(name);
  }
  for (const std::string& name : names) {
    auto file = files_.extract(name);
    file.key() = b + name.substr(a.size());
    files_.insert(std::move(file));
  }
  for (const std::string& name : folders) {
    folders_.erase(name);
    folders_.insert(b + name.substr(a.size()));
  }
}

void MemoryDisk::Copy(const Path& from, const Path& to) {
  if (before_copy) before_copy(from);
  Write(to, Read(from));
}

void MemoryDisk::Remove(const Path& path) {
  const std::string key = Key(path);
  files_.erase(key);
  std::erase_if(files_, [&](const auto& file) { return Below(file.first, key); });
  std::erase_if(folders_, [&](const std::string& name) { return name == key || Below(name, key); });
}

void MemoryDisk::Rot(const Path& path) { files_.at(Key(path)).text.front() ^= 1; }

void MemoryDisk::Touch(const Path& path) { files_.at(Key(path)).mtime_ns = ++time_ns_; }

}  // namespace keypose::pipeline
