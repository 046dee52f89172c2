#include "synth/commands/photos_command.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <memory>
#include <numeric>
#include <utility>

#include "core/io/pictures/image_io.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/exif_focal.h"
#include "core/values/size_of.h"
#include "synth/photographs/fresh_folder.h"
#include "synth/photographs/truth_files.h"
#include "synth/worlds/lying.h"

namespace keypose::synth {
namespace {

void MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw DiskError("synth: cannot create the folder " + folder.string() + ": " + error.message());
}

ExifToWrite ExifOf(const PhotographerOptions& options) {
  ExifToWrite exif;
  // the option is by the longer side, EXIF's by the diagonal
  const double focal_px = options.focal_35mm / 36 * std::max(options.width, options.height);
  exif.focal_35mm = Equivalent35mm(focal_px, options.width, options.height);
  exif.focal_mm = options.focal_35mm / 1.5;  // an APS-C camera
  exif.make = "Keypose";
  exif.model = "Synthetic APS-C";
  return exif;
}

struct PoseFolders {
  std::filesystem::path photos, truth;
};

/// The figure on the table for each photograph: the character, or another figure after a mishap.
struct Cast {
  /// another character; the character in another pose; null without that mishap
  std::unique_ptr<Photographer> other, bumped;
  std::vector<const Photographer*> of_view;
};

Cast CastOf(const Photographer& photographer, const World& world, const PhotosCommand& command,
            const std::string& pose) {
  const Mishaps& mishaps = command.photographer.mishaps;
  const int views = photographer.view_count();
  Cast cast{nullptr, nullptr,
            std::vector<const Photographer*>(static_cast<std::size_t>(views), &photographer)};
  if (!mishaps.moved_pose.empty()) {
    cast.bumped = std::make_unique<Photographer>(world, world.PoseNamed(mishaps.moved_pose),
                                                 command.photographer, &photographer);
    for (int i = FirstAfter(mishaps.moved_from, views); i < views; ++i)
      cast.of_view[i] = cast.bumped.get();
  }
  if (mishaps.strays > 0) {
    WorldOptions options = command.world;
    options.seed = StraySeed(mishaps, options.seed);
    const World stranger = MakeWorld(options);
    cast.other = std::make_unique<Photographer>(stranger, stranger.PoseNamed(pose),
                                                command.photographer, &photographer);
    for (const int i : StrayViews(mishaps, views)) cast.of_view[i] = cast.other.get();
  }
  return cast;
}

std::string NumberedName(const std::string& prefix, std::int64_t i) {
  char number[32];
  std::snprintf(number, sizeof number, "_%04d.jpg", static_cast<int>(i) + 1);
  return prefix + number;
}

std::vector<int> AllViews(const Photographer& photographer) {
  std::vector<int> all(static_cast<std::size_t>(photographer.view_count()));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

/// Renders and writes one set of photographs: those `chosen` of the photographer's views.
/// @return the views that show the character, without images
std::vector<SyntheticView> TakeAll(const Cast& cast, const std::vector<int>& chosen,
                                   const PhotosCommand& command, const std::string& prefix,
                                   const PoseFolders& folders, Progress* progress) {
  const ExifToWrite exif = ExifOf(command.photographer);
  std::vector<SyntheticView> views(chosen.size());
  // One photograph per thread, since JPEG encoding uses only one core.
  const auto take = [&](std::int64_t i) {
    if (progress && progress->cancelled()) throw Cancelled();
    const Photographer& taker = *cast.of_view[chosen[i]];
    SyntheticView view = taker.Take(chosen[i]);
    if (&taker == cast.other.get()) view.mask = Image8(view.mask.width, view.mask.height, 1, 0);
    view.view.name = NumberedName(prefix, i);
    WriteImage(folders.photos / view.view.name, view.image, command.jpeg_quality, &exif);
    WriteImage(folders.truth / "masks" / (view.view.name + ".png"), view.mask);
    views[i].view = std::move(view.view);
  };
  ParallelFor(std::ssize(chosen), take);
  std::vector<SyntheticView> of_character;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (cast.of_view[chosen[i]] != cast.other.get() || !cast.other)
      of_character.push_back(std::move(views[i]));
  return of_character;
}

/// Without mishaps: every photograph shows the character.
Cast Alone(const Photographer& photographer) {
  return {nullptr, nullptr,
          std::vector<const Photographer*>(static_cast<std::size_t>(photographer.view_count()),
                                           &photographer)};
}

std::vector<SyntheticView> TakeLying(const World& world, const Pose& pose, const PointsX3& standing,
                                     const PhotosCommand& command, const PoseFolders& folders,
                                     Progress* progress) {
  const Lying lying = LayDown(pose, standing);
  PhotographerOptions options = command.photographer;
  options.seed += 1;
  options.mishaps = {};  // mishaps only affect the standing figure
  const Photographer photographer(world, lying.pose, options);
  std::vector<SyntheticView> views =
      TakeAll(Alone(photographer), AllViews(photographer), command, "LYING", folders, progress);
  for (SyntheticView& view : views)
    view.view.camera_from_world = Compose(view.view.camera_from_world, lying.table_from_character);
  return views;
}

PoseFolders MakeFolders(const PhotosCommand& command, const std::string& pose) {
  const PoseFolders folders{command.output / "photos" / pose, command.output / "truth" / pose};
  MakeFreshFolder(folders.photos, folders.truth / "masks");
  MakeFreshFolder(folders.truth / "masks", folders.truth / "masks");
  // Only some worlds have these.
  for (const char* file : {"smooth.ply", "outer.ply"})
    std::filesystem::remove(folders.truth / file);
  return folders;
}

void WritePlate(const PhotosCommand& command, const Photographer& photographer,
                const std::string& pose) {
  if (!command.clean_plate) return;
  const ExifToWrite exif = ExifOf(command.photographer);
  MakeFolder(command.output / "background");
  WriteImage(command.output / "background" / (pose + ".jpg"), photographer.CleanPlate(),
             command.jpeg_quality, &exif);
}

int PhotographPose(const PhotosCommand& command, const World& world, const Pose& pose,
                   Progress* progress) {
  const PoseFolders folders = MakeFolders(command, pose.name);
  const Photographer photographer(world, pose, command.photographer);
  const Cast cast = CastOf(photographer, world, command, pose.name);
  std::vector<SyntheticView> views =
      TakeAll(cast, AllViews(photographer), command, "IMG", folders, progress);
  const int strays = photographer.view_count() - SizeOf(views);
  if (command.flip)
    for (SyntheticView& view :
         TakeLying(world, pose, photographer.surface().points, command, folders, progress))
      views.push_back(std::move(view));
  const Truth truth{TruthScene(world, pose, views),
                    photographer.surface(),
                    SeenSurface(world, pose),
                    pose(world.smooth),
                    world.landmarks,
                    {}};
  WriteTruth(folders.truth, truth, world, pose, command.world, command.photographer);
  WritePlate(command, photographer, pose.name);
  return SizeOf(views) + strays;
}

/// The pose whose rig the others share.
const Pose& PoseOfRig(const PhotosCommand& command, const World& world) {
  for (const std::string& name : command.poses)
    if (!command.few.count(name)) return world.PoseNamed(name);
  return world.PoseNamed("rest");
}

/// Photographs of a pose from some of the cameras of another one, each at the same place as there.
int PhotographFew(const PhotosCommand& command, const World& world, const Pose& pose, int count,
                  Progress* progress) {
  PhotosCommand few = command;
  few.photographer.mishaps = {};  // those are told by the photographs of a whole rig
  const Photographer rig(world, PoseOfRig(command, world), few.photographer);
  few.photographer.seed += 2;  // other sensor noise than in the rig's photographs
  const Photographer photographer(world, pose, few.photographer, &rig);
  const std::vector<int> chosen = SpreadOverRings(command.photographer, count);
  const PoseFolders folders = MakeFolders(command, pose.name);
  const std::vector<SyntheticView> views =
      TakeAll(Alone(photographer), chosen, few, "IMG", folders, progress);
  Truth truth{TruthScene(world, pose, views),
              photographer.surface(),
              SeenSurface(world, pose),
              pose(world.smooth),
              world.landmarks,
              {}};
  for (const int i : chosen) truth.rig_photographs.push_back(rig.ViewAt(i).name);
  few.photographer.views = count;
  WriteTruth(folders.truth, truth, world, pose, few.world, few.photographer);
  WritePlate(few, photographer, pose.name);
  return count;
}

}  // namespace

std::vector<std::string> PhotosCommand::Problems() const {
  std::vector<std::string> problems = photographer.Problems();
  for (const auto& [pose, count] : few) {
    if (std::find(poses.begin(), poses.end(), pose) == poses.end())
      problems.push_back("few photographs are asked of '" + pose +
                         "', which is not among the poses");
    if (count < 1 || count > photographer.views)
      problems.push_back("few photographs are 1 to " + std::to_string(photographer.views) +
                         ", the number of views; of '" + pose + "' there are " +
                         std::to_string(count));
  }
  return problems;
}

std::map<std::string, int> ReadFew(const std::vector<std::string>& texts) {
  std::map<std::string, int> few;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    int count = 0;
    const char* end = text.data() + text.size();
    const bool good = equals != std::string::npos && equals > 0 &&
                      std::from_chars(text.data() + equals + 1, end, count).ptr == end &&
                      equals + 1 < text.size();
    if (!good) throw UsageError("synth: --few is '" + text + "'; it needs POSE=N, such as wave=6");
    few[text.substr(0, equals)] = count;
  }
  return few;
}

std::vector<int> SpreadOverRings(const PhotographerOptions& rig, int count) {
  const int rings = SizeOf(rig.elevations_deg);
  std::vector<int> chosen;
  int first = 0;
  for (int ring = 0; ring < rings; ++ring) {
    const auto of_ring = [&](int all) { return all / rings + (ring < all % rings ? 1 : 0); };
    const int views = of_ring(rig.views), wanted = of_ring(count);
    // Ring r starts r / rings of a step later.
    for (int k = 0; k < wanted; ++k)
      chosen.push_back(first + (k * rings + ring) * views / (wanted * rings));
    first += views;
  }
  return chosen;
}

int RunPhotos(const PhotosCommand& asked, Progress* progress) {
  const std::vector<std::string> problems = asked.Problems();
  if (!problems.empty()) throw UsageError("synth: " + problems.front());
  ReportProgress(progress, 0, "sculpting");
  PhotosCommand command = asked;
  const bool limbs =
      std::find(command.poses.begin(), command.poses.end(), "limbs") != command.poses.end();
  if (limbs && command.world.pose_seed == 0) command.world.pose_seed = 1;
  const World world = MakeWorld(command.world);
  int written = 0;
  for (std::size_t i = 0; i < command.poses.size(); ++i) {
    const Pose& pose = world.PoseNamed(command.poses[i]);
    ReportProgress(progress,
                   0.05 + 0.95 * static_cast<double>(i) / static_cast<double>(command.poses.size()),
                   "photographs of " + pose.name);
    const auto few = command.few.find(pose.name);
    written += few == command.few.end()
                   ? PhotographPose(command, world, pose, progress)
                   : PhotographFew(command, world, pose, few->second, progress);
  }
  ReportProgress(progress, 1, "done");
  return written;
}

}  // namespace keypose::synth
