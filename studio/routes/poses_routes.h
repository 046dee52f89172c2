// Photographs, cameras, meshes and textures of the poses.
#pragma once

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class PosesRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;

 private:
  void AddPhotographs(RouteTable& table);
  void AddMeshes(RouteTable& table);
  void AddTextures(RouteTable& table);
};

}  // namespace keypose::studio
