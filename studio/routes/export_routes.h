// What was made: the files of out/, the report, the folder in the desktop's file manager.
#pragma once

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class ExportRoutes : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;

 private:
  Answer ResultFile(const Question& question) const;
};

}  // namespace keypose::studio
