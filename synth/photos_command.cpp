#include "synth/photos_command.h"

#include <utility>

#include "core/errors.h"
#include "core/io/image_io.h"
#include "core/parallel.h"
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

int PhotographPose(const PhotosCommand& command, const World& world, const Pose& pose, Progress* progress) {
  const std::filesystem::path photos = command.output / "photos" / pose.name, truth_folder = command.output / "truth" / pose.name;
  MakeFolder(photos);
  MakeFolder(truth_folder / "masks");
  const Photographer photographer(world, pose, command.photographer);
  const ExifToWrite exif = ExifOf(command.photographer);
  std::vector<SyntheticView> views(photographer.view_count());
  // One photograph a thread: encoding JPEG uses one core only.
  const auto take = [&](std::int64_t i) {
    if (progress && progress->cancelled()) throw Cancelled();
    SyntheticView view = photographer.Take(static_cast<int>(i));
    WriteImage(photos / view.view.name, view.image, command.jpeg_quality, &exif);
    WriteImage(truth_folder / "masks" / (view.view.name + ".png"), view.mask);
    views[i].view = std::move(view.view);
  };
  ParallelFor(photographer.view_count(), take);
  const Truth truth{TruthScene(world, pose, views), photographer.surface(), world.landmarks};
  WriteTruth(truth_folder, truth, world, pose, command.world, command.photographer);
  if (command.background_plate) {
    MakeFolder(command.output / "background");
    WriteImage(command.output / "background" / (pose.name + ".jpg"), photographer.BackgroundPlate(), command.jpeg_quality, &exif);
  }
  return photographer.view_count();
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
