#include "studio/project/page_sound.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/io/pictures/photograph_files.h"
#include "core/io/text/files.h"
#include "core/io/text/yaml_edit.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/disk/project_paths.h"
#include "studio/project/changes.h"
#include "views/decode/read_sound.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* kWord = "sound";
constexpr const char* kOption = "sound_at";
/// Steps whose films carry it.
constexpr const char* kFilms[] = {"export", "composite"};

std::string TextOf(const Snapshot& snapshot) {
  return ReadFile(snapshot.project() / "pipeline.yaml");
}

void Write(const Snapshot& snapshot, const std::string& text) {
  WritePipelineFile(snapshot.project(), text, RevisionOf(snapshot.project() / "pipeline.yaml"));
}

double AtOf(const Snapshot& snapshot) {
  const pipeline::Step* step = snapshot.FindStep("export", "");
  if (!step) return 0;
  const auto set = step->options.find(kOption);
  return set == step->options.end() ? 0 : std::stod(set->second);
}

std::string WithTime(std::string text, const Snapshot& snapshot, double at_s) {
  for (const char* film : kFilms) {
    const YamlPath path = {"options", film, kOption};
    if (at_s == 0 || !snapshot.FindStep(film, ""))
      text = WithoutValue(text, path);
    else
      text = WithValue(text, path, fmt::format("{:.6g}", at_s));
  }
  return text;
}

/// The file for these bytes: the one that has them already, or a new name.
fs::path FreeName(const fs::path& folder, const std::string& name, const std::string& bytes) {
  const fs::path wanted(name);
  for (int number = 1;; ++number) {
    const fs::path file = folder / (number == 1 ? name
                                                : fmt::format("{}-{}{}", wanted.stem().string(),
                                                              number, wanted.extension().string()));
    if (!fs::exists(file) || ReadFile(file) == bytes) return file;
  }
}

}  // namespace

json SoundToPage(Snapshot& snapshot) {
  const pipeline::Setting* given = snapshot.file().Given(kWord);
  if (!given) return nullptr;
  return {{"file", given->text},
          {"name", fs::path(given->text).filename().string()},
          {"at", AtOf(snapshot)}};
}

fs::path SoundFileOf(const Snapshot& snapshot) {
  const pipeline::Setting* given = snapshot.file().Given(kWord);
  if (!given) throw UsageError("the project has no sound");
  return snapshot.project() / pipeline::WithHome(given->text);
}

void PutSound(Snapshot& snapshot, const std::string& name, const std::string& bytes) {
  if (!IsOneName(name) || !IsValidUtf8(name) || IsLitterName(name))
    throw UsageError(fmt::format("'{}' cannot be the name of a sound", name));
  const fs::path folder = snapshot.project() / "sound";
  fs::create_directories(folder);
  const fs::path file = FreeName(folder, name, bytes);
  const bool is_new = !fs::exists(file);
  if (is_new) WriteFileAtomically(file, bytes);
  try {
    ReadSound(file);
    Write(snapshot, Edited([&] {
            return WithTime(WithValue(TextOf(snapshot), {kWord},
                                      YamlScalar("sound/" + file.filename().string())),
                            snapshot, 0);
          }));
  } catch (...) {
    std::error_code ignored;
    if (is_new) fs::remove(file, ignored);
    fs::remove(folder, ignored);  // where it is empty
    throw;
  }
}

void MoveSound(Snapshot& snapshot, double at_s) {
  Write(snapshot, Edited([&] { return WithTime(TextOf(snapshot), snapshot, at_s); }));
}

void RemoveSound(Snapshot& snapshot) {
  Write(snapshot,
        Edited([&] { return WithTime(WithoutValue(TextOf(snapshot), {kWord}), snapshot, 0); }));
}

}  // namespace keypose::studio
