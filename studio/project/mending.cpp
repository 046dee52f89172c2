#include "studio/project/mending.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/project/mending_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "deform/mending/mend.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/disk/real_disk.h"
#include "studio/project/changes.h"
#include "studio/project/left_out_photographs.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::size_t kMostStrokes = 2000, kMostPlaces = 2000;

fs::path MendingFile(Snapshot& snapshot, const std::string& pose) {
  const fs::path& project = snapshot.project();
  const pipeline::PoseRule* rule = snapshot.file().FindPose(pose);
  const pipeline::Setting* named = rule ? rule->Given("mending") : nullptr;
  const std::string written = named ? pipeline::WithHome(named->text) : "mending/" + pose + ".json";
  const fs::path file = project / pipeline::OnDisk(pipeline::RealDisk(), project, written);
  if (!IsWithin(fs::weakly_canonical(file), fs::canonical(project)))
    throw UsageError(fmt::format("the strokes {} are outside of the project", file.string()));
  return file;
}

void RequireStroke(const MendStroke& stroke, const Mesh& mesh) {
  const double least = stroke.tool == MendTool::kPull ? -1 : 0;
  if (!(std::isfinite(stroke.radius) && stroke.radius > 0))
    throw UsageError("a stroke needs a radius above 0");
  if (!(stroke.strength >= least && stroke.strength <= 1))
    throw UsageError(fmt::format("a stroke needs a strength from {:.0f} to 1", least));
  if (stroke.places.empty() || stroke.places.size() > kMostPlaces)
    throw UsageError(fmt::format("a stroke needs 1 to {} places", kMostPlaces));
  for (const MendStroke::Place& place : stroke.places)
    if (place.face < 0 || place.face >= mesh.face_count() || !place.barycentric.allFinite() ||
        place.barycentric.minCoeff() < -1e-6 || std::abs(place.barycentric.sum() - 1) > 1e-6)
      throw UsageError("a place of a stroke is not on the mesh; the page shows an older mesh");
}

/// @throws json::exception  not as the page sends it
std::vector<MendStroke> StrokesOf(const json& body, const Mesh& mesh) {
  std::vector<MendStroke> strokes;
  if (body.at("strokes").size() > kMostStrokes)
    throw UsageError(fmt::format("a mesh takes at most {} strokes", kMostStrokes));
  for (const json& one : body.at("strokes")) {
    const auto tool = MendToolNamed(one.at("tool").get<std::string>());
    if (!tool) throw UsageError("the brush smooths, pulls or fills");
    // Read again, what is left of it would pass for the whole stroke.
    if (!one.value("fault", "").empty())
      throw UsageError(fmt::format("stroke {} ({}) does not lie on the mesh any more: take it out",
                                   strokes.size() + 1, NameOf(*tool)));
    MendStroke stroke{*tool, one.at("radius"), one.at("strength"), {}};
    for (const json& written : one.at("places")) {
      const double face = written.at("face");
      MendStroke::Place place;
      place.face = face >= 0 && face < mesh.face_count() ? static_cast<int>(face) : -1;
      for (std::size_t k = 0; k < 3; ++k)
        place.barycentric[static_cast<int>(k)] = written.at("barycentric").at(k);
      stroke.places.push_back(place);
    }
    RequireStroke(stroke, mesh);
    strokes.push_back(std::move(stroke));
  }
  return strokes;
}

json StrokeJson(const MendStroke& stroke, const std::string& fault) {
  json places = json::array();
  for (const MendStroke::Place& place : stroke.places) {
    const Eigen::Vector3d& b = place.barycentric;
    places.push_back({{"face", place.face}, {"barycentric", {b[0], b[1], b[2]}}});
  }
  return {{"tool", NameOf(stroke.tool)},
          {"radius", stroke.radius},
          {"strength", stroke.strength},
          {"places", places},
          {"fault", fault}};
}

/// What the step makes of the strokes runs again, and all after it.
json AgainOf(Snapshot& snapshot, const std::string& pose) {
  const pipeline::Step* mend = snapshot.FindStep("mend", pose);
  const pipeline::Step* before = snapshot.FindStep("cleanup", pose);
  json again = AgainAfter(snapshot, mend ? mend : before);
  if (mend || !before) return again;
  // What is mended stays.
  const auto& last = snapshot.plan()[static_cast<int>(before - snapshot.graph().steps.data())].last;
  if (last && !last->failed) again["seconds"] = again["seconds"].get<double>() - last->seconds;
  again["step"] = "";
  return again;
}

/// @param path  of the mesh, whose name in the cache changes with its content
json AnswerOf(Snapshot& snapshot, const std::string& pose, const fs::path& path) {
  json answer = {{"revision", ""},
                 {"problem", ""},
                 {"mesh", path.parent_path().filename().string()},
                 {"strokes", json::array()},
                 {"again", AgainOf(snapshot, pose)}};
  const fs::path file = MendingFile(snapshot, pose);
  answer["revision"] = RevisionOf(file);
  if (!fs::is_regular_file(file)) return answer;
  try {
    const MendStrokes read = ReadMendStrokes(file, ReadMesh(path), nullptr);
    for (std::size_t i = 0; i < read.strokes.size(); ++i)
      answer["strokes"].push_back(StrokeJson(read.strokes[i], read.faults[i]));
  } catch (const Error& error) {
    answer["problem"] = error.what();
  }
  return answer;
}

}  // namespace

fs::path MeshToMend(Snapshot& snapshot, const std::string& pose) {
  if (!snapshot.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
  if (snapshot.IsFitted(pose))
    throw UsageError(
        fmt::format("{} comes from few photographs and has the net of {}: mend that one", pose,
                    snapshot.graph().template_pose));
  if (!snapshot.FindStep("cleanup", pose))
    throw UsageError(fmt::format("{} is a mesh that is taken as it is: mend its file", pose));
  const auto path = snapshot.ResultPath("cleanup", pose, "clean");
  if (!path) throw UsageError(fmt::format("{} has no mesh yet: press Run, then mend it", pose));
  return *path;
}

json MendingJson(Snapshot& snapshot, const std::string& pose) {
  if (!snapshot.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
  try {
    return AnswerOf(snapshot, pose, MeshToMend(snapshot, pose));
  } catch (const UsageError& error) {
    return {{"revision", ""},
            {"problem", error.what()},
            {"mesh", ""},
            {"strokes", json::array()},
            {"again", AgainAfter(snapshot, nullptr)}};
  }
}

json SaveMending(Snapshot& snapshot, const std::string& pose, const json& body) {
  const fs::path path = MeshToMend(snapshot, pose), file = MendingFile(snapshot, pose);
  const Mesh mesh = ReadMesh(path);
  const std::vector<MendStroke> strokes = StrokesOf(body, mesh);
  if (RevisionOf(file) != body.at("revision").get<std::string>())
    throw ChangedMeanwhile(
        fmt::format("{} was changed elsewhere; it was read again", file.filename().string()));
  if (strokes.empty()) {
    pipeline::RealDisk().Remove(file);
  } else {
    fs::create_directories(file.parent_path());
    WriteFileAtomically(file, MendStrokesText(mesh, strokes));
  }
  json answer = {{"revision", RevisionOf(file)}, {"strokes", json::array()}};
  for (const MendStroke& stroke : strokes) answer["strokes"].push_back(StrokeJson(stroke, ""));
  return answer;
}

std::string DraftedMending(Snapshot& snapshot, const std::string& pose, const json& body) {
  const Mesh mesh = ReadMesh(MeshToMend(snapshot, pose));
  const Mended mended = Mend(mesh, StrokesOf(body, mesh), nullptr);
  std::vector<float> numbers(mended.points.data(), mended.points.data() + mended.points.size());
  for (const MendDone& done : mended.done) {
    numbers.push_back(static_cast<float>(done.vertices));
    numbers.push_back(static_cast<float>(done.furthest));
  }
  std::string bytes(numbers.size() * sizeof(float), '\0');
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

}  // namespace keypose::studio
