// Poses and their photographs, and the changes of both; cameras, meshes and textures; the bin.
#pragma once

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class PosesRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;

 private:
  void AddPhotographs(RouteTable& table);
  void AddPhotographChanges(RouteTable& table);
  void AddPoseChanges(RouteTable& table);
  void AddBin(RouteTable& table);
  void AddMeshes(RouteTable& table);
  void AddTextures(RouteTable& table);
  /// The answer to a change of the project's files, which no run may be reading.
  template <class Change>
  Answer Changed(const Change& change);
};

}  // namespace keypose::studio
