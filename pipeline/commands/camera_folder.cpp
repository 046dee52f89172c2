#include "pipeline/commands/camera_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/io/project/colmap_write.h"
#include "core/io/project/metashape_write.h"
#include "core/io/project/transforms_write.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr int kLeastViews = 2;  // that a point needs to have a place

void RequirePhotographs(const Scene& scene, const ImageSet& images) {
  for (const View& view : scene.views) {
    const int i = images.Find(view.name);
    if (i < 0)
      throw InputError(fmt::format("there is a camera of {}, but {} has no such photograph",
                                   view.name, images.folder.string()));
    const CapturedImage& image = images.images[static_cast<std::size_t>(i)];
    if (image.width != view.camera.width || image.height != view.camera.height)
      throw InputError(
          fmt::format("the camera of {} is for {} x {} pixels, but the photograph has {} x {}",
                      view.name, view.camera.width, view.camera.height, image.width, image.height));
  }
}

/// The views of these names, and the points that enough of them see.
Scene OnlyViews(const Scene& scene, const std::set<std::string>& names) {
  Scene kept;
  std::vector<int> now(scene.views.size(), -1);
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    if (!names.contains(scene.views[v].name)) continue;
    now[v] = SizeOf(kept.views);
    kept.views.push_back(scene.views[v]);
  }
  for (SparsePoint point : scene.points) {
    for (int& v : point.views) v = now[static_cast<std::size_t>(v)];
    std::erase(point.views, -1);
    if (SizeOf(point.views) >= kLeastViews) kept.points.push_back(std::move(point));
  }
  return kept;
}

/// The names without their endings, or all whole where two would be equal.
std::vector<std::string> ShortNames(const std::vector<CapturedImage>& images) {
  std::vector<std::string> whole, stems;
  for (const CapturedImage& image : images) {
    whole.push_back(image.name);
    stems.push_back(fs::path(image.name).stem().string());
  }
  const bool unique = std::set<std::string>(stems.begin(), stems.end()).size() == stems.size();
  return unique ? stems : whole;
}

void WriteTransforms(const CameraFolder& cameras, const std::vector<std::string>& masks,
                     const fs::path& folder) {
  std::vector<TransformsFrame> frames;
  for (std::size_t i = 0; i < masks.size(); ++i)
    frames.push_back({"images/" + cameras.images.images[i].name, masks[i]});
  const Scene& scene = cameras.scene;
  const char* points = scene.points.empty() ? "" : "points.ply";
  WriteFile(folder / "transforms.json", TransformsText(scene.views, frames, points));
  if (*points) WriteFile(folder / points, SparsePlyText(scene.points));
}

}  // namespace

const std::vector<std::string>& CameraFormatNames() {
  static const std::vector<std::string> names{"colmap", "transforms", "metashape"};
  return names;
}

CameraFormat CameraFormatOf(const std::string& name) {
  const auto& names = CameraFormatNames();
  return static_cast<CameraFormat>(std::find(names.begin(), names.end(), name) - names.begin());
}

bool CameraFolder::HasMasks() const {
  return std::none_of(images.images.begin(), images.images.end(),
                      [](const CapturedImage& image) { return image.mask.empty(); });
}

CameraFolder JoinedCameras(Scene scene, ImageSet images) {
  RequirePhotographs(scene, images);
  CameraFolder joined;
  std::set<std::string> placed, kept;
  for (const View& view : scene.views) placed.insert(view.name);
  for (const CapturedImage& image : images.images) {
    if (!placed.contains(image.name))
      joined.not_placed.push_back(image.name);
    else if (!image.trusted)
      joined.not_trusted.push_back(image.name);
    else
      kept.insert(image.name);
  }
  if (kept.empty()) throw InputError("none of the photographs has a camera that is to be trusted");
  joined.scene = OnlyViews(scene, kept);
  std::erase_if(images.images,
                [&](const CapturedImage& image) { return !kept.contains(image.name); });
  joined.images = std::move(images);
  return joined;
}

void WriteCameraFolder(const CameraFolder& cameras, CameraFormat format, const std::string& title,
                       const fs::path& folder, Disk& disk, Progress* progress) {
  const std::vector<CapturedImage>& images = cameras.images.images;
  const std::vector<std::string> names = ShortNames(images);
  const bool masked = cameras.HasMasks();
  std::vector<std::string> masks;
  for (const std::string& name : names) masks.push_back(masked ? "masks/" + name + ".png" : "");
  if (format == CameraFormat::kColmap) {
    disk.MakeFolder(folder / "sparse" / "0");
    WriteColmapForOthers(folder / "sparse" / "0", cameras.scene);
  }
  if (format == CameraFormat::kTransforms) WriteTransforms(cameras, masks, folder);
  if (format == CameraFormat::kMetashape)
    WriteFile(folder / "cameras.xml", MetashapeText(cameras.scene.views, names, title));
  for (std::size_t i = 0; i < images.size(); ++i) {
    ReportProgress(progress, static_cast<double>(i) / static_cast<double>(images.size()), "copies");
    disk.Copy(cameras.images.ImagePath(static_cast<int>(i)), folder / "images" / images[i].name);
    if (!masked) continue;
    const fs::path mask = cameras.images.MaskPath(static_cast<int>(i));
    disk.Copy(mask, folder / masks[i]);
    const fs::path of_colmap = folder / "masks" / (images[i].name + ".png");
    if (format == CameraFormat::kColmap && of_colmap != folder / masks[i])
      disk.Copy(mask, of_colmap);
  }
}

}  // namespace keypose::pipeline
