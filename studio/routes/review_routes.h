// Review: the results of two runs beside each other, and what was said of them.
#pragma once

#include "studio/routes/page_routes.h"

namespace keypose::studio {

class ReviewRoutes final : public PageRoutes {
 public:
  using PageRoutes::PageRoutes;
  void AddTo(RouteTable& table) override;

 private:
  void AddPictures(RouteTable& table);
  void AddWords(RouteTable& table);
  bool IsRunning();
  std::vector<std::string> RunRecords() const;
};

}  // namespace keypose::studio
