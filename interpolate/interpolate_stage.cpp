// keypose-interpolate: frames between keys.
#include <cstdio>
#include <string>
#include <vector>

#include "core/errors.h"
#include "core/geometry.h"
#include "core/io/files.h"
#include "core/io/mesh_io.h"
#include "core/stage/stage.h"
#include "interpolate/distortion.h"
#include "interpolate/sequence.h"

namespace keypose::interpolation {
namespace {

struct InterpolateOptions {
  std::string method = "arap";
  int steps = 9;  ///< in-betweens of each pair of keys; a timeline wins
  std::string align = "none";

  void Describe(OptionVisitor& visit) {
    visit("method", method,
          {.help = "arap: as rigid as possible; paper: the paper's system to the letter; linear: straight lines",
           .unit = "",
           .choices = {"arap", "paper", "linear"}});
    visit("steps", steps, {"in-betweens of each pair of keys, where no timeline is given", "frames", 0, 100000, {}});
    visit("align", align,
          {.help = "brings later keys onto the first; upright: a turn about z and a translation",
           .unit = "",
           .choices = {"none", "upright", "rigid", "similarity"}});
  }
};

StageSpec Spec() {
  StageSpec spec;
  spec.name = "interpolate";
  spec.version = "1";
  spec.summary = "Frames between keys of one connectivity, as rigid as possible.";
  spec.inputs = {{"keys", "file", "key meshes with the same faces, in order, two or more", "", false, true},
                 {"timeline", "file", "JSON: fps, and a time in seconds for each key", "", true, false}};
  spec.outputs = {{"frames", "folder", "frame_0000.ply ... and distortion.json", "frames", false, false}};
  spec.memory_gib = 2;
  return spec;
}

std::vector<Mesh> LoadKeys(StageContext& stage) {
  std::vector<Mesh> keys;
  for (const std::filesystem::path& path : stage.Inputs("keys")) {
    keys.push_back(ReadMesh(path));
    const Mesh& key = keys.back();
    RequireUsable(key, "interpolate: key '" + path.filename().string() + "'");
    if (key.faces.rows() != keys[0].faces.rows() || key.faces != keys[0].faces || key.points.rows() != keys[0].points.rows())
      throw InputError("interpolate: key '" + path.filename().string() +
                       "' does not have the faces of the first key; register all poses from one template");
  }
  if (keys.size() < 2) throw UsageError("interpolate: needs at least two keys; pass --keys once for each");
  return keys;
}

AlignKeys AlignOf(const std::string& name) {
  if (name == "upright") return AlignKeys::kUpright;
  if (name == "rigid") return AlignKeys::kRigid;
  return name == "similarity" ? AlignKeys::kSimilarity : AlignKeys::kNone;
}

Method MethodOf(const std::string& name) {
  if (name == "paper") return Method::kPaper;
  return name == "linear" ? Method::kLinear : Method::kArap;
}

void ReportAll(StageContext& stage, const Sequence& sequence, const DistortionReport& report, const std::string& method) {
  stage.Report("frames", static_cast<std::int64_t>(sequence.frames.size()));
  stage.Report("keys", static_cast<std::int64_t>(sequence.key_frames.size()));
  if (method == "arap") {
    stage.Report("degenerate_faces", sequence.degenerate_faces);
    stage.Report("largest_turn_rad", sequence.largest_turn);
  }
  const SegmentDistortion& first = report.segments.front();
  stage.Report("area_mean", first.area.mean);
  stage.Report("area_sd", first.area.sd);
  stage.Report("volume_mean", first.volume.mean);
  stage.Report("volume_sd", first.volume.sd);
  stage.Report("linear_area_mean", first.linear_area.mean);
  stage.Report("linear_area_sd", first.linear_area.sd);
  stage.Report("linear_volume_mean", first.linear_volume.mean);
  stage.Report("linear_volume_sd", first.linear_volume.sd);
  for (const std::string& line : ToTable(report, method)) stage.Note(line);
}

void Run(StageContext& stage, const InterpolateOptions& options) {
  const std::vector<Mesh> keys = LoadKeys(stage);
  const int count = static_cast<int>(keys.size());
  std::vector<int> in_betweens(count - 1, options.steps);
  if (stage.Has("timeline")) {
    const std::filesystem::path path = stage.Input("timeline");
    in_betweens = InBetweensFromTimeline(ReadFile(path), path.filename().string(), count);
  }
  std::vector<PointsX3> points;
  for (const Mesh& key : keys) points.push_back(key.points);
  points = AlignedKeys(points, AlignOf(options.align));
  SubProgress bending(stage.progress(), 0.0, 0.7);
  const Sequence sequence = Interpolate(points, keys[0].faces, in_betweens, MethodOf(options.method), &bending);
  const DistortionReport report = MeasureDistortion(sequence, keys[0].faces);
  ReportAll(stage, sequence, report, options.method);

  const std::filesystem::path folder = stage.Output("frames");
  Mesh mesh = keys[0];
  mesh.normals.resize(0, 3);
  for (std::size_t f = 0; f < sequence.frames.size(); ++f) {
    Step(stage.progress(), 0.7 + 0.3 * static_cast<double>(f) / static_cast<double>(sequence.frames.size()), "writing frames");
    char name[32];
    std::snprintf(name, sizeof name, "frame_%04zu.ply", f);
    mesh.points = sequence.frames[f].points;
    WriteMesh(folder / name, mesh);
  }
  WriteFile(folder / "distortion.json", ToJson(report, sequence, options.method));
}

}  // namespace
}  // namespace keypose::interpolation

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::interpolation::InterpolateOptions>(argc, argv, keypose::interpolation::Spec(),
                                                                       keypose::interpolation::Run);
}
