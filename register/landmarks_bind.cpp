#include "register/landmarks_bind.h"

#include <yaml-cpp/yaml.h>

#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/project/regions_io.h"
#include "core/io/project/stiffness_io.h"
#include "core/io/text/files.h"
#include "core/stage/stage.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"

namespace keypose::registration {
namespace {

struct BindOptions {
  void Describe(OptionVisitor&) {}
};

StageSpec BindSpec() {
  StageSpec spec;
  spec.name = "landmarks bind";
  spec.version = "1";
  spec.summary =
      "Binds picks, a painted stiffness or a timeline's regions to their mesh, so that they stay "
      "valid when the mesh is rebuilt.";
  spec.inputs = {
      {"mesh", "file", "the mesh of the picks, the stiffness or the regions", "", true, false},
      {"source", "file", "for pairs: the source mesh", "", true, false},
      {"target", "file", "for pairs: the target mesh", "", true, false},
      {"picks", "file", "picks of one mesh (.json, .pp), or pairs (.json, text)", "", true, false},
      {"stiffness", "file", "a number for each vertex", "", true, false},
      {"timeline", "file",
       "pipeline.yaml or a timeline, for its regions; --mesh is the first key's mesh", "", true,
       false}};
  spec.outputs = {{"bound", "file", "the bound file (.json); may be the same as the input",
                   "bound.json", false, false, true}};
  return spec;
}

Mesh Load(StageContext& stage, const std::string& port) {
  Mesh mesh = ReadMesh(stage.Input(port));
  RequireUsable(mesh, stage.Input(port).string());
  return mesh;
}

void Require(StageContext& stage, const std::string& given, const std::string& port) {
  if (!stage.Has(port)) throw UsageError("landmarks bind: --" + given + " needs --" + port);
}

/// Passes on notes about picks that moved, but not the warning that the file names no mesh: that is
/// the reason to bind it.
void Tell(StageContext& stage, const CarryLog& log) {
  for (const std::string& note : log.notes) stage.Note(note);
}

void BindPicks(StageContext& stage) {
  CarryLog log;
  if (stage.Has("source") || stage.Has("target")) {
    Require(stage, "picks of pairs", "source");
    Require(stage, "picks of pairs", "target");
    const Mesh source = Load(stage, "source"), target = Load(stage, "target");
    const auto pairs = ReadLandmarkPairs({stage.Input("picks")}, source, target, &log);
    Tell(stage, log);
    return WriteLandmarkPairs(stage.Output("bound"), source, target, pairs);
  }
  Require(stage, "picks", "mesh");
  const Mesh mesh = Load(stage, "mesh");
  const std::vector<Landmark> picks = ReadPicks(stage.Input("picks"), mesh, &log);
  Tell(stage, log);
  if (picks.empty()) throw InputError(stage.Input("picks").string() + " has no landmarks");
  WriteLandmarks(stage.Output("bound"), mesh, picks);
}

void BindStiffness(StageContext& stage) {
  Require(stage, "stiffness", "mesh");
  const Mesh mesh = Load(stage, "mesh");
  const std::filesystem::path path = stage.Input("stiffness");
  const std::string text = ReadFile(path);
  CarryLog log;
  const Eigen::VectorXd stiffness =
      StiffnessOn(mesh, text, text.starts_with("ply") ? ReadMesh(path) : Mesh(),
                  path.filename().string(), &log);
  Tell(stage, log);
  WriteFile(stage.Output("bound"), BoundStiffnessText(mesh, stiffness));
}

Eigen::Vector3d PointOf(const YAML::Node& node) {
  return {node[0].as<double>(), node[1].as<double>(), node[2].as<double>()};
}

/// The regions of a project's pipeline.yaml or of a timeline. The runner checks everything else.
std::vector<TimelineRegion> RegionsOf(const std::filesystem::path& path) {
  std::vector<TimelineRegion> regions;
  try {
    const YAML::Node root = YAML::Load(ReadFile(path));
    const YAML::Node timeline = root["timeline"] ? root["timeline"] : root;
    if (timeline.IsMap() && timeline["regions"]) {
      for (const YAML::Node& node : timeline["regions"]) {
        TimelineRegion region;
        region.name = node["name"].as<std::string>();
        if (node["vertices"])
          region.vertices = node["vertices"].as<std::vector<int>>();
        else {
          region.center = PointOf(node["center"]);
          region.radius = node["radius"].as<double>();
        }
        regions.push_back(std::move(region));
      }
    }
  } catch (const YAML::Exception& error) {
    throw InputError(path.string() + ": its regions cannot be read: " + error.what());
  }
  if (regions.empty())
    throw InputError(
        path.string() +
        " has no regions: `timeline: {regions: [{name: feet, vertices: [...]}], keys: ...}`");
  return regions;
}

void Run(StageContext& stage, const BindOptions&) {
  const int given = stage.Has("picks") + stage.Has("stiffness") + stage.Has("timeline");
  if (given != 1)
    throw UsageError("landmarks bind: give one of --picks, --stiffness and --timeline");
  if (stage.Has("picks")) return BindPicks(stage);
  if (stage.Has("stiffness")) return BindStiffness(stage);
  Require(stage, "timeline", "mesh");
  WriteRegions(stage.Output("bound"), Load(stage, "mesh"), RegionsOf(stage.Input("timeline")));
}

}  // namespace

int BindMain(int argc, char** argv) { return RunStage<BindOptions>(argc, argv, BindSpec(), Run); }

}  // namespace keypose::registration
