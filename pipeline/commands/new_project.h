// The pipeline.yaml of a new project.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "core/io/text/pose_yaml.h"

namespace keypose::pipeline {

/// See kFewestOfAScan.
inline constexpr int kLeastScanPhotographs = kFewestOfAScan;

/// The filmed shot of a new project: paths as they shall stand in pipeline.yaml; empty: none.
struct NewShot {
  std::string film, plate, mattes, holdout;
  double fps = 12, animation_fps = 24;
  std::vector<std::pair<int, std::string>> shows;  ///< frame of the film, pose; ascending
};

/// Names the project after its folder. Each pose's photographs are in photos/POSE; with two poses
/// or more, the timeline shows them in this order.
/// @param few   those of the poses that are found with `method: fit`
/// @param shot  its frames give the timeline
std::string NewPipelineText(const std::filesystem::path& folder,
                            const std::vector<std::string>& poses, const std::string& template_pose,
                            const std::set<std::string>& few = {}, const NewShot& shot = {});

/// A pose whose mesh was made elsewhere: paths as they shall stand in pipeline.yaml.
struct NewMesh {
  std::string name, mesh;
  std::string texture;    ///< empty: it has none
  bool polygons = false;  ///< it has faces of more than three corners, which can be kept
};
/// How the poses of a project of meshes get their textures.
enum class MeshColors {
  kNone,
  kTemplates,  ///< the template's serves all
  kOwn,        ///< each has its own, in the layout that all have
  kCarried     ///< each pose's own colours are carried into the template's layout
};
struct NewMeshes {
  std::vector<NewMesh> poses;
  std::string template_pose;
  bool keep = false;        ///< the template's faces and texture coordinates stay
  bool same_faces = false;  ///< no pose is registered
  MeshColors colors = MeshColors::kNone;

  /// The mesh whose polygons are exported; null: triangles are.
  const NewMesh* template_polygons() const;
};
/// Switches the steps on photographs off.
std::string NewMeshesText(const std::filesystem::path& folder, const NewMeshes& meshes);

/// A new project's performance: paths as they shall stand in pipeline.yaml; empty: none.
struct NewPerformance {
  std::vector<std::pair<std::string, std::string>> shots;  ///< name, folder of films
  std::string calibration;                                 ///< of all shots
  std::string scan, texture, marks;
  bool video3d = false;  ///< the films are painted on what moves
  bool surface = false;  ///< what moves is bent into the films
};
std::string NewPerformanceText(const std::filesystem::path& folder,
                               const NewPerformance& performance);

/// @throws UsageError  the folder has anything in it
void RequireNoProject(const std::filesystem::path& folder);

}  // namespace keypose::pipeline
