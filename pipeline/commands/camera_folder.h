// Cameras with their photographs and masks, as a folder that other programs open.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/pictures/image_set.h"
#include "core/values/camera.h"
#include "core/values/progress.h"
#include "pipeline/disk/disk.h"

namespace keypose::pipeline {

enum class CameraFormat { kColmap, kTransforms, kMetashape };

/// "colmap", "transforms", "metashape": as the command line has them.
const std::vector<std::string>& CameraFormatNames();
/// @pre one of CameraFormatNames
CameraFormat CameraFormatOf(const std::string& name);

/// What goes into a folder.
struct CameraFolder {
  Scene scene;                           ///< views that have photographs, all of them trusted
  ImageSet images;                       ///< of the same names, in the same order
  std::vector<std::string> not_placed;   ///< photographs without a camera
  std::vector<std::string> not_trusted;  ///< photographs that capture.json does not trust

  /// Whether every photograph has a mask; else none is written, as programs want all or none.
  bool HasMasks() const;
};

/// Joins cameras and photographs by name. Photographs without a camera, and those that are not
/// trusted, are left out with their names; points that fewer than two of the other views see are
/// left out too.
/// @throws InputError  a camera without photograph, or for pictures of another size; no camera is
/// left
CameraFolder JoinedCameras(Scene scene, ImageSet images);

/// Writes into an empty folder: photographs and masks as they are, and
/// - colmap: sparse/0/{cameras,images,points3D}.{bin,txt}; masks as masks/a.jpg.png (COLMAP), and
///   masks/a.png (nerfstudio)
/// - transforms: transforms.json, and points.ply where there are points; masks/a.png
/// - metashape: cameras.xml; masks/a.png
/// Where two photographs differ in their ending alone, the names of masks keep it: a.jpg.png.
/// @param title  of the chunk in Metashape
/// @throws InputError  a name that the format cannot hold
/// @throws DiskError
/// @throws Cancelled  `progress` says so
void WriteCameraFolder(const CameraFolder& cameras, CameraFormat format, const std::string& title,
                       const std::filesystem::path& folder, Disk& disk, Progress* progress);

}  // namespace keypose::pipeline
