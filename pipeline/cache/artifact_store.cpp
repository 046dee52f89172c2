#include "pipeline/cache/artifact_store.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/numbers/sha256.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/cache/content_hasher.h"
#include "pipeline/graph/stamp_json.h"

namespace keypose::pipeline {

using nlohmann::json;
namespace fs = std::filesystem;

ArtifactStore::ArtifactStore(Disk& disk, fs::path state_folder)
    : disk_(disk), state_folder_(std::move(state_folder)) {}

fs::path ArtifactStore::FolderOf(const std::string& fingerprint) const {
  return state_folder_ / "cache" / fingerprint.substr(0, 2) / fingerprint.substr(2);
}

namespace {

constexpr int kSchema = 2;  // schema 1 had only sizes, and none for the report
constexpr const char* kReport = "report.json";

constexpr const char* kChecksum = "checksum";

// The manifest's own hash goes before its text: a flipped bit in the hash of a file would pass for
// that of another file, whose stamp has not changed.
constexpr std::string_view kSeal = "{\n \"checksum\": \"", kAfterSeal = "\",";
constexpr std::size_t kHashLength = 64;

std::string Sealed(json manifest) {
  manifest.erase(kChecksum);
  const std::string text = manifest.dump(1);
  return fmt::format("{}{}{}{}", kSeal, Sha256Of(text), kAfterSeal, text.substr(1));
}

/// Earlier versions wrote no hash.
bool IsAsSealed(const std::string& text) {
  if (!text.starts_with(kSeal)) return true;
  const std::size_t end = kSeal.size() + kHashLength + kAfterSeal.size();
  return text.size() > end &&
         Sha256Of("{" + text.substr(end)) == text.substr(kSeal.size(), kHashLength);
}

/// A manifest's entry for one file of the artifact.
struct KeptFile {
  std::string hash;
  json stamp;  ///< as StampOf; null: unknown
};

std::map<std::string, std::string> FilesOf(const std::map<std::string, ArtifactOutput>& outputs) {
  std::map<std::string, std::string> files;
  for (const auto& [port, output] : outputs) {
    if (!output.folder) files[output.file] = output.content.hash;
    for (const auto& [name, hash] : output.content.files) files[output.file + "/" + name] = hash;
  }
  return files;
}

json FilesJson(const std::map<std::string, KeptFile>& files) {
  json value = json::object();
  for (const auto& [name, file] : files)
    value[name] = {{"sha256", file.hash}, {"stamp", file.stamp}};
  return value;
}

std::map<std::string, ArtifactOutput> OutputsOf(const json& manifest) {
  std::map<std::string, ArtifactOutput> outputs;
  for (const auto& [port, entry] : manifest.at("outputs").items()) {
    ArtifactOutput& output = outputs[port];
    output.file = entry.at("file").get<std::string>();
    output.folder = entry.at("folder").get<bool>();
    if (output.folder) {
      output.content = FolderContent(entry.at("files").get<std::map<std::string, std::string>>());
    } else {
      output.content.hash = entry.at("sha256").get<std::string>();
    }
    if (output.content.hash != entry.at("sha256").get<std::string>())
      throw InputError("manifest.json contradicts itself");
    if (!IsOneName(output.file))
      throw InputError("manifest.json names '" + output.file + "', which is not a file name");
    for (const auto& [name, hash] : output.content.files)
      if (!StaysBelow(name))
        throw InputError("manifest.json names '" + name + "', which is outside of its folder");
  }
  return outputs;
}

/// All files that an artifact must have.
std::map<std::string, KeptFile> KeptFilesOf(const json& manifest,
                                            const std::map<std::string, ArtifactOutput>& outputs) {
  std::map<std::string, KeptFile> kept;
  for (const auto& [name, hash] : FilesOf(outputs)) kept[name] = {hash, nullptr};
  if (manifest.at("schema") == 1) return kept;
  const json& files = manifest.at("files");
  for (auto& [name, file] : kept) file.stamp = files.at(name).at("stamp");
  if (files.contains(kReport))
    kept[kReport] = {files[kReport].at("sha256").get<std::string>(), files[kReport].at("stamp")};
  return kept;
}

}  // namespace

std::optional<Artifact> ArtifactStore::Find(const std::string& fingerprint,
                                            std::string* damage) const {
  return Look(fingerprint, Reading::kChanged, damage);
}

std::string ArtifactStore::Verify(const std::string& fingerprint) const {
  std::string damage;
  if (!disk_.Stat(FolderOf(fingerprint) / "manifest.json")) return "manifest.json is missing";
  const auto artifact = Look(fingerprint, Reading::kAll, &damage);
  if (!artifact) return damage;
  const std::map<std::string, std::string> known = FilesOf(artifact->outputs);
  for (const auto& [port, output] : artifact->outputs)
    for (const std::string& name : output.folder ? disk_.FilesBelow(artifact->folder / output.file)
                                                 : std::vector<std::string>())
      if (CountsAsContent(name) && !known.contains(output.file + "/" + name))
        return output.file + "/" + name + " was put there by another program";
  return "";
}

std::optional<Artifact> ArtifactStore::Look(const std::string& fingerprint, Reading reading,
                                            std::string* damage) const {
  Artifact artifact;
  artifact.fingerprint = fingerprint;
  artifact.folder = FolderOf(fingerprint);
  const fs::path file = artifact.folder / "manifest.json";
  if (!disk_.Stat(file)) return std::nullopt;
  const auto damaged = [&](const std::string& what) {
    if (damage) *damage = what;
    return std::nullopt;
  };
  try {
    const std::string text = disk_.Read(file);
    if (!IsAsSealed(text)) return damaged("manifest.json is damaged");
    json manifest = json::parse(text);
    artifact.recipe = RecipeFromJson(manifest.at("recipe"));
    // Without this check, two swapped folders or a foreign manifest would give one step's result to
    // another step.
    if (manifest.at("fingerprint") != fingerprint || artifact.recipe.Fingerprint() != fingerprint)
      return damaged("manifest.json belongs to another artifact");
    artifact.outputs = OutputsOf(manifest);
    artifact.seconds = manifest.at("seconds").get<double>();
    artifact.peak_bytes = manifest.at("peak_bytes").get<std::int64_t>();
    std::map<std::string, KeptFile> kept = KeptFilesOf(manifest, artifact.outputs);
    bool moved = false;
    for (auto& [name, known] : kept) {
      const auto stat = disk_.Stat(artifact.folder / name);
      if (!stat || stat->folder) return damaged(name + " is missing");
      const json stamp = StampOf(*stat);
      if (stamp == known.stamp && reading == Reading::kChanged) continue;
      if (disk_.LeadsOutside(artifact.folder / name, artifact.folder))
        return damaged(name + " is a link that leads elsewhere");
      if (disk_.ContentHash(artifact.folder / name) != known.hash)
        return damaged(name + " is not as it was made");
      moved |= stamp != known.stamp;
      known.stamp = stamp;
    }
    if (moved) Remember(file, std::move(manifest), FilesJson(kept));
  } catch (const json::exception&) {
    return damaged("manifest.json is damaged");
  } catch (const InputError& error) {
    return damaged(error.what());
  }
  return artifact;
}

/// The files of a copied project have other times. They are read once; then their new stamps are
/// remembered.
void ArtifactStore::Remember(const fs::path& file, json manifest, json files) const {
  manifest["schema"] = kSchema;
  manifest["files"] = std::move(files);
  manifest.erase("sizes");
  try {
    disk_.Write(file, Sealed(std::move(manifest)));
  } catch (const DiskError&) {
    // Not an error: if this cannot be saved (full or read-only disk), the files are read again next
    // time.
  }
}

ArtifactOutput ArtifactStore::Measure(const fs::path& made, const PortInfo& port) const {
  ArtifactOutput output{port.file, port.kind == "folder", {}};
  if (!output.folder) {
    output.content.hash = disk_.ContentHash(made / port.file);
    return output;
  }
  std::map<std::string, std::string> files;
  for (const std::string& name : disk_.FilesBelow(made / port.file))
    files[name] = disk_.ContentHash(made / port.file / name);
  output.content = FolderContent(std::move(files));
  return output;
}

Artifact ArtifactStore::Commit(const fs::path& made, const StageInfo& info, const Recipe& recipe,
                               double seconds, std::int64_t peak_bytes) {
  Artifact artifact{recipe.Fingerprint(), {}, recipe, {}, seconds, peak_bytes};
  json outputs = json::object();
  for (const PortInfo& port : info.outputs) {
    const auto stat = disk_.Stat(made / port.file);
    if (!stat && port.optional) continue;
    if (!stat || stat->folder != (port.kind == "folder")) {
      throw ToolError(fmt::format("stage '{}' ended well but did not write its output '{}' (a {})",
                                  info.stage, port.name, port.kind));
    }
    const ArtifactOutput output = artifact.outputs[port.name] = Measure(made, port);
    outputs[port.name] = {
        {"file", output.file}, {"folder", output.folder}, {"sha256", output.content.hash}};
    if (output.folder) outputs[port.name]["files"] = output.content.files;
  }
  std::map<std::string, KeptFile> files;
  for (const auto& [name, hash] : FilesOf(artifact.outputs))
    files[name] = {hash, StampOf(*disk_.Stat(made / name))};
  if (const auto report = disk_.Stat(made / kReport); report && !report->folder)
    files[kReport] = {disk_.ContentHash(made / kReport), StampOf(*report)};
  const json manifest = {{"schema", kSchema},         {"fingerprint", artifact.fingerprint},
                         {"recipe", ToJson(recipe)},  {"outputs", outputs},
                         {"files", FilesJson(files)}, {"seconds", seconds},
                         {"peak_bytes", peak_bytes}};
  disk_.Write(made / "manifest.json", Sealed(manifest));
  // The data must reach the device before the rename: after a power cut an artifact is complete or
  // absent.
  disk_.Sync(made);
  artifact.folder = FolderOf(artifact.fingerprint);
  if (disk_.LeadsOutside(artifact.folder, state_folder_ / "cache"))
    throw DiskError(artifact.folder.string() +
                    " is behind a link that leads out of the cache; remove the link");
  disk_.Move(made, artifact.folder);
  return artifact;
}

std::vector<std::string> ArtifactStore::All() const {
  const fs::path cache = state_folder_ / "cache";
  std::vector<std::string> all;
  for (const std::string& head : disk_.Children(cache)) {
    for (const std::string& tail : disk_.Children(cache / head)) {
      // Links in a project from elsewhere may lead out of the cache; what they lead to must not be
      // removed.
      if (!disk_.LeadsOutside(cache / head / tail, cache)) all.push_back(head + tail);
    }
  }
  return all;
}

std::uint64_t ArtifactStore::SizeOf(const std::string& fingerprint) const {
  std::uint64_t size = 0;
  const fs::path folder = FolderOf(fingerprint);
  for (const std::string& name : disk_.FilesBelow(folder))
    size += disk_.Stat(folder / name).value_or(FileStat{}).size;
  return size;
}

void ArtifactStore::Remove(const std::string& fingerprint) {
  // First moved out of the cache in one step: a partly removed folder must not look like an
  // artifact.
  const fs::path doomed = state_folder_ / "tmp" / ("gc-" + fingerprint);
  disk_.Move(FolderOf(fingerprint), doomed);
  disk_.Remove(doomed);
}

}  // namespace keypose::pipeline
