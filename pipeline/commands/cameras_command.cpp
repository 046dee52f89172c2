#include "pipeline/commands/cameras_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/io/project/colmap_io.h"
#include "core/values/file_names.h"
#include "core/values/size_of.h"
#include "pipeline/commands/camera_folder.h"
#include "pipeline/run/opened_project.h"
#include "pipeline/text/text.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

/// The path with links resolved, as far as it exists.
fs::path WithoutLinks(const fs::path& path) {
  const fs::path resolved = fs::weakly_canonical(fs::absolute(path));
  return resolved.has_filename() ? resolved : resolved.parent_path();
}

std::string PoseMeant(const Graph& graph, const std::string& given) {
  if (graph.kind == ProjectKind::kPerformance)
    throw UsageError(
        "this project is a performance: its cameras are the calibration that it was given");
  if (given.empty()) return graph.template_pose;
  const std::string pose = Composed(given);
  if (std::find(graph.poses.begin(), graph.poses.end(), pose) == graph.poses.end())
    throw UsageError(
        fmt::format("the project has no pose '{}'{}", pose, Suggestion(pose, graph.poses)));
  return pose;
}

const Step* StepOfStage(const Graph& graph, const std::string& stage, const std::string& pose) {
  for (const Step& step : graph.steps)
    if (step.pose == pose && step.info->stage == stage) return &step;
  return nullptr;
}

/// The steps of a pose that made its cameras, and its photographs with the best masks.
struct Makers {
  const Step *model = nullptr, *images = nullptr;
  std::string images_port;
};

Makers MakersOf(const Graph& graph, const std::string& pose) {
  Makers makers;
  for (const char* stage : {"sfm", "fit"})
    if (!makers.model) makers.model = StepOfStage(graph, stage, pose);
  makers.images = StepOfStage(graph, "masks", pose);
  makers.images_port = makers.images ? "masked" : "images";
  if (!makers.images) makers.images = StepOfStage(graph, "capture", pose);
  if (!makers.model || !makers.images)
    throw UsageError(
        fmt::format("pose '{}' has no cameras: it is a mesh that was made elsewhere, or its steps "
                    "sfm and capture are switched off",
                    pose));
  return makers;
}

Selection Until(const Makers& makers) {
  Selection selection;
  selection.until = {makers.model->id, makers.images->id};
  return selection;
}

/// What the steps made, up to date or not.
class LastMade {
 public:
  LastMade(OpenedProject& opened, const Makers& makers)
      : opened_(opened), plan_(opened.graph(), opened.workshop(), Until(makers)) {
    opened.workshop().hasher.Save();
  }
  /// @throws InputError  nothing yet
  Artifact Of(const Step& step, const std::string& folder) {
    const auto& planned = plan_[static_cast<int>(&step - opened_.graph().steps.data())];
    if (planned.artifact) return *planned.artifact;
    if (planned.last && !planned.last->fingerprint.empty())
      if (auto artifact = opened_.store().Find(planned.last->fingerprint)) {
        older_.push_back(step.id);
        return *artifact;
      }
    const std::string in = folder.empty() ? "" : " -C " + ShellWord(folder);
    throw InputError(
        fmt::format("{} {}; {}`keypose run{} --until {}` makes it", step.id,
                    planned.last ? "has no result" : "has not run yet",
                    planned.last && planned.last->failed
                        ? fmt::format("`keypose log{} {}` says why it failed; ", in, step.id)
                        : "",
                    in, step.id));
  }
  /// The steps whose result is not what a run would make now.
  const std::vector<std::string>& older() const { return older_; }

 private:
  OpenedProject& opened_;
  Plan plan_;
  std::vector<std::string> older_;
};

/// @throws InputError  masks that were made with other cameras
void RequireTogether(const Artifact& model, const Artifact& images, const Makers& makers) {
  const Content& made = model.outputs.at("model").content;
  for (const RecipeInput& input : images.recipe.inputs)
    if (input.port == "model" && input.content.hash != made.hash)
      throw InputError(fmt::format(
          "{0} was last made with other cameras than {1} has now; `keypose run --until {0}` makes "
          "it anew",
          makers.images->id, makers.model->id));
}

/// The axes and the unit of the cameras' world, in words.
std::string WorldText(const Artifact& model, Disk& disk) {
  if (model.recipe.stage != "sfm")
    return "the world and its unit are those of the template's cameras";
  const fs::path file = model.folder / "report.json";
  std::string source;
  if (disk.Stat(file)) {
    const auto report = nlohmann::json::parse(disk.Read(file), nullptr, false);
    if (report.is_object() && report.contains("measurements"))
      source = report["measurements"].value("scale_source", "");
  }
  if (source == "poses") return "the world and its unit are those of the cameras that were given";
  if (source == "board") return "z is up, the unit is a metre, from the printed board";
  const auto level = model.recipe.options.find("level");
  if (level != model.recipe.options.end() && level->second == "false")
    return "the world is neither upright nor scaled, since `level` of sfm is false";
  return "z is up, the unit is the mean distance of the cameras";
}

/// Refuses a place where others' files would be lost.
void RequirePlace(const OpenedProject& opened, const fs::path& place, bool overwrite) {
  const auto refuse = [&](const std::string& why) {
    throw DiskError(fmt::format("the output {} {}", place.string(), why));
  };
  if (IsWithin(place, WithoutLinks(opened.state())))
    refuse("lies in the project's cache; name another folder");
  std::vector<fs::path> kept{fs::current_path(), opened.project()};
  if (const char* home = std::getenv("HOME"); home && *home) kept.emplace_back(home);
  for (const Step& step : opened.graph().steps)
    for (const PortFlows& port : step.inputs)
      for (const Flow& flow : port.flows)
        if (flow.kind == Flow::Kind::kSource) {
          kept.push_back(opened.project() / flow.path);
          if (IsWithin(place, WithoutLinks(kept.back())))
            refuse("lies in what the project is made from; name another folder");
        }
  if (!fs::exists(place)) return;
  if (!fs::is_directory(place)) refuse("is a file, but a folder goes there; name a folder");
  if (fs::is_empty(place)) return;
  if (!overwrite)
    refuse(
        "exists and is not empty; name another folder, or use --overwrite to replace it and all "
        "that is in it");
  for (const fs::path& path : kept)
    if (IsWithin(WithoutLinks(path), place))
      refuse(fmt::format("holds {}, which would be lost; name a folder of its own", path.string()));
}

/// A folder beside the place where it will be, which is gone if that does not happen.
class FolderInWork {
 public:
  FolderInWork(Disk& disk, fs::path place)
      : disk_(disk),
        place_(std::move(place)),
        work_(place_.parent_path() /
              fmt::format(".{}.{}.writing", place_.filename().string(), getpid())) {
    disk_.MakeFolder(work_);
  }
  ~FolderInWork() {
    std::error_code ignored;
    fs::remove_all(work_, ignored);
  }
  FolderInWork(const FolderInWork&) = delete;
  FolderInWork& operator=(const FolderInWork&) = delete;

  const fs::path& path() const { return work_; }
  void Place() {
    disk_.Sync(work_);
    disk_.Move(work_, place_);
  }

 private:
  Disk& disk_;
  fs::path place_, work_;
};

/// The first few of many names.
std::string SomeNames(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 12;
  if (names.size() <= kShown) return fmt::format("{}", fmt::join(names, ", "));
  return fmt::format("{} and {} more", fmt::join(names.begin(), names.begin() + kShown, ", "),
                     names.size() - kShown);
}

/// What to do with the folder.
std::string NextText(const CameraFolder& cameras, CameraFormat format, const fs::path& place) {
  const std::string folder = ShellWord(place.string());
  const auto& views = cameras.scene.views;
  switch (format) {
    case CameraFormat::kColmap:
      if (std::none_of(views.begin(), views.end(),
                       [](const View& view) { return view.camera.distorted(); }))
        return "";
      return fmt::format(
          "the lens bends the pictures; for trainers that take pinholes alone (3DGS): colmap "
          "image_undistorter --image_path {0}/images --input_path {0}/sparse/0 --output_path "
          "{0}_undistorted\n",
          folder);
    case CameraFormat::kTransforms:
      return fmt::format("next, for instance: ns-train splatfacto --data {}\n", folder);
    case CameraFormat::kMetashape:
      return "in Metashape: add the photographs of images/, then Import Cameras (cameras.xml) and "
             "Import Masks (from files, masks/{filename}.png)\n";
  }
  return "";
}

void PrintLeftOut(const CameraFolder& cameras) {
  const auto print = [](const std::vector<std::string>& names, const char* why) {
    if (!names.empty())
      fmt::print("left out, {}: {} of the photographs: {}\n", why, names.size(), SomeNames(names));
  };
  print(cameras.not_placed, "as they have no camera");
  print(cameras.not_trusted, "as they contradict the others (capture.json says why)");
}

CameraFolder CamerasOf(const Artifact& model, const Artifact& images, const Makers& makers) {
  if (!model.outputs.contains("model"))
    throw InputError(makers.model->id + " did not write its cameras (its output `model`)");
  RequireTogether(model, images, makers);
  return JoinedCameras(ReadColmapModel(model.Path("model")),
                       ReadImageSet(images.Path(makers.images_port)));
}

}  // namespace

ExitCode CamerasCommand(const CamerasOptions& options, Progress* progress) {
  OpenedProject opened(FindProject(options.folder), {});
  const std::string pose = PoseMeant(opened.graph(), options.pose);
  const fs::path place = WithoutLinks(
      options.output.empty()
          ? fs::path(fmt::format("{}_{}_{}", opened.graph().name, pose, options.format))
          : fs::path(options.output));
  RequirePlace(opened, place, options.overwrite);
  const Makers makers = MakersOf(opened.graph(), pose);
  LastMade made(opened, makers);
  const Artifact model = made.Of(*makers.model, options.folder);
  const Artifact images = made.Of(*makers.images, options.folder);
  const CameraFolder cameras = CamerasOf(model, images, makers);
  const CameraFormat format = CameraFormatOf(options.format);
  FolderInWork work(opened.disk(), place);
  WriteCameraFolder(cameras, format, pose, work.path(), opened.disk(), progress);
  work.Place();
  fmt::print("{}: {} photographs with cameras{}, {} points; {}\n", place.string(),
             cameras.scene.views.size(), cameras.HasMasks() ? " and masks" : ", without masks",
             cameras.scene.points.size(), WorldText(model, opened.disk()));
  PrintLeftOut(cameras);
  fmt::print("{}", NextText(cameras, format, place));
  std::fflush(stdout);
  if (!made.older().empty())
    fmt::print(
        stderr,
        "keypose: these cameras are not of the present project: {} would run again; `keypose "
        "run` brings them up to date\n",
        fmt::join(made.older(), ", "));
  return ExitCode::kOk;
}

}  // namespace keypose::pipeline
