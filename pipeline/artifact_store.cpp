#include "pipeline/artifact_store.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/errors.h"

namespace keypose::pipeline {

using nlohmann::json;
namespace fs = std::filesystem;

ArtifactStore::ArtifactStore(Disk& disk, fs::path state_folder) : disk_(disk), state_folder_(std::move(state_folder)) {}

fs::path ArtifactStore::FolderOf(const std::string& fingerprint) const {
  return state_folder_ / "cache" / fingerprint.substr(0, 2) / fingerprint.substr(2);
}

std::optional<Artifact> ArtifactStore::Find(const std::string& fingerprint) const {
  Artifact artifact;
  artifact.fingerprint = fingerprint;
  artifact.folder = FolderOf(fingerprint);
  if (!disk_.Stat(artifact.folder / "manifest.json")) return std::nullopt;
  try {
    const json manifest = json::parse(disk_.Read(artifact.folder / "manifest.json"));
    artifact.recipe = RecipeFromJson(manifest.at("recipe"));
    for (const auto& [port, entry] : manifest.at("outputs").items()) {
      ArtifactOutput& output = artifact.outputs[port];
      output.file = entry.at("file").get<std::string>();
      output.folder = entry.at("folder").get<bool>();
      output.content.hash = entry.at("sha256").get<std::string>();
      if (output.folder) output.content.files = entry.at("files").get<std::map<std::string, std::string>>();
    }
    for (const auto& [name, size] : manifest.at("sizes").items()) {
      const auto stat = disk_.Stat(artifact.folder / name);
      if (!stat || stat->folder || stat->size != size.get<std::uint64_t>()) return std::nullopt;
    }
    artifact.seconds = manifest.at("seconds").get<double>();
    artifact.peak_bytes = manifest.at("peak_bytes").get<std::int64_t>();
  } catch (const json::exception&) {
    return std::nullopt;  // damaged from outside: the step simply runs again
  }
  return artifact;
}

ArtifactOutput ArtifactStore::Measure(const fs::path& made, const PortInfo& port, std::map<std::string, std::uint64_t>* sizes) const {
  ArtifactOutput output{port.file, port.kind == "folder", {}};
  if (!output.folder) {
    output.content.hash = disk_.ContentHash(made / port.file);
    (*sizes)[port.file] = disk_.Stat(made / port.file)->size;
    return output;
  }
  std::map<std::string, std::string> files;
  for (const std::string& name : disk_.FilesBelow(made / port.file)) {
    files[name] = disk_.ContentHash(made / port.file / name);
    (*sizes)[port.file + "/" + name] = disk_.Stat(made / port.file / name)->size;
  }
  output.content = FolderContent(std::move(files));
  return output;
}

Artifact ArtifactStore::Commit(const fs::path& made, const StageInfo& info, const Recipe& recipe, double seconds, std::int64_t peak_bytes) {
  Artifact artifact{recipe.Fingerprint(), {}, recipe, {}, seconds, peak_bytes};
  std::map<std::string, std::uint64_t> sizes;
  json outputs = json::object();
  for (const PortInfo& port : info.outputs) {
    const auto stat = disk_.Stat(made / port.file);
    if (!stat && port.optional) continue;
    if (!stat || stat->folder != (port.kind == "folder")) {
      throw ToolError(fmt::format("stage '{}' ended well but did not write its output '{}' (a {})", info.stage, port.name, port.kind));
    }
    const ArtifactOutput output = artifact.outputs[port.name] = Measure(made, port, &sizes);
    outputs[port.name] = {{"file", output.file}, {"folder", output.folder}, {"sha256", output.content.hash}};
    if (output.folder) outputs[port.name]["files"] = output.content.files;
  }
  const json manifest = {{"schema", 1},
                         {"fingerprint", artifact.fingerprint},
                         {"recipe", ToJson(recipe)},
                         {"outputs", outputs},
                         {"sizes", sizes},
                         {"seconds", seconds},
                         {"peak_bytes", peak_bytes}};
  disk_.Write(made / "manifest.json", manifest.dump(1));
  // On the device before it gets its name: after a power cut an artifact is whole or absent.
  disk_.Sync(made);
  artifact.folder = FolderOf(artifact.fingerprint);
  disk_.Move(made, artifact.folder);
  return artifact;
}

std::vector<std::string> ArtifactStore::All() const {
  std::vector<std::string> all;
  for (const std::string& head : disk_.Children(state_folder_ / "cache")) {
    for (const std::string& tail : disk_.Children(state_folder_ / "cache" / head)) all.push_back(head + tail);
  }
  return all;
}

std::uint64_t ArtifactStore::SizeOf(const std::string& fingerprint) const {
  std::uint64_t size = 0;
  const fs::path folder = FolderOf(fingerprint);
  for (const std::string& name : disk_.FilesBelow(folder)) size += disk_.Stat(folder / name).value_or(FileStat{}).size;
  return size;
}

void ArtifactStore::Remove(const std::string& fingerprint) {
  // Out of the cache in one step first: a half-removed folder must not look like an artifact.
  const fs::path doomed = state_folder_ / "tmp" / ("gc-" + fingerprint);
  disk_.Move(FolderOf(fingerprint), doomed);
  disk_.Remove(doomed);
}

}  // namespace keypose::pipeline
