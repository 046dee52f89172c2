// keypose-interpolate: frames between keys.
#include <cmath>
#include <cstdio>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/mesh_look.h"
#include "core/io/meshes/polygon_mesh.h"
#include "core/io/project/regions_io.h"
#include "core/io/project/timeline_json.h"
#include "core/io/text/files.h"
#include "core/stage/stage.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "core/values/same_faces.h"
#include "core/values/size_of.h"
#include "interpolate/closed_seams.h"
#include "interpolate/distortion_meter.h"
#include "interpolate/interpolate_options.h"
#include "interpolate/sequence.h"
#include "interpolate/timing/frame_schedule.h"
#include "interpolate/timing/rules.h"

namespace keypose::interpolation {
namespace {

StageSpec Spec() {
  StageSpec spec;
  spec.name = "interpolate";
  spec.version = "9";
  spec.summary = "Frames between keys of one connectivity, as rigid as possible.";
  spec.title = "In-betweens";
  spec.inputs = {
      {"keys", "file", "key meshes with the same faces, in order, two or more", "", false, true},
      {"timeline", "file",
       "JSON: frames per second; time, hold, ease, step of each key; pins, paths, table, volume",
       "", true, false},
      {"regions", "file", "the timeline's regions, bound to a mesh (keypose landmarks bind)", "",
       true, false}};
  spec.outputs = {
      {"frames", "folder", "frame_0000.ply ... and distortion.json", "frames", false, false}};
  spec.memory_gib = 2;
  return spec;
}

std::vector<Mesh> LoadKeys(StageContext& stage) {
  std::vector<Mesh> keys;
  for (const std::filesystem::path& path : stage.Inputs("keys")) {
    keys.push_back(keys.empty() ? ReadMesh(path) : ReadMeshCutAs(path, keys[0]));
    const Mesh& key = keys.back();
    RequireUsable(key, "interpolate: key '" + path.filename().string() + "'");
    if (!SameFaces(key.faces, keys[0].faces) || key.points.rows() != keys[0].points.rows())
      throw InputError(
          "interpolate: key '" + path.filename().string() +
          "' does not have the faces of the first key; register all poses from one template");
  }
  if (keys.size() < 2)
    throw UsageError("interpolate: needs at least two keys; pass --keys once for each");
  return keys;
}

std::string Rounded(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", number);
  return text;
}

/// A pose in millimetres beside one in metres would grow a thousandfold.
void WarnOfUnits(StageContext& stage, const std::vector<PointsX3>& keys, const FacesX3& faces) {
  constexpr double kOtherUnit = 3;  // poses of one figure differ by some per cent
  const std::vector<double> sizes = RelativeSizes(keys, faces);
  const std::vector<std::filesystem::path> files = stage.Inputs("keys");
  for (std::size_t k = 1; k < keys.size(); ++k)
    if (sizes[k] > kOtherUnit || sizes[k] < 1 / kOtherUnit)
      stage.Warn("key '" + PrintableName(files[k]) + "' is " + Rounded(sizes[k]) +
                 " times as large as the first one; if it only has another unit, give "
                 "--same_size true");
}

AlignKeys AlignOf(const std::string& name) {
  if (name == "upright") return AlignKeys::kUpright;
  if (name == "rigid") return AlignKeys::kRigid;
  return name == "similarity" ? AlignKeys::kSimilarity : AlignKeys::kNone;
}

Method MethodOf(const std::string& name) {
  if (name == "volumetric") return Method::kVolumetric;
  if (name == "paper") return Method::kPaper;
  return name == "linear" ? Method::kLinear : Method::kArap;
}

/// The frames to compute, and the constraints on them.
struct Plan {
  Schedule schedule;
  Rules rules;
};

Plan MakePlan(StageContext& stage, const InterpolateOptions& options,
              const std::vector<PointsX3>& keys, const Mesh& first) {
  const int count = SizeOf(keys);
  if (!stage.Has("timeline")) {
    Plan plan{MakeSchedule(std::vector<int>(count - 1, options.steps)), {}};
    plan.rules = PlainRules(plan.schedule, options.volume);
    return plan;
  }
  const std::filesystem::path path = stage.Input("timeline");
  const std::string name = path.filename().string();
  Timeline timeline = ParseTimeline(ReadFile(path), name);
  CarryLog log;
  FollowRegions(stage.Has("regions") ? stage.Input("regions") : std::filesystem::path(), first,
                timeline, &log);
  for (const std::string& note : log.notes) stage.Note(note);
  for (const std::string& warning : log.warnings) stage.Warn(warning);
  if (timeline.has_times() && options.steps != InterpolateOptions().steps)
    stage.Warn(
        "steps " + std::to_string(options.steps) +
        " has no effect: the timeline gives the keys their times, and fps the frames between "
        "them; change those, or leave the times out");
  Plan plan{MakeSchedule(timeline, count, options.steps, name), {}};
  plan.rules = RulesFrom(timeline, plan.schedule, keys[0], first.faces, options.volume, name);
  const bool asks = !timeline.pins.empty() || !timeline.trajectories.empty() ||
                    timeline.table_height || !timeline.volume.empty();
  if (asks && options.method != "arap")
    throw UsageError(
        "interpolate: " + name +
        " asks for pins, trajectories, a table or volumes, which only --method arap keeps");
  for (const Span& span : plan.schedule.spans)
    if (!span.turns.empty() && options.method != "arap")
      throw UsageError("interpolate: " + name + " gives turns, which only --method arap keeps");
  return plan;
}

void ReportSource(StageContext& stage, const SourceReport& source, const std::string& method) {
  if (method == "arap") {
    stage.Report("degenerate_faces", source.degenerate_faces);
    stage.Report("largest_remainder_rad", source.largest_remainder);
    stage.Report("torn_edges", source.torn_edges);
    stage.Report("loops_that_do_not_close", source.loops_that_do_not_close);
    stage.Report("differential_turns", source.differential);
  }
  if (method == "volumetric") {
    stage.Report("tetrahedra", source.tetrahedra);
    stage.Report("largest_tear_rad", source.largest_tear);
  }
  if (method == "arap" || method == "volumetric")
    stage.Report("largest_turn_rad", source.largest_turn);
  for (const std::string& note : source.notes) stage.Note(note);
}

void ReportDistortion(StageContext& stage, const DistortionReport& report,
                      const std::string& method) {
  const SegmentDistortion& first = report.segments.front();
  stage.Report("area_mean", first.area.mean);
  stage.Report("area_sd", first.area.sd);
  stage.Report("volume_mean", first.volume.mean);
  stage.Report("volume_sd", first.volume.sd);
  stage.Report("linear_area_mean", first.linear_area.mean);
  stage.Report("linear_area_sd", first.linear_area.sd);
  stage.Report("linear_volume_mean", first.linear_volume.mean);
  stage.Report("linear_volume_sd", first.linear_volume.sd);
  double area = 0, volume = 0, move = 0;
  int on_table = 0;
  for (const SegmentDistortion& s : report.segments) {
    area = std::max(area, s.area.path_deviation);
    volume = std::max(volume, s.volume.path_deviation);
  }
  for (const FrameDistortion& f : report.frames) {
    move = std::max(move, f.volume_move);
    on_table = std::max(on_table, f.on_table);
  }
  stage.Report("area_path_deviation", area);
  stage.Report("volume_path_deviation", volume);
  stage.Report("volume_move_over_diag", move);
  stage.Report("vertices_on_table", on_table);
  for (const std::string& line : ToTable(report, method)) stage.Note(line);
}

void Run(StageContext& stage, const InterpolateOptions& options) {
  std::vector<Mesh> meshes = LoadKeys(stage);
  const Mesh first = meshes.front();
  std::vector<PointsX3> keys;
  for (Mesh& mesh : meshes) keys.push_back(std::move(mesh.points));
  meshes.clear();
  for (const std::string& warning : LookWarnings(stage.Input("keys"), first)) stage.Warn(warning);
  const ClosedSeams seams(keys, first.faces);
  if (options.same_size)
    keys = SameSized(keys, first.faces);
  else
    WarnOfUnits(stage, keys, first.faces);
  keys = AlignedKeys(keys, AlignOf(options.align));
  Plan plan = MakePlan(stage, options, keys, first);
  plan.rules = seams.Closed(std::move(plan.rules));
  keys = seams.Closed(std::move(keys));
  const std::unique_ptr<FrameSource> source =
      MakeFrameSource(keys, seams.faces(), plan.schedule, MethodOf(options.method), plan.rules);

  const std::filesystem::path folder = stage.Output("frames");
  PlyFrames writer(first);
  DistortionMeter meter(keys, seams.faces(), plan.schedule);
  const auto take = [&](const FrameView& frame) {
    char name[32];
    std::snprintf(name, sizeof name, "frame_%04d.ply", frame.index);
    writer.Write(folder / name, seams.Opened(frame.points));
    meter.Add(frame);
  };
  StreamFrames(keys, plan.schedule, *source, take, stage.progress());
  const DistortionReport report = meter.Finish();
  stage.Report("frames", std::ssize(report.frames));
  stage.Report("keys", std::ssize(keys));
  stage.Report("seam_vertices", seams.joined());
  ReportSource(stage, source->report(), options.method);
  ReportDistortion(stage, report, options.method);
  WriteFile(folder / "distortion.json",
            ToJson(report, plan.schedule, source->report(), options.method));
}

}  // namespace
}  // namespace keypose::interpolation

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::interpolation::InterpolateOptions>(
      argc, argv, keypose::interpolation::Spec(), keypose::interpolation::Run);
}
