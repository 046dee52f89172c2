// Options of `keypose landmarks suggest`.
#pragma once

#include <string>
#include <vector>

#include "core/values/options.h"
#include "register/intrinsic/suggest.h"

namespace keypose::registration {

struct LandmarksOptions {
  SuggestOptions suggest;
  std::string accept;
  std::string up = "z";
  int panel = 360;

  void Describe(OptionVisitor& visit) {
    visit("count", suggest.count,
          {"largest number of pairs to suggest, in addition to those given", "", 1, 1000, {}});
    visit("min_confidence", suggest.min_confidence,
          {"leave out suggestions with a lower confidence", "", 0, 1, {}});
    visit("proxy_vertices", suggest.proxy_vertices,
          {"size of the decimated meshes that are compared", "vertices", 100, 20000, {}});
    visit("samples", suggest.samples,
          {"points at which candidate maps are compared", "", 50, 5000, {}});
    visit("functions", suggest.functions,
          {"eigenfunctions that the last refinement uses", "", 20, 500, {}});
    visit("candidates", suggest.candidates,
          {"number of assignments of limbs to try", "", 1, 10000, {}});
    visit("accept", accept,
          {"confirm these pairs, by their numbers in the picture: 1,2,5-9, or all", "", 0, 0, {}});
    visit("up", up,
          {.help = "axis that points up in the picture", .unit = "", .choices = {"x", "y", "z"}});
    visit("panel", panel, {"width and height of each view in the picture", "px", 64, 4096, {}});
  }
  std::vector<std::string> Problems() const { return suggest.Problems(); }
};

}  // namespace keypose::registration
