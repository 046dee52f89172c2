#include "synth/photos_command.h"

#include <utility>

#include "core/errors.h"
#include "core/io/image_io.h"
#include "core/parallel.h"
#include "synth/lying.h"
#include "synth/truth_files.h"

namespace keypose::synth {
namespace {

void MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw DiskError("synth: cannot create the folder " + folder.string() + ": " + error.message());
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

/// Takes and writes one set of photographs. @return their views, without pixels
std::vector<SyntheticView> TakeAll(const Photographer& photographer, const PhotosCommand& command, const std::string& prefix,
                                   const PoseFolders& folders, Progress* progress) {
  const ExifToWrite exif = ExifOf(command.photographer);
  std::vector<SyntheticView> views(photographer.view_count());
  // One photograph a thread: encoding JPEG uses one core only.
  const auto take = [&](std::int64_t i) {
    if (progress && progress->cancelled()) throw Cancelled();
    SyntheticView view = photographer.Take(static_cast<int>(i));
    view.view.name = prefix + view.view.name.substr(view.view.name.find('_'));
    WriteImage(folders.photos / view.view.name, view.image, command.jpeg_quality, &exif);
    WriteImage(folders.truth / "masks" / (view.view.name + ".png"), view.mask);
    views[i].view = std::move(view.view);
  };
  ParallelFor(photographer.view_count(), take);
  return views;
}

std::vector<SyntheticView> TakeLying(const World& world, const Pose& pose, const PointsX3& standing, const PhotosCommand& command,
                                     const PoseFolders& folders, Progress* progress) {
  const Lying lying = LayDown(pose, standing);
  PhotographerOptions options = command.photographer;
  options.seed += 1;
  std::vector<SyntheticView> views = TakeAll(Photographer(world, lying.pose, options), command, "LYING", folders, progress);
  for (SyntheticView& view : views) view.view.camera_from_world = Compose(view.view.camera_from_world, lying.table_from_character);
  return views;
}

int PhotographPose(const PhotosCommand& command, const World& world, const Pose& pose, Progress* progress) {
  const PoseFolders folders{command.output / "photos" / pose.name, command.output / "truth" / pose.name};
  MakeFolder(folders.photos);
  MakeFolder(folders.truth / "masks");
  const Photographer photographer(world, pose, command.photographer);
  const ExifToWrite exif = ExifOf(command.photographer);
  std::vector<SyntheticView> views = TakeAll(photographer, command, "IMG", folders, progress);
  if (command.flip)
    for (SyntheticView& view : TakeLying(world, pose, photographer.surface().points, command, folders, progress))
      views.push_back(std::move(view));
  const Truth truth{TruthScene(world, pose, views), photographer.surface(), pose(world.smooth), world.landmarks};
  WriteTruth(folders.truth, truth, world, pose, command.world, command.photographer);
  if (command.background_plate) {
    MakeFolder(command.output / "background");
    WriteImage(command.output / "background" / (pose.name + ".jpg"), photographer.BackgroundPlate(), command.jpeg_quality, &exif);
  }
  return static_cast<int>(views.size());
}

}  // namespace

int RunPhotos(const PhotosCommand& command, Progress* progress) {
  Step(progress, 0, "sculpting");
  const World world = MakeWorld(command.world);
  int written = 0;
  for (std::size_t i = 0; i < command.poses.size(); ++i) {
    const Pose& pose = world.PoseNamed(command.poses[i]);
    Step(progress, 0.05 + 0.95 * static_cast<double>(i) / static_cast<double>(command.poses.size()), "photographs of " + pose.name);
    written += PhotographPose(command, world, pose, progress);
  }
  Step(progress, 1, "done");
  return written;
}

}  // namespace keypose::synth
