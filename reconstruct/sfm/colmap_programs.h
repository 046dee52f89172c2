// COLMAP's programs as steps of sfm, run so that their results never depend on threads.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/image_set.h"
#include "core/stage/stage.h"
#include "reconstruct/bundle/bundle_adjustment.h"
#include "reconstruct/join/model_alignment.h"
#include "reconstruct/matching/colmap_database.h"
#include "reconstruct/sfm/sfm_options.h"

namespace keypose::reconstruct {

/// Files of one run, in the stage's scratch folder.
struct SfmFiles {
  std::filesystem::path scratch, images, database;
};

/// SIFT features of all images into the database, sought in the photographs cut to their masks.
/// Photographs without a mask are looked at whole.
/// @throws InputError a mask of another size than
/// its photograph
/// @param fine  also at twice the photographs' size, which is where four of five features come from
/// and most of the time goes
void ExtractFeatures(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                     const SfmOptions& options, bool fine);

/// A model as COLMAP wrote it.
struct ColmapModel {
  Scene scene;
  std::vector<TrackElement> tracks;  ///< of scene.points, by point
};

/// Incremental mapping on one thread (sums over threads depend on their number).
/// @return most
/// images first
std::vector<ColmapModel> MapImages(StageContext& stage, const SfmFiles& files,
                                   const SfmOptions& options);

/// Points seen by images whose cameras are known, by COLMAP's point_triangulator on one thread;
/// then images that `views` lacks are placed by these points, as far as they can be
/// (image_registrator), and triangulated too. Cameras that are given do not move.
/// @param views  with names of the set; cameras may differ
ColmapModel TriangulateKnown(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                             const std::vector<View>& views, const std::string& name,
                             const SfmOptions& options);

/// The features that COLMAP joined into the points of a model.
/// @param features  of all images of the set
std::vector<Observation> ObservationsOf(const ColmapModel& model, const ImageSet& set,
                                        const std::vector<Features>& features);

/// What `colmap model_analyzer` says, as name and number.
std::vector<std::pair<std::string, double>> AnalyzeModel(StageContext& stage,
                                                         const std::filesystem::path& model);

}  // namespace keypose::reconstruct
