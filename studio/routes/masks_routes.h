// Masks of photographs: shown, mended, kept for newer photographs.
#pragma once

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class MasksRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;
};

}  // namespace keypose::studio
