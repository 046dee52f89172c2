#include "synth/photos_command.h"

#include <memory>
#include <utility>

#include "core/errors.h"
#include "core/io/image_io.h"
#include "core/parallel.h"
#include "core/size_of.h"
#include "synth/lying.h"
#include "synth/truth_files.h"

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
  exif.focal_35mm = options.focal_35mm;
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

/// Renders and writes one set of photographs.
/// @return the views that show the character, without images
std::vector<SyntheticView> TakeAll(const Photographer& photographer, const Cast& cast,
                                   const PhotosCommand& command, const std::string& prefix,
                                   const PoseFolders& folders, Progress* progress) {
  const ExifToWrite exif = ExifOf(command.photographer);
  std::vector<SyntheticView> views(photographer.view_count());
  // One photograph per thread, since JPEG encoding uses only one core.
  const auto take = [&](std::int64_t i) {
    if (progress && progress->cancelled()) throw Cancelled();
    const Photographer& taker = *cast.of_view[i];
    SyntheticView view = taker.Take(static_cast<int>(i));
    if (&taker == cast.other.get()) view.mask = Image8(view.mask.width, view.mask.height, 1, 0);
    view.view.name = prefix + view.view.name.substr(view.view.name.find('_'));
    WriteImage(folders.photos / view.view.name, view.image, command.jpeg_quality, &exif);
    WriteImage(folders.truth / "masks" / (view.view.name + ".png"), view.mask);
    views[i].view = std::move(view.view);
  };
  ParallelFor(photographer.view_count(), take);
  std::vector<SyntheticView> of_character;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (cast.of_view[i] != cast.other.get() || !cast.other)
      of_character.push_back(std::move(views[i]));
  return of_character;
}

std::vector<SyntheticView> TakeLying(const World& world, const Pose& pose, const PointsX3& standing,
                                     const PhotosCommand& command, const PoseFolders& folders,
                                     Progress* progress) {
  const Lying lying = LayDown(pose, standing);
  PhotographerOptions options = command.photographer;
  options.seed += 1;
  options.mishaps = {};  // mishaps only affect the standing figure
  const Photographer photographer(world, lying.pose, options);
  const Cast alone{nullptr, nullptr,
                   std::vector<const Photographer*>(
                       static_cast<std::size_t>(photographer.view_count()), &photographer)};
  std::vector<SyntheticView> views =
      TakeAll(photographer, alone, command, "LYING", folders, progress);
  for (SyntheticView& view : views)
    view.view.camera_from_world = Compose(view.view.camera_from_world, lying.table_from_character);
  return views;
}

int PhotographPose(const PhotosCommand& command, const World& world, const Pose& pose,
                   Progress* progress) {
  const PoseFolders folders{command.output / "photos" / pose.name,
                            command.output / "truth" / pose.name};
  MakeFolder(folders.photos);
  MakeFolder(folders.truth / "masks");
  const Photographer photographer(world, pose, command.photographer);
  const ExifToWrite exif = ExifOf(command.photographer);
  const Cast cast = CastOf(photographer, world, command, pose.name);
  std::vector<SyntheticView> views = TakeAll(photographer, cast, command, "IMG", folders, progress);
  const int strays = photographer.view_count() - SizeOf(views);
  if (command.flip)
    for (SyntheticView& view :
         TakeLying(world, pose, photographer.surface().points, command, folders, progress))
      views.push_back(std::move(view));
  const Truth truth{TruthScene(world, pose, views), photographer.surface(),
                    SeenSurface(world, pose), pose(world.smooth), world.landmarks};
  WriteTruth(folders.truth, truth, world, pose, command.world, command.photographer);
  if (command.clean_plate) {
    MakeFolder(command.output / "background");
    WriteImage(command.output / "background" / (pose.name + ".jpg"), photographer.CleanPlate(),
               command.jpeg_quality, &exif);
  }
  return SizeOf(views) + strays;
}

}  // namespace

int RunPhotos(const PhotosCommand& command, Progress* progress) {
  const std::vector<std::string> problems = command.photographer.Problems();
  if (!problems.empty()) throw UsageError("synth: " + problems.front());
  ReportProgress(progress, 0, "sculpting");
  const World world = MakeWorld(command.world);
  int written = 0;
  for (std::size_t i = 0; i < command.poses.size(); ++i) {
    const Pose& pose = world.PoseNamed(command.poses[i]);
    ReportProgress(progress,
                   0.05 + 0.95 * static_cast<double>(i) / static_cast<double>(command.poses.size()),
                   "photographs of " + pose.name);
    written += PhotographPose(command, world, pose, progress);
  }
  ReportProgress(progress, 1, "done");
  return written;
}

}  // namespace keypose::synth
