// Models from cameras that are known before features are matched: from the printed calibration
// board, or given by the user. Also joins the models of a figure shot upright and lying.
#pragma once

#include <optional>
#include <string>

#include "core/stage/stage.h"
#include "reconstruct/known/board_cameras.h"
#include "reconstruct/sfm/colmap_programs.h"
#include "reconstruct/sfm/matched_features.h"
#include "reconstruct/sfm/measurements.h"

namespace keypose {
struct ImageSet;
}

namespace keypose::reconstruct {

/// The board in the photographs of a set.
struct SetBoards {
  /// The photographs of one placement of the figure, on its own board or none.
  struct Group {
    std::string name;
    std::vector<std::string> images;
    std::vector<BoardSighting> sightings;
    BoardPoses poses;  ///< in the frame of this group's board
  };
  bool calibrate = false;     ///< the board is seen at such different tilts that it also determines
                              ///< the principal point
  std::vector<Group> groups;  ///< the first one's frame is the world: "upright" if there is one,
                              ///< else the first by name
  int views() const;
};

/// Groups the set's photographs, and estimates the poses of those that show the board. Reports
/// board_views, board_rms_px.
/// @param matched  whose lenses are the start
SetBoards PlaceBoards(StageContext& stage, const ImageSet& set, const MatchedFeatures& matched,
                      const SfmOptions& options);

/// A model with the data it was made from.
struct PosedModel {
  Scene scene;
  std::vector<Observation> observations;  ///< of scene.points
  Bodies bodies;                          ///< boards; none for poses given by the user
  std::string scale_source = "none";      ///< why the frame must stay: "board" or "poses"
  bool fixed = false;                     ///< cameras must not change
  bool calibrate = false;                 ///< as SetBoards::calibrate
};

/// Which parameters a model's last adjustment solves for.
BundleOptions BundleFor(const PosedModel& model, const SfmOptions& options);

/// The cameras given by the user (the port `poses`) under the names of the photographs.
/// @throws InputError  names that are not in the set, other sizes
std::vector<View> KnownViews(StageContext& stage, const ImageSet& set);

/// What every model is made from.
struct ModelInput {
  StageContext& stage;
  const ImageSet& set;
  const SfmFiles& files;
  const MatchedFeatures& matched;
  const SfmOptions& options;
  Measurements& measurements;  ///< added to: known_poses, and how models were joined
};

/// From cameras given by the user (the port `poses`).
/// @throws InputError  names that are not in the set, other sizes
PosedModel ModelFromPoses(const ModelInput& in);

/// From the calibration boards, if enough photographs show one. The groups' models are joined by
/// their points.
std::optional<PosedModel> ModelFromBoards(const ModelInput& in, const SetBoards& boards);

/// The largest of the mapper's models, joined with the others whose points agree, and transformed
/// into the board's frame if three of its views show the board. The scene is empty if the mapper
/// found none.
/// @param models  of the mapper, most images first
PosedModel ModelFromMapper(const ModelInput& in, const std::vector<ColmapModel>& models,
                           const SetBoards& boards);

}  // namespace keypose::reconstruct
