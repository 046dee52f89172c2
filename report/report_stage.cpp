// keypose-report: makes an HTML page and a JSON file from the record of a run.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/pictures/reduced_image.h"
#include "core/io/project/colmap_io.h"
#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/stage/stage.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "report/evidence/contents.h"
#include "report/html/html.h"
#include "report/page/page.h"
#include "report/page/pictures.h"
#include "report/player_gathering_stage.h"
#include "report/report_options.h"
#include "report/shots_stage.h"
#include "report/verdicts/verdicts.h"

namespace keypose::report {
namespace {

namespace fs = std::filesystem;

constexpr int kTileWidth = 150;  ///< of a photograph with its mask [px]
constexpr int kPairSide = 1024;  ///< longer side of a photograph before its figure is cut out [px]

StageSpec Spec() {
  StageSpec spec;
  spec.name = "report";
  spec.version = "17";
  spec.summary =
      "Makes a self-contained HTML page and a JSON file of the results and measurements of a run.";
  spec.title = "Report";
  spec.inputs = {{"run", "folder", "folder with run.json, the record of a run", ""}};
  spec.outputs = {{"report", "folder", "index.html and report.json", "report"}};
  spec.memory_gib = 2;
  return spec;
}

/// Whether the masks step took another thing for the figure than first masks, which colours tell.
bool AreReplaced(const StepRecord& masks) {
  const auto by = masks.texts.find("figure_by");
  return by != masks.texts.end() && !by->second.starts_with("colours");
}

/// Relative to the figure's middle, with the azimuth as in the pictures from all round.
CameraPlace PlaceOf(const View& view, const Eigen::Vector3d& middle, const Eigen::Vector3d& up,
                    double outline_off) {
  const Eigen::Vector3d away = view.Center() - middle;
  const Eigen::Vector3d front(0, std::abs(up.y()) > 0.5 ? 0 : -1, std::abs(up.y()) > 0.5 ? 1 : 0),
      side = up.cross(front);
  const double degrees = 180 / M_PI, turn = std::atan2(away.dot(side), away.dot(front)) * degrees;
  const double height = std::atan2(away.dot(up), (away - away.dot(up) * up).norm()) * degrees;
  return {view.name, turn < 0 ? turn + 360 : turn, height, outline_off};
}

/// Reads the files that the record names, part by part. A failure becomes a line on the page and
/// does not end the report.
class Gatherer {
 public:
  Gatherer(const ReportOptions& options, Encoder encode, Progress* progress)
      : options_(options), encode_(std::move(encode)), progress_(progress) {
    sides_.width = options.picture_width;
    sides_.height = options.picture_width * 10 / 9;
    sides_.up = Eigen::Vector3d::Unit(options.up[0] - 'x');
  }

  Contents Gather(RunRecord run) {
    Contents contents;
    contents.run = std::move(run);
    const RunRecord& record = contents.run;
    contents.poses.resize(record.poses.size());
    std::vector<Part> parts, compared;
    for (std::size_t i = 0; i < record.poses.size(); ++i) {
      const std::string& name = record.poses[i];
      PosePart& pose = contents.poses[i];
      pose.name = name;
      if (record.performance) {
        parts.push_back({"shot " + name, [&](Troubles* t) { GatherShot(record, pose, t); }});
        continue;
      }
      parts.push_back({"pose " + name, [&](Troubles* t) { GatherPose(record, pose, t); }});
      compared.push_back(
          {"photographs of " + name, [&](Troubles* t) { ComparePose(record, pose, t); }});
    }
    if (!record.performance) {
      const std::vector<const StepRecord*> steps = record.All("register");
      contents.pairs.resize(steps.size());
      for (std::size_t i = 0; i < steps.size(); ++i)
        parts.push_back({"registration " + steps[i]->pose, [&, step = steps[i], i](Troubles* t) {
                           GatherPair(*step, contents.pairs[i], t);
                         }});
      parts.push_back({"animation", [&](Troubles* t) {
                         Try(t, "interpolate", [&] { GatherAnimation(contents); });
                       }});
    }
    GatherAll(&parts, &compared);
    for (const std::vector<Part>* done : {&parts, &compared})
      for (const Part& part : *done)
        contents.troubles.insert(contents.troubles.end(), part.troubles.begin(),
                                 part.troubles.end());
    if (record.performance) return contents;
    ReportProgress(progress_, 0.95, "player");
    Try(&contents.troubles, "player",
        [&] { contents.player = GatherPlayer(contents, encode_, sides_); });
    return contents;
  }

 private:
  using Troubles = std::vector<std::string>;

  /// What is gathered into a place of its own.
  struct Part {
    std::string what;
    std::function<void(Troubles*)> gather;
    Troubles troubles = {};
  };

  /// @param single    each is done on one core
  /// @param parallel  each has all cores
  void GatherAll(std::vector<Part>* single, std::vector<Part>* parallel) const {
    const double all = static_cast<double>(single->size() + 2 * parallel->size());
    std::atomic<int> done = 0;
    const auto gather = [&](Part& part, int share) {
      ReportProgress(progress_, 0.95 * done / all, part.what);
      part.gather(&part.troubles);
      done += share;
    };
    ParallelFor(std::ssize(*single),
                [&](std::int64_t i) { gather((*single)[static_cast<std::size_t>(i)], 1); });
    for (Part& part : *parallel) gather(part, 2);
  }

  template <class Function>
  static void Try(Troubles* troubles, const std::string& what, const Function& function) {
    try {
      function();
    } catch (const Cancelled&) {
      throw;
    } catch (const Error& error) {
      troubles->push_back(what + ": not shown: " + error.what());
    }
  }

  void GatherPose(const RunRecord& run, PosePart& pose, Troubles* troubles) const {
    const std::string& name = pose.name;
    const StepRecord *capture = run.Find("capture", name), *dense = run.Find("dense", name),
                     *cleanup = run.Find("cleanup", name), *bake = run.Find("bake", name),
                     *sfm = run.Find("sfm", name), *masks = run.Find("masks", name),
                     *fit = run.Find("fit", name);
    if (fit && !fit->Output("fitted").empty())
      Try(troubles, fit->id, [&] { ShowShape(fit->Output("fitted"), pose); });
    if (cleanup && !cleanup->Output("clean").empty())
      Try(troubles, cleanup->id, [&] { ShowShape(cleanup->Output("clean"), pose); });
    if (bake && !bake->Output("texture").empty())
      Try(troubles, bake->id, [&] { ShowTextured(*bake, run.TextureOf(name), pose); });
    if (dense && !dense->Output("cloud").empty())
      Try(troubles, dense->id,
          [&] { pose.cloud = CloudPicture(ReadPointCloud(dense->Output("cloud")), sides_); });
    if (masks && !masks->Output("masked").empty())
      Try(troubles, masks->id,
          [&] { pose.masks = MaskSheet(ReadImageSet(masks->Output("masked"))); });
    else if (capture && !capture->Output("images").empty())
      Try(troubles, capture->id,
          [&] { pose.masks = MaskSheet(ReadImageSet(capture->Output("images"))); });
    if (fit && !fit->Output("picture").empty())
      Try(troubles, fit->id, [&] {
        pose.cameras =
            Picture{"The bent template over its photographs", ReadImage(fit->Output("picture"), 3)};
      });
    if (sfm && !sfm->Output("picture").empty())
      Try(troubles, sfm->id, [&] {
        pose.cameras = Picture{
            "Cameras from above and from the side: by ring (upper row), by reprojection error from "
            "blue to yellow at 1 px (lower row)",
            ReadImage(sfm->Output("picture"), 3)};
      });
  }

  void ComparePose(const RunRecord& run, PosePart& pose, Troubles* troubles) const {
    const StepRecord *capture = run.Find("capture", pose.name), *bake = run.Find("bake", pose.name),
                     *masks = run.Find("masks", pose.name);
    if (bake && capture && !bake->Output("texture").empty())
      Try(troubles, bake->id, [&] { Compare(*bake, *capture, masks, pose); });
  }

  void GatherShot(const RunRecord& run, PosePart& shot, Troubles* troubles) const {
    const std::string& name = shot.name;
    const StepRecord *track = run.Find("track", name), *transfer = run.Find("transfer", name),
                     *follow = run.Find("follow", name);
    for (const auto& [step, port] :
         {std::pair{follow, "followed"}, {transfer, "frames"}, {track, "frames"}})
      if (step && !step->Output(port).empty() && shot.sides.empty())
        Try(troubles, step->id, [&, at = step->Output(port)] { ShowFrames(at, shot); });
    if (track && !track->Output("picture").empty())
      Try(troubles, track->id, [&] {
        shot.cameras =
            Picture{"The tracked body over the films", ReadImage(track->Output("picture"), 3)};
      });
    const StepRecord* video3d = run.Find("video3d", name);
    if (video3d && !video3d->Output("picture").empty())
      Try(troubles, video3d->id, [&] {
        shot.painted = Picture{"Films, and beside them what moves, painted from all of them",
                               ReadImage(video3d->Output("picture"), 3)};
      });
  }

  /// Some frames, evenly picked.
  void ShowFrames(const fs::path& folder, PosePart& shot) const {
    const auto frame = [&](int i) { return ReadMesh(folder / fmt::format("frame_{:04}.ply", i)); };
    int count = 0;
    while (fs::exists(folder / fmt::format("frame_{:04}.ply", count))) ++count;
    const Mesh mesh = frame(0);
    RequireUsable(mesh, "frame_0000.ply");
    shot.faces = mesh.face_count();
    shot.vertices = mesh.vertex_count();
    std::vector<PointsX3> shown;
    std::vector<std::string> captions;
    const int strip = std::min(count, options_.film_frames);
    for (int i = 0; i < strip; ++i) {
      const int index = strip == 1 ? 0 : i * (count - 1) / (strip - 1);
      shown.push_back(frame(index).points);
      captions.push_back("frame " + std::to_string(index));
    }
    shot.sides = Film(mesh, shown, captions, nullptr, sides_);
  }

  void ShowShape(const fs::path& path, PosePart& pose) const {
    const Mesh mesh = ReadMesh(path);
    RequireUsable(mesh, path.string());
    pose.faces = mesh.face_count();
    pose.vertices = mesh.vertex_count();
    SidesOptions sides = sides_;
    sides.azimuths_deg = {20, 200};
    pose.shape = ShapeSides(mesh, sides);
    for (Picture& picture : pose.shape)
      picture.caption = "Closed mesh, " + Pretty(pose.faces) + " faces, " + picture.caption;
    if (pose.sides.empty() && mesh.colors.rows() > 0)
      pose.sides = TexturedSides(mesh, nullptr, sides_);
  }

  void ShowTextured(const StepRecord& bake, const fs::path& path, PosePart& pose) const {
    const Mesh mesh = ReadMesh(bake.Input("mesh"));
    RequireUsable(mesh, bake.Input("mesh").string());
    const Image8 texture = ReadImage(path, 3);
    pose.sides = TexturedSides(mesh, &texture, sides_);
    const int side = options_.picture_width;
    pose.texture = Picture{fmt::format("Texture, {} x {}", texture.width, texture.height),
                           Resized(texture, side, side)};
  }

  /// Compares the textured mesh with each photograph and its first mask; in a room, where first
  /// masks hold more than the figure, with the mask that replaced it.
  /// @param masks  may be null
  void Compare(const StepRecord& bake, const StepRecord& capture, const StepRecord* masks,
               PosePart& pose) const {
    const Mesh mesh = ReadMesh(bake.Input("mesh"));
    RequireUsable(mesh, bake.Input("mesh").string());
    const Image8 texture = ReadImage(bake.Output("texture"), 3);
    const RayScene scene(mesh.points, mesh.faces);
    const Scene cameras = ReadColmapModel(bake.Input("model"));
    pose.masks_replaced = masks && !masks->Output("masked").empty() && AreReplaced(*masks);
    const ImageSet set =
        ReadImageSet(pose.masks_replaced ? masks->Output("masked") : capture.Output("images"));
    std::vector<std::pair<const View*, int>> placed;
    for (const View& view : cameras.views)
      if (const int i = set.Find(view.name); i >= 0 && !set.images[i].mask.empty())
        placed.emplace_back(&view, i);
    const auto shot = [&](std::size_t k, int longer_side) {
      const auto& [view, i] = placed[k];
      return Cropped(ReadShot(*view, set.ImagePath(i), set.MaskPath(i), longer_side), mesh.points);
    };
    std::vector<ViewEvidence> views(placed.size());
    ParallelFor(std::ssize(placed), [&](std::int64_t i) {
      const auto k = static_cast<std::size_t>(i);
      views[k] = CompareView(mesh, scene, &texture, shot(k, options_.compared_px));
    });
    for (std::size_t k = 0; k < placed.size(); ++k)
      pose.places.push_back(PlaceOf(*placed[k].first, mesh.points.colwise().mean().transpose(),
                                    sides_.up, views[k].outline_off));
    pose.evidence = Summarize(std::move(views));
    if (masks && !masks->Output("masked").empty())
      pose.evidence.missing = FindMissingPart(
          CoveredMasks(mesh, scene, cameras, set, ReadImageSet(masks->Output("masked"))),
          mesh.points);
    for (const int k : pose.evidence.worst) {
      const ViewEvidence& view = pose.evidence.views[k];
      pose.worst.push_back(
          {fmt::format("{}: outlines {:.2f} % of the figure\u2019s size apart, correlation of "
                       "details {:.2f}",
                       view.name, 100 * view.outline_off, view.structure),
           SideBySide(mesh, scene, &texture, shot(static_cast<std::size_t>(k), kPairSide))});
    }
  }

  /// Marks where one more landmark would help: on the template, and at its present place in the
  /// pose.
  std::vector<Picture> MarkAdvice(const StepRecord& step, const Mesh& registered) const {
    const auto list = step.lists.find("landmark_advice");
    if (list == step.lists.end() || step.Input("source").empty()) return {};
    const Mesh source = ReadMesh(step.Input("source"));
    std::vector<Picture> pictures;
    for (const nlohmann::json& place : nlohmann::json::parse(list->second)) {
      const int vertex = place.value("vertex", -1);
      if (vertex < 0 || vertex >= source.vertex_count() ||
          registered.vertex_count() != source.vertex_count())
        continue;
      const Image8 both[2] = {MarkedVertex(source, vertex, sides_),
                              MarkedVertex(registered, vertex, sides_)};
      pictures.push_back(
          {fmt::format(
               "{}. On the template (left), and at its present place in the pose (right): {}",
               pictures.size() + 1, place.value("reason", "")),
           TileImages({both[0], both[1]}, 2, 6)});
    }
    return pictures;
  }

  Picture MaskSheet(const ImageSet& set) const {
    const int total = SizeOf(set.images), shown = std::min(total, options_.mask_tiles);
    if (total == 0) throw InputError("the image set is empty");
    std::vector<Image8> tiles(shown);
    ParallelFor(shown, [&](std::int64_t i) {
      const int index = static_cast<int>(i * total / shown);
      const Image8 photograph = ReadReducedTo(set.ImagePath(index), 3, 2 * kTileWidth);
      const int width = kTileWidth,
                height = std::max(1, width * photograph.height / photograph.width);
      const Image8 small = Resized(photograph, width, height);
      if (set.images[index].mask.empty()) {
        tiles[i] = small;
        return;
      }
      const Image8 mask = ReadReducedTo(set.MaskPath(index), 1, 2 * kTileWidth);
      tiles[i] = MaskTile(small, Resized(mask, width, height));
    });
    const std::string some = shown < total
                                 ? fmt::format("{} of {} photographs, evenly picked", shown, total)
                                 : fmt::format("All {} photographs", total);
    return {some + "; everything outside the mask is dark, the mask\u2019s edge is orange.",
            TileImages(tiles, 7, 4)};
  }

  void GatherPair(const StepRecord& step, PairPart& pair, Troubles* troubles) const {
    pair.step = &step;
    Try(troubles, step.id, [&] {
      if (step.Output("registered").empty() || step.Input("target").empty())
        throw InputError("the registered mesh or its target is not there");
      const Mesh registered = ReadMesh(step.Output("registered")),
                 target = ReadMesh(step.Input("target"));
      RequireUsable(registered, "registered");
      RequireUsable(target, "target");
      pair.to_target = DistanceTo(registered, target);
      pair.from_target = DistanceTo(target, registered);
      pair.diagonal = BoundingDiagonal(target.points);
      const double wanted = std::max(pair.to_target.p99, pair.from_target.p99) / pair.diagonal;
      pair.scale_top =
          options_.color_scale_top > 0 ? options_.color_scale_top : std::max(wanted, 1e-4);
      SidesOptions sides = sides_;
      sides.azimuths_deg = {20, 200};
      pair.registered =
          HeatSides(registered, pair.to_target.at_vertex, pair.scale_top * pair.diagonal, sides);
      pair.target =
          HeatSides(target, pair.from_target.at_vertex, pair.scale_top * pair.diagonal, sides);
      pair.advice = MarkAdvice(step, registered);
      if (!step.Output("picture").empty())
        pair.carried.push_back({"", ReadImage(step.Output("picture"), 3)});
    });
  }

  void GatherAnimation(Contents& contents) const {
    const StepRecord* step = contents.run.Find("interpolate");
    if (!step || step->Output("frames").empty()) return;
    const fs::path folder = step->Output("frames");
    AnimationPart part;
    part.frames = ParseDistortion(ReadFile(folder / "distortion.json"));
    if (const double fps = contents.run.ExportedRate(folder); fps > 0) PlayAt(fps, &part.frames);
    part.keys = static_cast<int>(std::count_if(part.frames.begin(), part.frames.end(),
                                               [](const FrameDistortion& f) { return f.key; }));
    const int count = SizeOf(part.frames);
    const auto frame = [&](int i) { return ReadMesh(folder / fmt::format("frame_{:04}.ply", i)); };
    Mesh mesh = frame(0);
    RequireUsable(mesh, "frame_0000.ply");
    part.face_count = mesh.face_count();
    DescribeFaces(part, mesh, frame);
    const Image8 texture = TakeTexture(contents.run, mesh);
    std::vector<PointsX3> shown;
    std::vector<std::string> captions;
    const int strip = std::min(count, options_.film_frames);
    for (int i = 0; i < strip; ++i) {
      const int index =
          strip == 1
              ? 0
              : static_cast<int>(std::lround(static_cast<double>(i) * (count - 1) / (strip - 1)));
      shown.push_back(frame(index).points);
      if (shown.back().rows() != mesh.points.rows())
        throw InputError("frames have different vertex counts");
      captions.push_back(fmt::format("at {:.2f} s{}", part.frames[index].time_s,
                                     part.frames[index].key ? ", key" : ""));
    }
    SidesOptions sides = sides_;
    sides.width = sides_.width * 2 / 3;
    sides.height = sides_.height * 2 / 3;
    part.film = Film(mesh, shown, captions, texture.empty() ? nullptr : &texture, sides);
    contents.animation = std::move(part);
  }

  /// Per-face distortion halfway between the first two keys.
  template <class FrameReader>
  static void DescribeFaces(AnimationPart& part, const Mesh& first, const FrameReader& frame) {
    int next = 1;
    while (next < std::ssize(part.frames) && !part.frames[next].key) ++next;
    if (next < 2 || next >= std::ssize(part.frames)) return;
    const double t0 = part.frames[0].t, t1 = part.frames[next].t;
    int middle = 1;  // by the share of the way, not by time: a key may be held or eased out of
    while (middle < next - 1 && part.frames[middle].t < t0 + 0.5 * (t1 - t0)) ++middle;
    part.faces_t = part.frames[middle].t;
    const double share =
        t1 > t0 ? (part.faces_t - t0) / (t1 - t0) : static_cast<double>(middle) / next;
    part.faces =
        PerFace(first.points, frame(middle).points, frame(next).points, first.faces, share);
  }

  static Image8 TakeTexture(const RunRecord& run, Mesh& mesh) {
    const std::vector<Image8> textures = TexturesOf(run, {run.template_pose}, mesh);
    return textures.empty() ? Image8{} : textures[0];
  }

  const ReportOptions& options_;
  Encoder encode_;
  Progress* progress_;
  SidesOptions sides_;
};

/// JPEG for photographs and renderings keeps the page at a few megabytes.
std::string EncodeJpeg(const fs::path& scratch, const Image8& image) {
  const fs::path file = scratch / "picture.jpg";
  WriteImage(file, image, 86);
  return "data:image/jpeg;base64," + Base64(ReadFile(file));
}

/// Outputs that no longer exist are treated as never made.
void ForgetMissing(RunRecord& run) {
  for (StepRecord& step : run.steps)
    for (auto it = step.outputs.begin(); it != step.outputs.end();) {
      if (fs::exists(it->second)) {
        ++it;
        continue;
      }
      step.trouble += (step.trouble.empty() ? "" : "; ") + std::string("its output ") +
                      it->second.string() + " is no longer there";
      it = step.outputs.erase(it);
    }
}

/// The deciding findings and what to do, for the console.
std::string Sentence(const Verdict& verdict) {
  return Plain(verdict.why) +
         (verdict.cure.empty() ? "" : " What to do: " + Plain(verdict.cure) + ".");
}

void Run(StageContext& stage, const ReportOptions& options) {
  const fs::path input = stage.Input("run"),
                 file = fs::is_directory(input) ? input / "run.json" : input;
  RunRecord run = ParseRun(ReadFile(file), file.parent_path(),
                           [](const fs::path& path) { return ReadFile(path); });
  ForgetMissing(run);
  SubProgress gathering(stage.progress(), 0, 0.9);
  const fs::path scratch = stage.Scratch(), output = stage.Output("report");
  const Encoder encode = [&](const Image8& image) { return EncodeJpeg(scratch, image); };
  const Contents contents = Gatherer(options, encode, &gathering).Gather(std::move(run));
  const std::string page = BuildPage(contents, encode);
  WriteFile(output / "index.html", page);
  WriteFile(output / "report.json", BuildJson(contents));
  const std::vector<Finding> findings = FindAll(contents);
  const auto count = [&](Grade grade) {
    return static_cast<int>(std::count_if(findings.begin(), findings.end(),
                                          [&](const Finding& f) { return f.grade == grade; }));
  };
  stage.Report("poses", SizeOf(contents.poses));
  stage.Report("steps", SizeOf(contents.run.steps));
  stage.Report("findings_good", count(Grade::kGood));
  stage.Report("findings_look", count(Grade::kLook));
  stage.Report("findings_wrong", count(Grade::kWrong));
  for (const Verdict& verdict : Judge(contents, findings))
    stage.Verdict(verdict.about, WordOf(verdict.grade), Sentence(verdict));
  stage.Report("page_bytes", std::ssize(page));
}

}  // namespace
}  // namespace keypose::report

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::report::ReportOptions>(argc, argv, keypose::report::Spec(),
                                                           keypose::report::Run);
}
