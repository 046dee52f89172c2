// Options of keypose-register.
#pragma once

#include <string>
#include <vector>

#include "core/values/options.h"
#include "register/auto/auto_registration.h"
#include "register/nricp/nricp.h"

namespace keypose::registration {

struct RegisterOptions {
  std::string method = "auto";
  AutoOptions automatic;
  NricpOptions nricp;
  double max_surface_rms = 1;    ///< over the diagonal; a higher value throws QualityError
  double max_flipped_share = 1;  ///< of clearly flipped faces; a higher value throws QualityError
  /// Write the result even if parts that touch in the template should separate in the pose
  bool allow_fused = false;

  void Describe(OptionVisitor& visit) {
    visit("method", method,
          {.help = "auto: coarse to fine, also for large turns; nricp: the paper's non-rigid ICP",
           .unit = "",
           .choices = {"auto", "nricp"}});
    visit("coarse_vertices", automatic.coarse_vertices,
          {"auto: size of the decimated template on which starts are tried",
           "vertices",
           50,
           1e6,
           {}});
    visit("middle_vertices", automatic.middle_vertices,
          {"auto: size of the decimated template that is first pulled to the surface",
           "vertices",
           50,
           1e6,
           {}});
    visit("landmark_weight", automatic.landmark_weight,
          {"auto: weight of a landmark at the start, relative to the shape term", "", 0, 1e6, {}});
    visit("landmark_weight_end", automatic.landmark_weight_end,
          {"auto: weight of a landmark at the end, relative to the shape term", "", 0, 1e6, {}});
    visit("smoothing", automatic.smoothing,
          {"auto: distance over which neighbouring parts bend alike", "diagonal", 0, 1, {}});
    visit("good_fit", automatic.good_fit,
          {"auto: the shape stays stiff when the surfaces are already this close",
           "diagonal",
           0,
           1,
           {}});
    visit("poor_fit", automatic.poor_fit,
          {"auto: another start is tried when the surfaces end further apart than this",
           "diagonal",
           0,
           1,
           {}});
    visit("suggest", automatic.suggest,
          {"auto: with fewer than 4 landmarks or a poor fit, also start from intrinsic geometry",
           "",
           0,
           1,
           {}});
    visit("skeleton", automatic.skeleton,
          {"auto: with fewer than 4 landmarks and a poor fit, also start from curve skeletons",
           "",
           0,
           1,
           {}});
    visit("max_surface_rms", max_surface_rms,
          {"fail when the surface distance is larger, over the diagonal", "", 0, 1, {}});
    visit("max_flipped_share", max_flipped_share,
          {"fail when a larger share of faces is clearly flipped", "", 0, 1, {}});
    visit("allow_fused", allow_fused,
          {"write the result even if parts that touch in the template should separate in the pose",
           "",
           0,
           1,
           {}});
  }
  std::vector<std::string> Problems() const { return automatic.Problems(); }
};

}  // namespace keypose::registration
