// What the stage `video3d` reads: frames of the moving mesh, the films, their cameras.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/stage/stage.h"
#include "core/values/mesh.h"
#include "motion/video3d/texture_sequence.h"
#include "views/shot/synced_films.h"

namespace keypose::motion {

struct Video3dInputOptions {
  std::string cameras;      ///< names that are used, comma-separated; empty: all
  std::string up = "auto";  ///< auto, x, y, z, -x, -y, -z
};

class Video3dInput {
 public:
  /// Reads the meshes, opens the films, matches both to the calibration.
  /// @throws InputError  no texture coordinates; films without calibration or of other sizes;
  /// cameras that do not see the mesh; says which and what to do
  Video3dInput(StageContext& stage, const Video3dInputOptions& options);

  /// Faces and UVs, and the shape of the first frame.
  const Mesh& mesh() const { return meshes_.front(); }
  const std::vector<Mesh>& meshes() const { return meshes_; }  ///< one per frame, UVs of the first
  const std::vector<View>& views() const { return films_->views(); }
  const Eigen::Vector3d& up() const { return up_; }   ///< unit
  double frames_per_second() const { return rate_; }  ///< of the frames, else the films; or 0
  /// Pictures and masks of a frame.
  FilmedFrame Read(int frame);

 private:
  void ReadMeshes(StageContext& stage);
  void CheckPlaces(StageContext& stage);

  std::vector<Mesh> meshes_;
  std::optional<SyncedFilms> films_;
  Eigen::Vector3d up_ = Eigen::Vector3d::UnitZ();
  double rate_ = 0;
};

}  // namespace keypose::motion
