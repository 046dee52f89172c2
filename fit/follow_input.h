// What the stage `follow` reads: frames of the moving mesh, the films, their cameras and masks.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/stage/stage.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "fit/following/follow.h"
#include "views/shot/synced_films.h"

namespace keypose::fit {

struct FollowInputOptions {
  std::string cameras;  ///< names that are used, comma-separated; empty: all
  int max_size = 1000;  ///< longer side to which pictures are scaled down [px]
};

class FollowInput {
 public:
  /// Reads the first frame, opens the films, matches both.
  /// @throws InputError  no masks; films that do not belong to the calibration; a mesh that is not
  /// where the films show the actor, or not in one of the cameras; says which and what to do
  FollowInput(StageContext& stage, const FollowInputOptions& options);

  /// The first frame, with the layout's UVs if given. Vertices that the frames double along seams
  /// of a texture are one here, so that its charts do not part.
  const Mesh& mesh() const { return mesh_; }
  const Mesh& given() const { return given_; }  ///< the same with the vertices that the frames have
  const std::vector<int>& of_given() const { return of_given_; }  ///< vertex of mesh() for each
  /// Points of the frames' vertices, from those of mesh().
  PointsX3 Opened(const PointsX3& points) const { return points(of_given_, Eigen::all); }
  int frames() const { return static_cast<int>(paths_.size()); }
  double frames_per_second() const { return rate_; }  ///< of the frames, else the films; or 0
  /// @throws InputError  other faces than the first frame has
  PointsX3 Points(int frame) const;
  /// Prepared views of several frames; those that show nothing of the actor are left out.
  std::vector<std::vector<PreparedView>> Views(int first, int count);
  /// The same without the pictures: their colours are the masks'.
  std::vector<std::vector<PreparedView>> MaskViews(int first, int count);
  FollowSource Source();
  /// The mesh's own texture; empty where none is given.
  const Image8& texture() const { return texture_; }

 private:
  void ReadFirst(StageContext& stage);
  void CloseSeams();
  void CheckPlaces();
  std::vector<std::vector<PreparedView>> Prepared(int first, int count, bool pictures);

  std::vector<std::filesystem::path> paths_;
  Mesh given_, mesh_;
  std::vector<int> of_given_, kept_;  // vertex of mesh_ for each given one, and the other way round
  Image8 texture_;
  std::optional<SyncedFilms> films_;
  int max_size_;
  double rate_ = 0;
};

}  // namespace keypose::fit
