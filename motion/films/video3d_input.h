// What the stage `video3d` reads: frames of the moving mesh, the films, their cameras.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "core/stage/stage.h"
#include "motion/video3d/texture_sequence.h"
#include "views/shot/shot.h"

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
  ~Video3dInput();

  /// Faces and UVs, and the shape of the first frame.
  const Mesh& mesh() const { return meshes_.front(); }
  const std::vector<Mesh>& meshes() const { return meshes_; }  ///< one per frame, UVs of the first
  const std::vector<View>& views() const { return views_; }
  const Eigen::Vector3d& up() const { return up_; }   ///< unit
  double frames_per_second() const { return rate_; }  ///< of the frames, else the films; or 0
  /// Pictures and masks of a frame; cameras are read side by side.
  FilmedFrame Read(int frame);

 private:
  void ReadMeshes(StageContext& stage);
  void OpenFilms(StageContext& stage, const Video3dInputOptions& options);
  void ReadClocks(StageContext& stage);
  void CheckLengths(StageContext& stage);
  void CheckSizes();
  void CheckPlaces(StageContext& stage);

  struct CameraFilm {
    ShotCamera files;
    std::unique_ptr<FrameReader> pictures, masks;  // masks: may be null
    int offset = 0;                                // frame f of the mesh is frame f + offset
  };
  std::vector<Mesh> meshes_;
  std::vector<View> views_;
  std::vector<CameraFilm> films_;
  Eigen::Vector3d up_ = Eigen::Vector3d::UnitZ();
  double rate_ = 0;
};

}  // namespace keypose::motion
