// The lens models of COLMAP, by name and by number.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/values/lens.h"

namespace keypose {

/// Name and number of parameters of a model of COLMAP.
struct ColmapLensModel {
  int id;
  std::string name;
  int parameters;
};

/// Those of COLMAP 3.8, and the newer ones up to 4.2 (src/colmap/sensor/models); BROWN_CONRADY,
/// which is newer still, by name only.
std::vector<ColmapLensModel> ColmapLensModels();

/// @return none: no such model, or of no number
std::optional<ColmapLensModel> FindColmapModel(const std::string& name);
std::optional<ColmapLensModel> FindColmapModel(int id);

/// @param parameters  in COLMAP's order, as many as the model has
/// @param where  file and camera, for messages
/// @throws InputError  another number of parameters; EQUIRECTANGULAR, which is a panorama
Lens ColmapLens(const ColmapLensModel& model, const std::vector<double>& parameters,
                const std::string& where);

}  // namespace keypose
