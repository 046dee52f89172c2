#include "studio/project/picks.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/project/regions_io.h"
#include "core/io/project/stiffness_io.h"
#include "core/io/text/files.h"
#include "core/io/text/yaml_edit.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/disk/real_disk.h"
#include "studio/project/changes.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

Mesh PickedMeshOf(Snapshot& snapshot, const std::string& pose) {
  if (!snapshot.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
  if (snapshot.IsFitted(pose))
    throw UsageError(fmt::format(
        "pose '{}' comes from few photographs (`method: fit`): it has no scan to pick on", pose));
  const auto path = snapshot.PickedMesh(pose);
  if (!path)
    throw UsageError(
        fmt::format("pose '{}' has no mesh to pick on yet; run the steps up to {} first", pose,
                    snapshot.IsTemplate(pose) ? "unwrap" : "cleanup"));
  return ReadMesh(*path);
}

void RequirePick(const Landmark& pick, const Mesh& mesh) {
  const double sum = pick.barycentric.sum();
  if (pick.face < 0 || pick.face >= mesh.face_count())
    throw UsageError(fmt::format(
        "landmark '{}' is on face {}, but the mesh has {}; the page shows an older mesh", pick.name,
        pick.face, mesh.face_count()));
  if (!pick.barycentric.allFinite() || pick.barycentric.minCoeff() < -1e-6 ||
      std::abs(sum - 1) > 1e-6)
    throw UsageError(fmt::format("landmark '{}' is not on its face", pick.name));
}

/// A number from a request as an index. Another number than a whole one, or a very large one, is
/// no index of any mesh: -1.
int IndexOf(const json& value) {
  const double number = value;
  return number >= 0 && number <= 2e9 && number == std::floor(number) ? static_cast<int>(number)
                                                                      : -1;
}

void RequireNamesOnce(const std::vector<Landmark>& picks) {
  std::map<std::string, int> count;
  for (const Landmark& pick : picks)
    if (++count[pick.name] > 1)
      throw UsageError(fmt::format("two landmarks are called '{}'", pick.name));
}

void WritePicks(Snapshot& snapshot, const std::string& pose, const Mesh& mesh,
                const std::vector<Landmark>& picks) {
  if (picks.empty()) return RemovePicks(snapshot, pose);
  const fs::path file = PicksFile(snapshot, pose);
  if (file.extension() != ".json")
    throw UsageError(fmt::format(
        "pipeline.yaml names {} for the landmarks of '{}', and picks are saved as .json: take the "
        "line `landmarks` out there, or let it name a .json file",
        file.filename().string(), pose));
  pipeline::RealDisk disk(snapshot.project() / ".keypose/studio");
  const fs::path writing = snapshot.project() / ".keypose/studio/picks.json";
  disk.MakeFolder(writing.parent_path());
  WriteLandmarks(writing, mesh, picks);
  disk.Copy(writing, file);
  disk.Remove(writing);
}

/// The page does not show what cannot be read, so it would be lost.
void RequireReadable(Snapshot& snapshot, const std::string& pose, const Mesh& mesh) {
  const fs::path file = PicksFile(snapshot, pose);
  if (!fs::is_regular_file(file)) return;
  try {
    ReadPicks(file, mesh, nullptr, pose);
  } catch (const Error& error) {
    throw InputError(fmt::format("{}; mend or delete it in an editor first", error.what()));
  }
}

/// Picks without a partner, and what the pipeline would say of the file.
json ProblemsOf(const CarryLog& log) {
  json problems = json::array();
  for (const std::string& warning : log.warnings)
    problems.push_back({{"name", ""}, {"text", warning}});
  return problems;
}

void RequireRevision(const fs::path& file, const json& body) {
  if (RevisionOf(file) != body.at("revision").get<std::string>())
    throw ChangedMeanwhile(
        fmt::format("{} was changed elsewhere; it was read again", file.filename().string()));
}

std::string TemplatePose(Snapshot& snapshot) { return snapshot.graph().template_pose; }

/// Those of the file, on the template as it is now, if it has a mesh.
/// @throws InputError  it cannot be read, or they could not follow the template
std::vector<TimelineRegion> KnownRegions(Snapshot& snapshot, const fs::path& file) {
  if (!fs::is_regular_file(file)) return {};
  try {
    if (!snapshot.PickedMesh(TemplatePose(snapshot))) return RegionsOn(file, nullptr);
    const Mesh mesh = PickedMeshOf(snapshot, TemplatePose(snapshot));
    return RegionsOn(file, &mesh);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}; to paint all regions anew, move {} away", error.what(),
                                 file.filename().string()));
  }
}

}  // namespace

json PickJson(const Landmark& pick) {
  return {{"name", pick.name},
          {"face", pick.face},
          {"barycentric", {pick.barycentric[0], pick.barycentric[1], pick.barycentric[2]}}};
}

Landmark PickFrom(const json& value, const Mesh& mesh) {
  Landmark pick;
  pick.name = value.at("name");
  pick.face = IndexOf(value.at("face"));
  const json& weights = value.at("barycentric");
  for (std::size_t k = 0; k < 3; ++k) pick.barycentric[static_cast<int>(k)] = weights.at(k);
  RequirePick(pick, mesh);
  if (pick.name.empty() || !IsValidUtf8(pick.name)) throw UsageError("a landmark has no name");
  return pick;
}

fs::path PicksFile(Snapshot& snapshot, const std::string& pose) {
  const fs::path& project = snapshot.project();
  const pipeline::PoseRule* rule = snapshot.file().FindPose(pose);
  const pipeline::Setting* named = rule ? rule->Given("landmarks") : nullptr;
  if (!named) return project / "landmarks" / (pose + ".json");
  const std::string written = pipeline::WithHome(named->text);
  const fs::path file = project / pipeline::OnDisk(pipeline::RealDisk(), project, written);
  if (!IsWithin(fs::weakly_canonical(file), fs::canonical(project)))
    throw UsageError(fmt::format("the landmarks {} are outside of the project", file.string()));
  return file;
}

fs::path ExistingPicks(Snapshot& snapshot, const std::string& pose) {
  const fs::path file = PicksFile(snapshot, pose);
  if (fs::is_regular_file(file)) return file;
  const pipeline::PoseRule* rule = snapshot.file().FindPose(pose);
  const fs::path points = snapshot.project() / "landmarks" / (pose + ".pp");
  const bool taken = !(rule && rule->Given("landmarks")) && fs::is_regular_file(points);
  return taken ? points : fs::path();
}

void RemovePicks(Snapshot& snapshot, const std::string& pose) {
  const fs::path file = PicksFile(snapshot, pose);
  const pipeline::PoseRule* rule = snapshot.file().FindPose(pose);
  if (rule && rule->Given("landmarks")) {
    const fs::path whole = snapshot.project() / "pipeline.yaml";
    const std::string revision = RevisionOf(whole), text = ReadFile(whole);
    const std::string edited = Edited([&] {
      const std::string without = WithoutValue(text, {"poses", pose, "landmarks"});
      // A pose of which nothing else was said goes with its empty map.
      const bool there = pipeline::ParsePipelineFile(without, "pipeline.yaml").FindPose(pose);
      return there ? without : WithValue(text, {"poses", pose}, YamlScalar("photos/" + pose));
    });
    WritePipelineFile(snapshot.project(), edited, revision);
  }
  pipeline::RealDisk().Remove(file);
}

json PicksJson(Snapshot& snapshot, const std::string& pose) {
  const Mesh mesh = PickedMeshOf(snapshot, pose);
  json picks = {
      {"pose", pose}, {"revision", ""}, {"picks", json::array()}, {"problems", json::array()}};
  CarryLog log;
  try {
    picks["revision"] = RevisionOf(PicksFile(snapshot, pose));
    const fs::path file = ExistingPicks(snapshot, pose);
    if (file.empty()) return picks;
    for (const Landmark& pick : ReadPicks(file, mesh, &log, pose))
      picks["picks"].push_back(PickJson(pick));
    picks["problems"] = ProblemsOf(log);
  } catch (const Error& error) {
    picks["problems"].push_back({{"name", ""}, {"text", error.what()}});
  }
  return picks;
}

void SavePicks(Snapshot& snapshot, const std::string& pose, const json& body) {
  const Mesh mesh = PickedMeshOf(snapshot, pose);
  RequireRevision(PicksFile(snapshot, pose), body);
  RequireReadable(snapshot, pose, mesh);
  std::vector<Landmark> picks;
  for (const json& value : body.at("picks")) picks.push_back(PickFrom(value, mesh));
  RequireNamesOnce(picks);
  WritePicks(snapshot, pose, mesh, picks);
}

void ImportPicks(Snapshot& snapshot, const std::string& pose, const std::string& name,
                 const std::string& text) {
  const Mesh mesh = PickedMeshOf(snapshot, pose);
  RequireShallowJson(text, name);
  std::vector<Landmark> picks;
  const fs::path file = snapshot.project() / ".keypose/studio/import";
  fs::create_directories(file.parent_path());
  WriteFile(file, text);
  try {
    picks = ReadPicks(file, mesh, nullptr, pose);
  } catch (const Error& error) {
    // The person knows the file by its own name.
    std::string words = error.what();
    if (const auto at = words.find(file.string()); at != std::string::npos)
      words.replace(at, file.string().size(), name);
    throw InputError(words);
  }
  RequireNamesOnce(picks);
  WritePicks(snapshot, pose, mesh, picks);
}

std::string ExportPicks(Snapshot& snapshot, const std::string& pose, const std::string& format) {
  const Mesh mesh = PickedMeshOf(snapshot, pose);
  const fs::path file = ExistingPicks(snapshot, pose);
  if (file.empty()) throw UsageError(fmt::format("pose '{}' has no landmarks yet", pose));
  const std::vector<Landmark> picks = ReadPicks(file, mesh, nullptr, pose);
  if (format == "pp") return PickedPointsText(picks, mesh);
  if (format == "wrap") return WrapPointsText(picks);
  if (format == "json") return ReadFile(file);
  throw UsageError(fmt::format("landmarks are written as json, pp or wrap, not as {}", format));
}

std::vector<Landmark> TemplatePicks(Snapshot& snapshot, Mesh* mesh) {
  const std::string whole = TemplatePose(snapshot);
  if (!snapshot.PickedMesh(whole)) return {};
  *mesh = PickedMeshOf(snapshot, whole);
  try {
    const fs::path file = ExistingPicks(snapshot, whole);
    if (file.empty()) return {};
    return ReadPicks(file, *mesh, nullptr, whole);
  } catch (const Error&) {
    return {};  // PicksJson tells of it
  }
}

json AdviceJson(Snapshot& snapshot, const std::string& pose) {
  json advice = json::array();
  const auto result = snapshot.Result("register", pose);
  if (!result) return advice;
  const json report = json::parse(ReadFile(result->folder / "report.json"), nullptr, false);
  if (!report.contains("measurements")) return advice;
  for (const json& one : report["measurements"].value("landmark_advice", json::array()))
    advice.push_back({{"vertex", one.at("vertex")},
                      {"place", one.at("position")},
                      {"need", one.at("score")},
                      {"reason", one.value("reason", "")}});
  return advice;
}

json PairFitJson(Snapshot& snapshot, const std::string& pose) {
  if (!snapshot.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
  json fit = {{"pairs", json::array()}};
  const std::string whole = TemplatePose(snapshot);
  const auto registered = snapshot.MeshPath(pose, MeshKind::kMesh);
  const fs::path source = ExistingPicks(snapshot, whole), target = ExistingPicks(snapshot, pose);
  if (pose == whole || !registered || source.empty() || target.empty()) return fit;
  const Mesh scan = PickedMeshOf(snapshot, pose), bent = ReadMesh(*registered);
  const Mesh flat = PickedMeshOf(snapshot, whole);
  // A template that was made anew since has other faces than the registered one.
  if (bent.face_count() != flat.face_count()) return fit;
  const double diagonal = BoundingDiagonal(scan.points);
  std::map<std::string, Landmark> there;
  for (const Landmark& pick : ReadPicks(target, scan, nullptr, pose)) there[pick.name] = pick;
  for (const Landmark& pick : ReadPicks(source, flat, nullptr, whole)) {
    const auto other = there.find(pick.name);
    if (other == there.end()) continue;
    const double off = (PositionOf(pick, bent) - PositionOf(other->second, scan)).norm();
    fit["pairs"].push_back({{"name", pick.name}, {"distance", off / diagonal}});
  }
  return fit;
}

json SuggestionsJson(Snapshot& snapshot, const std::string& pose, const fs::path& suggested) {
  const Mesh source = PickedMeshOf(snapshot, TemplatePose(snapshot));
  const Mesh target = PickedMeshOf(snapshot, pose);
  json all = json::array();
  for (const LandmarkPair& pair : ReadLandmarkPairs({suggested}, source, target)) {
    if (pair.confirmed) continue;
    all.push_back({{"name", pair.name},
                   {"source", PickJson(pair.source)},
                   {"target", PickJson(pair.target)},
                   {"confidence", pair.confidence}});
  }
  return all;
}

json StiffnessJson(Snapshot& snapshot) {
  const Mesh mesh = PickedMeshOf(snapshot, TemplatePose(snapshot));
  const fs::path file = snapshot.project() / "stiffness.json";
  json body = {{"revision", RevisionOf(file)}, {"values", nullptr}};
  if (!fs::is_regular_file(file)) return body;
  const Eigen::VectorXd values = StiffnessOn(mesh, ReadFile(file), {}, "stiffness.json", nullptr);
  body["values"] = std::vector<double>(values.begin(), values.end());
  return body;
}

void SaveStiffness(Snapshot& snapshot, const json& body) {
  const Mesh mesh = PickedMeshOf(snapshot, TemplatePose(snapshot));
  const fs::path file = snapshot.project() / "stiffness.json";
  RequireRevision(file, body);
  if (body.at("values").is_null()) return pipeline::RealDisk().Remove(file);
  const std::vector<double> values = body.at("values");
  if (static_cast<int>(values.size()) != mesh.vertex_count())
    throw UsageError(fmt::format("{} values for {} vertices; the page shows an older mesh",
                                 values.size(), mesh.vertex_count()));
  Eigen::VectorXd factors(mesh.vertex_count());
  for (int i = 0; i < mesh.vertex_count(); ++i) {
    factors[i] = values[static_cast<std::size_t>(i)];
    if (!(factors[i] > 0) || factors[i] > 1e6)
      throw UsageError(fmt::format("vertex {} has the stiffness {}", i, factors[i]));
  }
  WriteFileAtomically(file, BoundStiffnessText(mesh, factors));
}

json RegionsJson(Snapshot& snapshot) {
  const fs::path file = snapshot.project() / "regions.json";
  json body = {{"revision", RevisionOf(file)}, {"regions", json::object()}};
  for (const TimelineRegion& region : KnownRegions(snapshot, file))
    if (!region.vertices.empty()) body["regions"][region.name] = region.vertices;
  return body;
}

void SaveRegions(Snapshot& snapshot, const json& body) {
  const Mesh mesh = PickedMeshOf(snapshot, TemplatePose(snapshot));
  const fs::path file = snapshot.project() / "regions.json";
  RequireRevision(file, body);
  std::vector<TimelineRegion> regions;
  // Balls are written by hand: the page neither shows nor loses them.
  for (const TimelineRegion& known : KnownRegions(snapshot, file))
    if (known.vertices.empty() && !body.at("regions").contains(known.name))
      regions.push_back(known);
  for (const auto& [name, vertices] : body.at("regions").items()) {
    TimelineRegion region;
    region.name = name;
    for (const json& vertex : vertices) region.vertices.push_back(IndexOf(vertex));
    regions.push_back(region);
  }
  if (regions.empty()) return pipeline::RealDisk().Remove(file);
  const fs::path writing = snapshot.project() / ".keypose/studio/regions.json";
  fs::create_directories(writing.parent_path());
  WriteRegions(writing, mesh, regions);
  fs::rename(writing, file);
}

}  // namespace keypose::studio
