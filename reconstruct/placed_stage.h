// Models from cameras that are known before any feature is matched: by the printed plate, or given by the user. Also both halves of a
// figure shot upright and lying. Defined in placed_stage.cpp, which may touch files.
#pragma once

#include <optional>
#include <string>

#include "core/stage/stage.h"
#include "reconstruct/board_poses.h"
#include "reconstruct/sfm_colmap.h"

namespace keypose {
struct ImageSet;
}

namespace keypose::reconstruct {

/// The plate as the photographs of a set show it.
struct SetBoards {
  /// The photographs of one placement of the figure, on its own plate or none.
  struct Group {
    std::string name;
    std::vector<std::string> images;
    std::vector<BoardSighting> sightings;
    BoardPoses poses;  ///< in this group's plate's frame
  };
  bool calibrate = false;     ///< the plate is seen from such different heights that it tells the principal point too
  std::vector<Group> groups;  ///< the first one's frame is the world: "upright" if there is one, else the first by name
  int views() const;
};

/// Groups the set's photographs, and places those that show the plate. Reports board_views, board_rms_px.
SetBoards PlaceBoards(StageContext& stage, const ImageSet& set, const Camera& camera, bool focal_known, const SfmOptions& options);

/// A model with what it was made from.
struct PlacedModel {
  Scene scene;
  std::vector<Observation> observations;  ///< of scene.points
  Bodies bodies;                          ///< plates; none for poses given by the user
  std::string scale_source = "none";      ///< of a frame that must stay: "plate" or "poses"
  bool fixed = false;                     ///< cameras must stay as they are
  bool calibrate = false;                 ///< as SetBoards::calibrate
};

/// What a model's last adjustment solves for.
BundleOptions BundleFor(const PlacedModel& model, const SfmOptions& options);

/// From cameras given by the user (the port `poses`). @throws InputError  names that are not in the set, other sizes
PlacedModel ModelFromPoses(StageContext& stage, const ImageSet& set, const SfmFiles& files, const std::vector<Features>& features,
                           const SfmOptions& options);

/// What was seen in the photographs: features, and raw matches of pairs, however few.
struct SeenInSet {
  const std::vector<Features>& features;
  const std::vector<PairMatches>& matches;
};

/// From the plates, where enough photographs show one; the groups' models are joined by their points.
std::optional<PlacedModel> ModelFromBoards(StageContext& stage, const ImageSet& set, const SfmFiles& files, const SeenInSet& seen,
                                           const SetBoards& boards, const SfmOptions& options);

/// The largest of the mapper's models, with the others joined to it where their points agree, and taken into the plate's frame where three
/// of its views show it. Empty scene when the mapper found none.
PlacedModel ModelFromMapper(StageContext& stage, const ImageSet& set, const SfmFiles& files, const SeenInSet& seen,
                            const std::vector<std::filesystem::path>& models, const SetBoards& boards, const SfmOptions& options);

}  // namespace keypose::reconstruct
