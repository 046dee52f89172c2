// Cameras of photographs whose own features leave doubt, looked for on all sides of the template.
#pragma once

#include <vector>

#include "core/values/image.h"
#include "core/values/mesh.h"
#include "core/values/progress.h"
#include "fit/cameras/candidates.h"
#include "fit/cameras/find_cameras.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

/// The camera of one photograph, of all sides of the mesh: outlines and colours in small tell which
/// to try, features near where a render has them how good each is, and where it stands exactly.
/// The photograph's matches become those near the template under that camera.
/// @return whether one was found; else the camera stays as it was
bool FindAllRound(const CandidateJudge& judge, const Mesh& mesh, const PreparedView& view,
                  FoundCamera& camera);

/// All photographs, whether or not they have a camera: a camera by few features, most of which
/// disagree, may be any.
///
/// @param mesh     the template
/// @param texture  RGB
/// Same bits for any thread count.
std::vector<FoundCamera> FindCamerasAround(const Mesh& mesh, const Image8& texture,
                                           const std::vector<PreparedView>& views,
                                           std::vector<FoundCamera> cameras,
                                           Progress* progress = nullptr);

}  // namespace keypose::fit
