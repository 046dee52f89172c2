#include "pipeline/run/results_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose::pipeline {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

struct Wanted {
  fs::path from;
  std::string hash;
};

/// Files that a step must have below out/.
std::map<std::string, Wanted> WantedFiles(const Step& step, const Artifact& artifact) {
  std::map<std::string, Wanted> wanted;
  for (const NamedResult& result : step.results) {
    const auto it = artifact.outputs.find(result.port);
    if (it == artifact.outputs.end()) continue;  // an optional output that was not written
    const ArtifactOutput& output = it->second;
    const fs::path base = artifact.folder / output.file;
    const std::string name = result.path.generic_string();
    if (!output.folder) {
      wanted[name] = {base, output.content.hash};
    } else if (result.inside.empty()) {
      for (const auto& [file, hash] : output.content.files)
        wanted[name + "/" + file] = {base / file, hash};
    } else if (const auto file = output.content.files.find(result.inside);
               file != output.content.files.end()) {
      wanted[name] = {base / file->first, file->second};
    }
  }
  return wanted;
}

}  // namespace

ResultsFolder::ResultsFolder(Disk& disk, fs::path out, fs::path memory_file)
    : disk_(disk), out_(std::move(out)), memory_file_(std::move(memory_file)) {
  Load();
}

void ResultsFolder::Load() {
  if (!disk_.Stat(memory_file_)) return;
  const json memory = json::parse(disk_.Read(memory_file_), nullptr, false);
  if (!memory.is_object()) return;
  for (const auto& [name, value] : memory.items()) {
    // The stored list of a project from elsewhere may name any path; paths outside out/ are
    // ignored.
    if (!StaysBelow(name) || disk_.LeadsOutside(out_ / name, out_)) continue;
    try {
      Entry& entry = entries_[name];
      entry.step = value.at("step").get<std::string>();
      entry.hash = value.at("sha256").get<std::string>();
      entry.next = value.at("next").get<std::string>();
      entry.stat = {
          false, value.at("size").get<std::uint64_t>(), value.at("mtime_ns").get<std::int64_t>(),
          value.at("inode").get<std::uint64_t>(), value.value("ctime_ns", std::int64_t{0})};
    } catch (const json::exception&) {
      entries_.erase(name);  // damaged entry: the file is checked again
    }
  }
}

void ResultsFolder::Save() {
  if (!changed_) return;
  json memory = json::object();
  for (const auto& [name, entry] : entries_) {
    memory[name] = {{"step", entry.step},
                    {"sha256", entry.hash},
                    {"next", entry.next},
                    {"size", entry.stat.size},
                    {"mtime_ns", entry.stat.mtime_ns},
                    {"inode", entry.stat.inode},
                    {"ctime_ns", entry.stat.ctime_ns}};
  }
  disk_.Write(memory_file_, memory.dump(0, ' ', false, json::error_handler_t::replace));
  changed_ = false;
}

std::vector<std::string> ResultsFolder::Verify() {
  std::vector<std::string> notes;
  for (auto& [name, entry] : entries_) {
    const auto stat = disk_.Stat(out_ / name);
    if (!stat || !(*stat == entry.stat) || disk_.ContentHash(out_ / name) == entry.hash) continue;
    notes.push_back(fmt::format(
        "damaged: out/{}; `keypose run` puts it back, and keeps this one beside it", name));
    entry.stat = {};
    changed_ = true;
  }
  return notes;
}

bool ResultsFolder::Unchanged(const std::string& name, const Entry& entry) const {
  const auto stat = disk_.Stat(out_ / name);
  if (!stat || stat->folder) return false;
  if (*stat == entry.stat) return true;
  const std::string present = disk_.ContentHash(out_ / name);
  return present == entry.hash || present == entry.next;
}

ResultsFolder::Published ResultsFolder::Publish(const Step& step, const Artifact& artifact) {
  Published published;
  std::vector<std::string>& notes = published.notes;
  const auto wanted = WantedFiles(step, artifact);
  std::vector<std::string> stale, missing;
  for (const auto& [name, entry] : entries_) {
    if (entry.step == step.id && !wanted.contains(name)) stale.push_back(name);
  }
  for (const std::string& name : stale) Drop(name, &notes);
  for (const auto& [name, file] : wanted) {
    if (!IsInPlace(name, step.id, file.hash)) missing.push_back(name);
  }
  for (const std::string& name : missing)
    if (disk_.LeadsOutside(out_ / name, out_))
      throw DiskError(
          fmt::format("out/{} cannot be written: a link in out/ leads to {}, outside of the "
                      "project's results; remove the link",
                      name, (out_ / name).parent_path().string()));
  if (missing.empty()) return published;
  for (const std::string& name : missing) {
    Entry& entry = entries_[name];
    const auto stat = entry.next.empty() ? std::nullopt : disk_.Stat(out_ / name);
    if (stat && !stat->folder && disk_.ContentHash(out_ / name) == entry.next)
      entry.hash = entry.next;
    entry.step = step.id;
    entry.next = wanted.at(name).hash;
  }
  // Saved before the copy: after a run is killed in between, its copy must not look like a file
  // that the user changed.
  changed_ = true;
  Save();
  for (const std::string& name : missing) Place(name, wanted.at(name).from, &notes);
  Save();
  published.copied = true;
  return published;
}

void ResultsFolder::RemoveWrongCopies(const std::string& step) {
  std::erase_if(entries_, [&](const auto& named) {
    const auto& [name, entry] = named;
    if (entry.step != step || !disk_.Stat(out_ / name)) return false;
    if (disk_.ContentHash(out_ / name) == entry.hash) return false;
    disk_.Remove(out_ / name);
    return true;
  });
  changed_ = true;
  Save();
}

bool ResultsFolder::IsInPlace(const std::string& name, const std::string& step,
                              const std::string& hash) {
  const auto stat = disk_.Stat(out_ / name);
  if (!stat || stat->folder) return false;
  const auto it = entries_.find(name);
  if (it != entries_.end() && it->second.stat == *stat && it->second.hash == hash &&
      it->second.step == step)
    return true;
  if (disk_.ContentHash(out_ / name) != hash) return false;
  entries_[name] = {step, hash, "", *stat};
  changed_ = true;
  return true;
}

void ResultsFolder::Place(const std::string& name, const fs::path& from,
                          std::vector<std::string>* notes) {
  Entry& entry = entries_.at(name);
  if (const auto stat = disk_.Stat(out_ / name)) {
    const std::string present = stat->folder ? "a folder" : disk_.ContentHash(out_ / name);
    if (present != entry.hash && present != entry.next) SetAside(name, notes);
  }
  disk_.Copy(from, out_ / name);
  entry = {entry.step, entry.next, "", *disk_.Stat(out_ / name)};
  changed_ = true;
}

void ResultsFolder::SetAside(const std::string& name, std::vector<std::string>* notes) {
  std::string aside = name + ".mine";
  for (int n = 2; disk_.Stat(out_ / aside); ++n) aside = fmt::format("{}.mine{}", name, n);
  disk_.Move(out_ / name, out_ / aside);
  notes->push_back(
      fmt::format("out/{} was changed by hand; that version is out/{} now", name, aside));
}

void ResultsFolder::Drop(const std::string& name, std::vector<std::string>* notes) {
  if (Unchanged(name, entries_.at(name))) {
    disk_.Remove(out_ / name);
    for (fs::path folder = (out_ / name).parent_path();
         folder != out_ && disk_.Children(folder).empty(); folder = folder.parent_path()) {
      disk_.Remove(folder);
    }
  } else if (disk_.Stat(out_ / name)) {
    notes->push_back(
        fmt::format("out/{} is no longer a result, but was changed by hand; it stays", name));
  }
  entries_.erase(name);
  changed_ = true;
}

std::vector<std::string> ResultsFolder::DropStepsOutside(const Graph& graph) {
  std::vector<std::string> notes, stale;
  for (const auto& [name, entry] : entries_) {
    const bool known =
        std::any_of(graph.steps.begin(), graph.steps.end(),
                    [&name_of = entry.step](const Step& step) { return step.id == name_of; });
    if (!known) stale.push_back(name);
  }
  for (const std::string& name : stale) Drop(name, &notes);
  return notes;
}

}  // namespace keypose::pipeline
