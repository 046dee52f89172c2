// How the figure of the template was moved on the rig before a pose was photographed there.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/mesh.h"
#include "fit/cameras/find_cameras.h"
#include "fit/cameras/rig_motion.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

/// Recognises the rig, without regard to the order of photographs. First the one motion of the
/// figure under which most matches agree with cameras of the rig. A photograph whose own estimate
/// follows the head where others follow the body still has matches on the body. Of motions that are
/// nearly as good the least is taken: on an even turntable a figure turned by one step looks like
/// one that stayed, under the next camera.
///
/// The half of a figure that has more texture may have turned. So, unless the first motion is
/// clear and is that the figure stayed, others follow that can be tried too: that it stayed, if two
/// photographs agree, and the one with which most photographs agree, if it is half of them.
///
/// @return empty if no camera was found
/// Same bits for any thread count.
std::vector<RigMotion> FindRigMotions(const Mesh& mesh, const std::vector<FoundCamera>& cameras,
                                      const std::vector<PreparedView>& views,
                                      const std::vector<View>& rig);

/// The rig's cameras in place of the found ones. Photographs that agree with none have none.
std::vector<FoundCamera> CamerasUnder(const RigMotion& motion, const std::vector<View>& rig,
                                      std::vector<FoundCamera> cameras);

}  // namespace keypose::fit
