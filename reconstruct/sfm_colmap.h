// COLMAP's programs as steps of sfm, run so that their results never depend on threads. Defined in sfm_colmap_stage.cpp.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/image_set.h"
#include "core/stage/stage.h"
#include "reconstruct/bundle_adjustment.h"
#include "reconstruct/colmap_database.h"
#include "reconstruct/sfm_options.h"

namespace keypose::reconstruct {

/// Files of one run, in the stage's scratch folder.
struct SfmFiles {
  std::filesystem::path scratch, images, masks, database;
};

/// Writes masks grown by the margin, where COLMAP looks for them.
void WriteFeatureMasks(const ImageSet& set, const SfmFiles& files, int margin_px);

/// SIFT features of all images into the database.
void ExtractFeatures(StageContext& stage, const ImageSet& set, const SfmFiles& files, const SfmOptions& options);

/// Geometric verification of raw matches. COLMAP's RANSAC draws from a generator that each thread keeps, so the pairs are split into a
/// fixed number of parts, each verified by a process of one thread on a database of its own; then the parts are joined in pair order.
void VerifyMatches(StageContext& stage, const SfmFiles& files, const std::vector<PairMatches>& matches, const SfmOptions& options);

/// Incremental mapping on one thread (sums over threads depend on their number). @return model folders, most images first
std::vector<std::filesystem::path> MapImages(StageContext& stage, const SfmFiles& files, const SfmOptions& options);

/// The features that COLMAP joined into the points of a model.
/// @param scene  the same model as ReadColmapModel gives it
/// @param features  of all images of the set
std::vector<Observation> ReadObservations(const std::filesystem::path& model, const ImageSet& set, const Scene& scene,
                                          const std::vector<Features>& features);

/// What `colmap model_analyzer` says, as name and number.
std::vector<std::pair<std::string, double>> AnalyzeModel(StageContext& stage, const std::filesystem::path& model);

}  // namespace keypose::reconstruct
