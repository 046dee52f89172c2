// Cameras of photographs that show little of what decided the other cameras, once these have bent
// the template to nearly the pose.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "core/values/progress.h"
#include "fit/cameras/find_cameras.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

/// Looks for cameras of the photographs that have none: among the rig's, or, where no rig was
/// found, by the photograph's features on the bent mesh. The one is taken under which most features
/// match near where a render of the mesh has them; few are enough where the silhouette agrees too.
/// These matches, and those that agreed with one rigid part, replace the photograph's.
///
/// @param mesh     the bent template, in the frame of the cameras
/// @param texture  RGB
/// @param rig      empty: no rig
/// @return how many were found
/// Same bits for any thread count.
int FindLateCameras(const Mesh& mesh, const Image8& texture, const std::vector<PreparedView>& views,
                    const std::vector<View>& rig, std::vector<FoundCamera>& cameras,
                    Progress* progress = nullptr);

/// Without a texture: gives photographs without a camera that of the rig's whose silhouette
/// overlaps most with the mask, each of the rig's once, the best overlap first. From before and
/// from behind, a figure with two equal halves may have the same outline: look at the result.
///
/// @param mesh  the template, where it stood on the rig
/// @return how many were found
/// Same bits for any thread count.
int PlaceByOutlines(const Mesh& mesh, const std::vector<PreparedView>& views,
                    const std::vector<View>& rig, std::vector<FoundCamera>& cameras);

}  // namespace keypose::fit
