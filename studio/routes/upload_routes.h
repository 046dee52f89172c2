// Files that a page sends in pieces: films, a scan, a calibration, a puppet.
#pragma once

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class UploadRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;
};

}  // namespace keypose::studio
