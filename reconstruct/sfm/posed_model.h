// Models from cameras that are known before any feature is matched: by the printed calibration
// board, or given by the user. Also both halves of a figure shot upright and lying.
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

/// The board as the photographs of a set show it.
struct SetBoards {
  /// The photographs of one placement of the figure, on its own plate or none.
  struct Group {
    std::string name;
    std::vector<std::string> images;
    std::vector<BoardSighting> sightings;
    BoardPoses poses;  ///< in this group's plate's frame
  };
  bool calibrate = false;     ///< the board is seen from such different heights that it tells the
                              ///< principal point too
  std::vector<Group> groups;  ///< the first one's frame is the world: "upright" if there is one,
                              ///< else the first by name
  int views() const;
};

/// Groups the set's photographs, and places those that show the board. Reports board_views,
/// board_rms_px.
SetBoards PlaceBoards(StageContext& stage, const ImageSet& set, const Camera& camera,
                      bool focal_known, const SfmOptions& options);

/// A model with what it was made from.
struct PosedModel {
  Scene scene;
  std::vector<Observation> observations;  ///< of scene.points
  Bodies bodies;                          ///< plates; none for poses given by the user
  std::string scale_source = "none";      ///< of a frame that must stay: "plate" or "poses"
  bool fixed = false;                     ///< cameras must stay as they are
  bool calibrate = false;                 ///< as SetBoards::calibrate
};

/// What a model's last adjustment solves for.
BundleOptions BundleFor(const PosedModel& model, const SfmOptions& options);

/// From cameras given by the user (the port `poses`).
/// @throws InputError  names that are not in the
/// set, other sizes
/// @param measurements  added to: known_poses
PosedModel ModelFromPoses(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                          const std::vector<Features>& features, const SfmOptions& options,
                          Measurements& measurements);

/// From the plates, where enough photographs show one; the groups' models are joined by their
/// points.
/// @param measurements  added to: how the groups were joined
std::optional<PosedModel> ModelFromBoards(StageContext& stage, const ImageSet& set,
                                          const SfmFiles& files, const MatchedFeatures& matched,
                                          const SetBoards& boards, const SfmOptions& options,
                                          Measurements& measurements);

/// The largest of the mapper's models, with the others joined to it where their points agree, and
/// taken into the board's frame where three of its views show it. Empty scene when the mapper found
/// none.
/// @param models  of the mapper, most images first
/// @param measurements  added to: how the models were joined
PosedModel ModelFromMapper(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                           const MatchedFeatures& matched, const std::vector<ColmapModel>& models,
                           const SetBoards& boards, const SfmOptions& options,
                           Measurements& measurements);

}  // namespace keypose::reconstruct
