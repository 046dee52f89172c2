#include "studio/project/marks.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/disk/real_disk.h"
#include "studio/project/changes.h"
#include "studio/project/picks.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* kNoBody = "There is no tracked body yet: it is found in the films.";
constexpr const char* kNoScan = "No mesh is named yet that shall move as the actor does.";

void RequirePerformance(const Snapshot& snapshot) {
  if (snapshot.graph().kind != pipeline::ProjectKind::kPerformance)
    throw UsageError("only a performance has marks; key poses have landmarks");
}

/// A file that pipeline.yaml names at its top; none where it names none.
std::optional<fs::path> NamedFile(Snapshot& snapshot, const char* word) {
  const pipeline::Setting* named = snapshot.file().Given(word);
  if (!named) return std::nullopt;
  const fs::path& project = snapshot.project();
  const fs::path file =
      project / pipeline::OnDisk(pipeline::RealDisk(), project, pipeline::WithHome(named->text));
  if (!IsWithin(fs::weakly_canonical(file), fs::canonical(project)))
    throw UsageError(
        fmt::format("{} is outside of the project; copy it in, and name the copy", named->text));
  return file;
}

std::optional<fs::path> BodyMesh(Snapshot& snapshot) {
  for (const pipeline::PoseRule& shot : snapshot.file().poses)
    if (auto body = snapshot.ResultPath("track", shot.name, "reference")) return body;
  return std::nullopt;
}

Mesh NeededMesh(Snapshot& snapshot, MarkSide side) {
  RequirePerformance(snapshot);
  const auto file = MarkedMesh(snapshot, side);
  if (!file) throw UsageError(side == MarkSide::kBody ? kNoBody : kNoScan);
  return ReadMesh(*file);
}

json SideJson(Snapshot& snapshot, MarkSide side) {
  json told = {{"there", false}, {"version", ""}, {"missing", ""}};
  try {
    const auto file = MarkedMesh(snapshot, side);
    if (file) told.update({{"there", true}, {"version", RevisionOf(*file)}});
    if (!file) told["missing"] = side == MarkSide::kBody ? kNoBody : kNoScan;
  } catch (const Error& error) {
    told["missing"] = error.what();
  }
  return told;
}

std::vector<LandmarkPair> ReadMarks(Snapshot& snapshot, CarryLog* log) {
  const fs::path file = MarksFile(snapshot);
  if (!fs::is_regular_file(file)) return {};
  return ReadLandmarkPairs({file}, NeededMesh(snapshot, MarkSide::kBody),
                           NeededMesh(snapshot, MarkSide::kScan), log);
}

/// The page does not show what cannot be read, so it would be lost.
void RequireMarksReadable(Snapshot& snapshot) {
  try {
    ReadMarks(snapshot, nullptr);
  } catch (const Error& error) {
    throw InputError(fmt::format("{}; mend or delete it in an editor first", error.what()));
  }
}

LandmarkPair PairFrom(const json& value, const Mesh& body, const Mesh& scan) {
  LandmarkPair pair;
  pair.source = PickFrom(value.at("source"), body);
  pair.target = PickFrom(value.at("target"), scan);
  if (pair.source.name != pair.target.name)
    throw UsageError(fmt::format("a mark is called '{}' on the body and '{}' on the scan",
                                 pair.source.name, pair.target.name));
  pair.name = pair.source.name;
  return pair;
}

json PairJson(const LandmarkPair& pair) {
  return {{"name", pair.name},
          {"source", PickJson(pair.source)},
          {"target", PickJson(pair.target)},
          {"confirmed", pair.confirmed},
          {"confidence", pair.confidence}};
}

void RemoveMarks(Snapshot& snapshot, const fs::path& file) {
  if (snapshot.file().Given("marks")) {
    const fs::path plan = snapshot.project() / "pipeline.yaml";
    const std::string revision = RevisionOf(plan), text = ReadFile(plan);
    WritePipelineFile(snapshot.project(), Edited([&] { return WithoutValue(text, {"marks"}); }),
                      revision);
  }
  pipeline::RealDisk().Remove(file);
}

/// @throws UsageError  it is not there, or lies elsewhere
fs::path OwnFile(Snapshot& snapshot, const std::string& name) {
  const fs::path file = snapshot.project() / name;
  if (!fs::is_regular_file(file) || pipeline::RealDisk().LeadsOutside(file, snapshot.project()))
    throw UsageError(fmt::format("the project has no file {}", name));
  return file;
}

}  // namespace

std::optional<MarkSide> MarkSideNamed(const std::string& name) {
  if (name == "body") return MarkSide::kBody;
  if (name == "scan") return MarkSide::kScan;
  return std::nullopt;
}

fs::path MarksFile(Snapshot& snapshot) {
  return NamedFile(snapshot, "marks").value_or(snapshot.project() / "marks.json");
}

std::optional<fs::path> MarkedMesh(Snapshot& snapshot, MarkSide side) {
  if (side == MarkSide::kBody) return BodyMesh(snapshot);
  auto scan = NamedFile(snapshot, "scan");
  if (scan && !fs::is_regular_file(*scan)) scan.reset();
  return scan;
}

std::optional<fs::path> ScanTexture(Snapshot& snapshot) {
  auto texture = NamedFile(snapshot, "texture");
  if (texture && !fs::is_regular_file(*texture)) texture.reset();
  return texture;
}

json MarksJson(Snapshot& snapshot) {
  RequirePerformance(snapshot);
  json page = {{"revision", ""},
               {"problem", ""},
               {"pairs", json::array()},
               {"body", SideJson(snapshot, MarkSide::kBody)},
               {"scan", SideJson(snapshot, MarkSide::kScan)}};
  CarryLog log;
  try {
    page["scan"]["textured"] = ScanTexture(snapshot).has_value();
    page["revision"] = RevisionOf(MarksFile(snapshot));
    if (!page["body"]["there"] || !page["scan"]["there"]) return page;
    for (const LandmarkPair& pair : ReadMarks(snapshot, &log))
      page["pairs"].push_back(PairJson(pair));
    for (const std::string& warning : log.warnings)
      page["problem"] = page["problem"].get<std::string>() + warning + "\n";
  } catch (const Error& error) {
    page["problem"] = error.what();
  }
  return page;
}

void SaveMarks(Snapshot& snapshot, const json& body) {
  const Mesh tracked = NeededMesh(snapshot, MarkSide::kBody),
             scan = NeededMesh(snapshot, MarkSide::kScan);
  const fs::path file = MarksFile(snapshot);
  if (RevisionOf(file) != body.at("revision").get<std::string>())
    throw ChangedMeanwhile(
        fmt::format("{} was changed elsewhere; it was read again", file.filename().string()));
  RequireMarksReadable(snapshot);
  std::vector<LandmarkPair> pairs;
  std::set<std::string> names;
  for (const json& value : body.at("pairs")) {
    pairs.push_back(PairFrom(value, tracked, scan));
    if (!names.insert(pairs.back().name).second)
      throw UsageError(fmt::format("two marks are called '{}'", pairs.back().name));
  }
  if (pairs.empty()) return RemoveMarks(snapshot, file);
  if (file.extension() != ".json")
    throw UsageError(fmt::format(
        "pipeline.yaml names {} for the marks, and they are saved as .json: take the line `marks` "
        "out there, or let it name a .json file",
        file.filename().string()));
  pipeline::RealDisk disk(snapshot.project() / ".keypose/studio");
  const fs::path writing = snapshot.project() / ".keypose/studio/marks.json";
  disk.MakeFolder(writing.parent_path());
  WriteLandmarkPairs(writing, tracked, scan, pairs);
  disk.Copy(writing, file);
  disk.Remove(writing);
}

json SuggestedMarksJson(Snapshot& snapshot, const fs::path& file) {
  json all = json::array();
  for (const LandmarkPair& pair : ReadLandmarkPairs({file}, NeededMesh(snapshot, MarkSide::kBody),
                                                    NeededMesh(snapshot, MarkSide::kScan)))
    if (!pair.confirmed) all.push_back(PairJson(pair));
  return all;
}

void UseScan(Snapshot& snapshot, const std::string& scan, const std::string& texture) {
  RequirePerformance(snapshot);
  ReadMesh(OwnFile(snapshot, scan));
  if (!texture.empty()) ReadImageInfo(OwnFile(snapshot, texture));
  const fs::path plan = snapshot.project() / "pipeline.yaml";
  const std::string revision = RevisionOf(plan), text = ReadFile(plan);
  const std::string edited = Edited([&] {
    const std::string named = WithValue(text, {"scan"}, YamlScalar(scan));
    return texture.empty() ? WithoutValue(named, {"texture"})
                           : WithValue(named, {"texture"}, YamlScalar(texture));
  });
  WritePipelineFile(snapshot.project(), edited, revision);
}

}  // namespace keypose::studio
